//! What the window says, in the language that is chosen. Texts stand in `en.ftl` and `de.ftl` by their ids, and nowhere else.
//!
//! `t!` says one at once. What comes from threads, or stays on the screen, is a [`Message`], which knows no language
//! until it is shown. What the library says in English is recognised ([`heard`](heard())). The window's thread holds the language;
//! other threads never say anything themselves.

mod choice;
mod heard;
mod language;
mod number;
mod order;
mod said;
#[cfg(test)]
mod tests;

use std::cell::Cell;

pub use choice::{all, best, speak};
pub use heard::heard;
pub use language::Language;
pub use number::{decimal, number, shortest, typed, with_sign};
pub use said::{Argument, Id, Message, capital, fixed, signed};

thread_local! {
    static SPOKEN: Cell<Option<&'static Language>> = const { Cell::new(None) };
}

/// The language of this thread, which is the window's: English until one is chosen.
pub fn spoken() -> &'static Language {
    SPOKEN.get().unwrap_or_else(Language::english)
}

/// A text without arguments, in the language of the window: borrowed, so that it costs a look-up.
pub fn text(id: &'static str) -> &'static str {
    spoken().plain(id).or_else(|| Language::english().plain(id)).unwrap_or(id)
}

/// A text by its id: `t!("open")` is a `&'static str`, `t!("views", count = 3)` a `String`.
macro_rules! t {
    ($id:literal) => { $crate::ui::words::text($id) };
    ($id:literal, $($name:ident = $value:expr),+ $(,)?) => {
        $crate::ui::words::message!($id, $($name = $value),+).text()
    };
}

/// As [`t!`], to be said later: in the language that is spoken then.
macro_rules! message {
    ($id:literal $(, $name:ident = $value:expr)* $(,)?) => {
        $crate::ui::words::Message::new($id, vec![$((stringify!($name), $crate::ui::words::Argument::from($value))),*])
    };
}

/// The id of a text that a table holds.
macro_rules! id {
    ($id:literal) => {
        $crate::ui::words::Id($id)
    };
}

pub(crate) use {id, message, t};
