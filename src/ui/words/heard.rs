//! What the library says: English sentences, with names and numbers in them. Each stands in `en.ftl` under an id that begins
//! with `heard-`, is recognised by that, and said in the language of the window. What is not known stays as it is.

use std::borrow::Cow;
use std::cell::RefCell;
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

/// Sentences that are kept, so that what is drawn in each frame is recognised once.
const MOST_SAID: usize = 256;

thread_local! {
    /// What was said last, by the language's tag and the library's words.
    static SAID: RefCell<HashMap<(String, String), String>> = RefCell::default();
}

/// What the library says, in the language of the window.
pub fn heard(text: &str) -> Cow<'_, str> {
    if std::ptr::eq(spoken(), Language::english()) {
        return Cow::Borrowed(text);
    }
    if let Some(id) = PHRASES.whole.get(text) {
        return Cow::Borrowed(super::text(id));
    }
    SAID.with_borrow_mut(|said| {
        if said.len() >= MOST_SAID {
            said.clear();
        }
        let say = || Message::heard(text).text();
        Cow::Owned(said.entry((spoken().tag().to_owned(), text.to_owned())).or_insert_with(say).clone())
    })
}

/// What stands in a text, by its names.
type Holes = Vec<(&'static str, Argument)>;

/// A text of ours that a sentence is.
pub(super) struct Recognised<'a> {
    /// Its id.
    pub id: &'static str,
    /// What stands in its holes.
    pub arguments: Holes,
    /// What stands behind it: a path, or the cause.
    pub tail: Option<&'a str>,
    known: usize,
}

/// The text of ours of which most is in a sentence, up to its end or to one of its colons.
pub(super) fn recognised(text: &str) -> Option<Recognised<'_>> {
    let colons = text.rmatch_indices(": ").map(|(at, colon)| (&text[..at], Some(&text[at + colon.len()..])));
    let all = std::iter::once((text, None)).chain(colons).filter_map(|(head, tail)| {
        let (id, arguments, known) = whole(head)?;
        Some(Recognised { id, arguments, tail, known })
    });
    // Of equals the first, of which nothing is left over.
    all.reduce(|best, next| if next.known > best.known { next } else { best })
}

/// The text that a sentence is, what stands in its holes, and how much of it is known.
fn whole(text: &str) -> Option<(&'static str, Holes, usize)> {
    if let Some(id) = PHRASES.whole.get(text) {
        return Some((id, Vec::new(), text.len()));
    }
    PHRASES.with_holes.iter().find_map(|(id, pieces)| Some((*id, filled(pieces, text)?, known_length(pieces))))
}

fn known_length(pieces: &[Piece]) -> usize {
    pieces.iter().map(|piece| if let Piece::Known(text) = piece { text.len() } else { 0 }).sum()
}

/// What stands in the holes, if all between them is as it should be.
fn filled(pieces: &'static [Piece], mut text: &str) -> Option<Holes> {
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
