//! Errors as a person reads them, for every front door.

use std::error::Error;
use std::fmt::Display;

use crate::within;

/// An error with its causes, as one sentence; a cause that the error's own text already holds is not repeated.
pub fn sentence(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        let inner_text = inner.to_string();
        if !text.contains(&inner_text) {
            text = format!("{text}: {inner_text}");
        }
        cause = inner.source();
    }
    text
}

/// A message without line breaks and what else a terminal obeys, as every front door shows it.
pub fn one_line(message: &impl Display) -> String {
    let plain = message.to_string().replace(within::is_odd, " ");
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line() {
        assert_eq!(one_line(&"cannot open \u{1b}[31mx"), "cannot open [31mx");
        assert_eq!(one_line(&"cannot do\n  that — because\r\nof this"), "cannot do that — because of this");
    }

    #[derive(Debug, thiserror::Error)]
    #[error("cannot read it: disk on fire")]
    struct Told(#[source] std::io::Error);

    #[derive(Debug, thiserror::Error)]
    #[error("cannot begin")]
    struct Outer(#[source] Told);

    #[test]
    fn each_cause_is_said_once() {
        let error = Outer(Told(std::io::Error::other("disk on fire")));
        assert_eq!(sentence(&error), "cannot begin: cannot read it: disk on fire");
    }
}
