//! One language: its texts out of one file, and how it writes numbers and runs.

use std::collections::HashMap;
use std::sync::LazyLock;

use fluent_bundle::concurrent::FluentBundle;
use fluent_bundle::{FluentArgs, FluentResource, FluentValue};
use fluent_syntax::ast::{Entry, Expression, InlineExpression, Pattern, PatternElement};
use unic_langid::LanguageIdentifier;

use super::number::Style;
use super::{order, spoken};

/// Where a language's texts come from.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// BCP 47, as `de` or `pt-BR`.
    pub tag: &'static str,
    /// The file.
    pub text: &'static str,
}

/// Those in the program; the first has all texts.
pub const SHIPPED: [Source; 2] =
    [Source { tag: "en", text: include_str!("en.ftl") }, Source { tag: "de", text: include_str!("de.ftl") }];

/// The most braces and brackets of one text. A stack bears a thousand in one another.
const MOST_OPENED: usize = 200;

static SPEAKERS: LazyLock<[Language; SHIPPED.len()]> =
    LazyLock::new(|| SHIPPED.map(|source| Language::read(source.tag, source.text).0));

/// A part of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Words.
    Known(String),
    /// What is put in, by its name.
    Hole(String),
}

/// A language that can be spoken.
pub struct Language {
    tag: String,
    bundle: FluentBundle<FluentResource>,
    /// All ids, with those of what else is said: `id.attribute`.
    ids: Vec<String>,
    /// Texts without arguments, as they are shown.
    plain: HashMap<String, String>,
    style: Style,
    is_leftward: bool,
}

impl Language {
    /// The one that has all texts.
    pub fn english() -> &'static Self {
        &SPEAKERS[0]
    }

    /// One of those in the program.
    pub fn shipped(tag: &str) -> Option<&'static Self> {
        SPEAKERS.iter().find(|language| language.tag == tag)
    }

    /// Reads a file; what of it cannot be read is said, and what can is spoken.
    pub fn read(tag: &str, file: &str) -> (Self, Vec<String>) {
        let (resource, mut faults) = match FluentResource::try_new(file.to_owned()) {
            Ok(resource) => (resource, Vec::new()),
            Err((resource, errors)) => (resource, errors.iter().map(|error| place(file, error.pos.start)).collect()),
        };
        let identifier: LanguageIdentifier = tag.parse().unwrap_or_default();
        let mut bundle = FluentBundle::new_concurrent(vec![identifier]);
        // Its marks are no letters of any face.
        bundle.set_use_isolating(false);
        bundle.set_formatter(Some(|value, _| match value {
            FluentValue::Number(n) => {
                Some(spoken().style.fixed(n.value, n.options.minimum_fraction_digits.unwrap_or_default()))
            }
            _ => None,
        }));
        let ids = ids(&resource);
        faults.extend(bundle.add_resource(resource).err().into_iter().flatten().map(|error| error.to_string()));
        let mut plain: HashMap<_, _> = ids.iter().filter_map(|id| Some((id.clone(), constant(&bundle, id)?))).collect();
        let said = |key: &str, usual: &str| plain.get(key).cloned().unwrap_or_else(|| usual.to_owned());
        let style = Style { decimal: said("number-decimal", "."), group: said("number-group", ",") };
        let is_leftward = said("reading", "rightward") == "leftward";
        if is_leftward {
            plain.values_mut().for_each(|text| *text = order::visual(text));
        }
        (Self { tag: tag.to_owned(), bundle, ids, plain, style, is_leftward }, faults)
    }

    /// As `de` or `pt-BR`.
    pub fn tag(&self) -> &str {
        &self.tag
    }

    /// What it calls itself.
    pub fn name(&self) -> &str {
        self.plain("language-name").unwrap_or(&self.tag)
    }

    /// How it writes numbers.
    pub fn style(&self) -> &Style {
        &self.style
    }

    /// Whether it is read from right to left.
    pub fn is_leftward(&self) -> bool {
        self.is_leftward
    }

    /// A text without arguments.
    pub fn plain(&self, id: &str) -> Option<&str> {
        self.plain.get(id).map(String::as_str)
    }

    /// All ids, with those of what else is said.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.ids.iter().map(String::as_str)
    }

    /// A text in its parts; of one that chooses between several, those of none.
    pub fn pieces(&self, id: &str) -> Vec<Piece> {
        let elements = pattern(&self.bundle, id).map(|pattern| &pattern.elements[..]).unwrap_or_default();
        let piece = |element: &PatternElement<&str>| match element {
            PatternElement::TextElement { value } => Piece::Known((*value).to_owned()),
            PatternElement::Placeable { expression: Expression::Inline(inline) } => match inline {
                InlineExpression::VariableReference { id } => Piece::Hole(id.name.to_owned()),
                InlineExpression::StringLiteral { value } => Piece::Known((*value).to_owned()),
                _ => Piece::Hole(String::new()),
            },
            PatternElement::Placeable { .. } => Piece::Hole(String::new()),
        };
        elements.iter().map(piece).collect()
    }

    /// A text as it stands in the file.
    #[cfg(test)]
    pub fn pattern(&self, id: &str) -> Option<&Pattern<&str>> {
        pattern(&self.bundle, id)
    }

    /// A text with what it is said of.
    pub fn format(&self, id: &str, arguments: &FluentArgs) -> Option<String> {
        let pattern = pattern(&self.bundle, id)?;
        let mut errors = Vec::new();
        let said = self.bundle.format_pattern(pattern, Some(arguments), &mut errors).into_owned();
        errors.is_empty().then_some(said)
    }
}

/// All ids of a file, with those of what else is said.
fn ids(resource: &FluentResource) -> Vec<String> {
    let mut ids = Vec::new();
    for entry in resource.entries() {
        let Entry::Message(message) = entry else { continue };
        ids.push(message.id.name.to_owned());
        ids.extend(message.attributes.iter().map(|more| format!("{}.{}", message.id.name, more.id.name)));
    }
    ids
}

/// The text with an id, or what else is said of it.
fn pattern<'a>(bundle: &'a FluentBundle<FluentResource>, key: &str) -> Option<&'a Pattern<&'a str>> {
    match key.split_once('.') {
        Some((id, attribute)) => Some(bundle.get_message(id)?.get_attribute(attribute)?.value()),
        None => bundle.get_message(key)?.value(),
    }
}

/// What a text is, if it needs no arguments.
fn constant(bundle: &FluentBundle<FluentResource>, key: &str) -> Option<String> {
    let mut errors = Vec::new();
    let said = bundle.format_pattern(pattern(bundle, key)?, None, &mut errors).into_owned();
    errors.is_empty().then_some(said)
}

/// Whether a text of a file may hold so many braces and brackets in one another that reading it would end the program: its reader,
/// which is not ours, goes one step deeper with each. They are counted where they open, as strings make it hard to tell what closes.
pub fn is_too_deep(file: &str) -> bool {
    let mut opened = 0;
    file.lines().any(|line| {
        let rest = line.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || "-_".contains(c));
        let begins = rest.len() < line.len() && rest.trim_start().starts_with('=');
        opened = if begins { 0 } else { opened } + line.matches(['{', '(']).count();
        opened > MOST_OPENED
    })
}

/// Where a file cannot be read.
fn place(file: &str, at: usize) -> String {
    let line = file.bytes().take(at).filter(|byte| *byte == b'\n').count() + 1;
    line.to_string()
}
