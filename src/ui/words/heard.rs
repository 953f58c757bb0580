//! What the library says: English sentences, with names and numbers in them. Each stands in `en.ftl` under an id that begins
//! with `heard-`, is recognised by that, and said in the language of the window. What is not known stays as it is.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::LazyLock;

use super::language::{Language, Piece};
use super::{Argument, Message, spoken};

/// Ids of what the library says.
pub const PREFIX: &str = "heard-";

struct Phrases {
    /// Texts without names and numbers.
    whole: HashMap<String, &'static str>,
    /// The others, those first of which most is known.
    with_holes: Vec<(&'static str, Vec<Piece>)>,
}

static PHRASES: LazyLock<Phrases> = LazyLock::new(|| {
    let english = Language::english();
    let (mut whole, mut with_holes) = (HashMap::new(), Vec::new());
    for id in english.ids().filter(|id| id.starts_with(PREFIX)) {
        match english.plain(id) {
            Some(text) => drop(whole.insert(text.to_owned(), id)),
            None => with_holes.push((id, english.pieces(id))),
        }
    }
    with_holes.sort_by_key(|(id, pieces)| (std::cmp::Reverse(known_length(pieces)), *id));
    Phrases { whole, with_holes }
});

/// What the library says, in the language of the window.
pub fn heard(text: &str) -> Cow<'_, str> {
    if std::ptr::eq(spoken(), Language::english()) {
        return Cow::Borrowed(text);
    }
    match PHRASES.whole.get(text) {
        Some(id) => Cow::Borrowed(super::text(id)),
        None => Cow::Owned(Message::heard(text).text()),
    }
}

/// Whether a sentence, or what stands before a path or a cause, is one of them.
#[cfg(test)]
pub fn is_known(text: &str) -> bool {
    recognised(text).is_some() || parts(text).any(|(head, _)| recognised(head).is_some())
}

/// The text with this id that a sentence is, and what stands in its holes.
pub(super) fn recognised(text: &str) -> Option<(&'static str, Vec<(&'static str, Argument)>)> {
    if let Some(id) = PHRASES.whole.get(text) {
        return Some((id, Vec::new()));
    }
    PHRASES.with_holes.iter().find_map(|(id, pieces)| Some((*id, filled(pieces, text)?)))
}

/// A sentence, and what stands behind its last colons: a path, or the cause.
pub(super) fn parts(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.rmatch_indices(": ").map(|(at, colon)| (&text[..at], &text[at + colon.len()..]))
}

fn known_length(pieces: &[Piece]) -> usize {
    pieces.iter().map(|piece| if let Piece::Known(text) = piece { text.len() } else { 0 }).sum()
}

/// What stands in the holes, if all between them is as it should be.
fn filled(pieces: &'static [Piece], mut text: &str) -> Option<Vec<(&'static str, Argument)>> {
    let mut holes = Vec::new();
    let mut open: Option<&'static str> = None;
    for (i, piece) in pieces.iter().enumerate() {
        match (piece, open.take()) {
            (Piece::Hole(name), None) => open = Some(name),
            // Two side by side cannot be told apart.
            (Piece::Hole(_), Some(_)) => return None,
            (Piece::Known(known), None) => text = text.strip_prefix(known.as_str())?,
            (Piece::Known(known), Some(name)) => {
                let is_last = i + 1 == pieces.len();
                let at = if is_last { text.len().checked_sub(known.len()) } else { text.find(known.as_str()) };
                let at = at.filter(|&at| text.is_char_boundary(at) && text[at..].starts_with(known.as_str()))?;
                holes.push((name, content(name, &text[..at])?));
                text = &text[at + known.len()..];
            }
        }
    }
    match open {
        Some(name) => holes.push((name, content(name, text)?)),
        None if !text.is_empty() => return None,
        None => {}
    }
    Some(holes)
}

/// A number, or words that may be the library's again; nothing where a number is needed and is none.
fn content(name: &str, text: &str) -> Option<Argument> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && !text.contains(['e', 'E', '+']) => {
            Some(Argument::Number(value, text.split_once('.').map_or(0, |(_, decimals)| decimals.len())))
        }
        _ if name == "number" => None,
        _ => Some(Argument::Said(Box::new(Message::heard(text)))),
    }
}
