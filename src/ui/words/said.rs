//! A text that is said later, and what it is said of.

use std::path::Path;

use fluent_bundle::types::{FluentNumber, FluentNumberOptions};
use fluent_bundle::{FluentArgs, FluentValue};

use super::{Language, SPOKEN, heard, order, spoken, text};

/// The id of a text without arguments, in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Id(pub &'static str);

impl Id {
    /// The text.
    pub fn text(self) -> &'static str {
        text(self.0)
    }

    /// What else is said of it, under the pointer.
    pub fn hint(self) -> &'static str {
        let (key, english) = (format!("{}.hint", self.0), Language::english());
        spoken().plain(&key).or_else(|| english.plain(&key)).unwrap_or_default()
    }
}

impl From<Id> for Message {
    fn from(id: Id) -> Self {
        Self::new(id.0, Vec::new())
    }
}

/// A text that knows no language until it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Message(Words);

#[derive(Clone, Debug, PartialEq)]
enum Words {
    /// A text by its id, with what it is said of.
    Ours(&'static str, Vec<(&'static str, Argument)>),
    /// What the library said, in English.
    Heard(String),
}

/// What a text is said of.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A name, a path, what others said: as it is.
    Text(String),
    /// A number with so many decimals.
    Number(f64, usize),
    /// The same with its sign.
    Signed(f64, usize),
    /// A part of the sentence.
    Said(Box<Message>),
}

/// A number with so many decimals.
pub fn fixed(value: impl Into<f64>, decimals: usize) -> Argument {
    Argument::Number(value.into(), decimals)
}

/// A number with its sign, as people write it: `+0.18`, `−0.40`.
pub fn signed(value: impl Into<f64>, decimals: usize) -> Argument {
    Argument::Signed(value.into(), decimals)
}

impl Message {
    /// See `message!`, which is the way to make one.
    pub fn new(id: &'static str, arguments: Vec<(&'static str, Argument)>) -> Self {
        Self(Words::Ours(id, arguments))
    }

    /// What the library said.
    pub fn heard(text: impl Into<String>) -> Self {
        Self(Words::Heard(text.into()))
    }

    /// In the language of the window.
    pub fn text(&self) -> String {
        let language = spoken();
        let text = self.logical(language);
        if language.is_leftward() { order::visual(&text) } else { text }
    }

    /// In English with its numbers, as logs are.
    pub fn in_english(&self) -> String {
        let spoken = SPOKEN.replace(None);
        let text = self.logical(Language::english());
        SPOKEN.set(spoken);
        text
    }

    /// In the order in which it is spoken.
    fn logical(&self, language: &Language) -> String {
        match &self.0 {
            Words::Ours(id, arguments) => formatted(language, id, arguments),
            Words::Heard(text) if std::ptr::eq(language, Language::english()) => text.clone(),
            Words::Heard(text) => translated(language, text),
        }
    }
}

fn formatted(language: &Language, id: &str, given: &[(&'static str, Argument)]) -> String {
    let mut arguments = FluentArgs::with_capacity(given.len());
    for (name, value) in given {
        arguments.set(*name, value.in_language(language));
    }
    let said = language.format(id, &arguments);
    said.or_else(|| Language::english().format(id, &arguments)).unwrap_or_else(|| id.to_owned())
}

/// What the library said, with its path or its cause behind it.
fn translated(language: &Language, text: &str) -> String {
    let Some(known) = heard::recognised(text) else {
        return listed(language, text).unwrap_or_else(|| text.to_owned());
    };
    let said = formatted(language, known.id, &known.arguments);
    known.tail.map_or(said.clone(), |tail| format!("{said}: {}", translated(language, tail)))
}

/// Several things that the library names one after the other.
fn listed(language: &Language, text: &str) -> Option<String> {
    let separator = [", ", " + "].into_iter().find(|separator| text.contains(separator))?;
    let parts: Vec<_> = text.split(separator).collect();
    let is_known = parts.iter().any(|part| heard::recognised(part).is_some());
    is_known.then(|| parts.iter().map(|part| translated(language, part)).collect::<Vec<_>>().join(separator))
}

impl Argument {
    fn in_language(&self, language: &Language) -> FluentValue<'_> {
        match self {
            Self::Text(text) => FluentValue::String(text.as_str().into()),
            Self::Number(value, decimals) => {
                let minimum_fraction_digits = Some(*decimals);
                let options = FluentNumberOptions { minimum_fraction_digits, ..Default::default() };
                FluentValue::Number(FluentNumber::new(*value, options))
            }
            Self::Signed(value, decimals) => FluentValue::String(language.style().signed(*value, *decimals).into()),
            Self::Said(message) => FluentValue::String(message.logical(language).into()),
        }
    }
}

impl AsRef<str> for Id {
    fn as_ref(&self) -> &str {
        self.text()
    }
}

/// The first letter large.
pub fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|first| first.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

impl From<String> for Message {
    fn from(text: String) -> Self {
        Self::heard(text)
    }
}

impl From<&str> for Argument {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<&String> for Argument {
    fn from(text: &String) -> Self {
        Self::Text(text.clone())
    }
}

impl From<String> for Argument {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&Path> for Argument {
    fn from(path: &Path) -> Self {
        Self::Text(path.display().to_string())
    }
}

impl From<Message> for Argument {
    fn from(message: Message) -> Self {
        Self::Said(Box::new(message))
    }
}

impl From<Id> for Argument {
    fn from(id: Id) -> Self {
        Message::from(id).into()
    }
}

macro_rules! from_integer {
    ($($kind:ty),*) => {
        $(impl From<$kind> for Argument {
            fn from(value: $kind) -> Self {
                Self::Number(value as f64, 0)
            }
        })*
    };
}
from_integer!(u8, u16, u32, u64, usize, i32);
