//! Errors as a person reads them, for every front door.

use std::error::Error;

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

#[cfg(test)]
mod tests {
    use super::*;

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
