//! The head of a PLY file: which elements follow, and what each holds.

use super::NAME;
use crate::io::Problem;

/// The longest head that is read.
const MOST_BYTES: usize = 64 << 10;
/// The most properties that an element may have.
const MOST_PROPERTIES: usize = 512;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// As text, one element a line.
    Text,
    /// As bytes, the least first.
    Binary,
}

/// A kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number that bytes stand for; as many are there as it has.
    pub(super) fn of(self, bytes: &[u8]) -> f32 {
        let four = || bytes.first_chunk().copied().unwrap_or_default();
        let two = || bytes.first_chunk().copied().unwrap_or_default();
        let one = bytes.first().copied().unwrap_or_default();
        match self {
            Self::I8 => f32::from(one as i8),
            Self::U8 => f32::from(one),
            Self::I16 => f32::from(i16::from_le_bytes(two())),
            Self::U16 => f32::from(u16::from_le_bytes(two())),
            Self::I32 => i32::from_le_bytes(four()) as f32,
            Self::U32 => u32::from_le_bytes(four()) as f32,
            Self::F32 => f32::from_le_bytes(four()),
            Self::F64 => f64::from_le_bytes(bytes.first_chunk().copied().unwrap_or_default()) as f32,
        }
    }
}

/// One property of an element: its name and where it begins.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) number: Number,
    /// Bytes before it, and properties before it.
    pub(super) at: [usize; 2],
}

/// So many of a kind of thing.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
    /// Whether a property is a list, whose length is not known before.
    pub(super) has_list: bool,
}

impl Element {
    /// Bytes of one.
    pub(super) fn stride(&self) -> usize {
        self.properties.iter().map(|property| property.number.bytes()).sum()
    }

    pub(super) fn property(&self, name: &str) -> Option<&Property> {
        self.properties.iter().find(|property| property.name == name)
    }
}

/// What the head says.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) kind: Kind,
    pub(super) elements: Vec<Element>,
    pub(super) comments: Vec<String>,
    /// Where the numbers begin.
    pub(super) end: usize,
}

/// Reads the head.
pub(super) fn read(bytes: &[u8]) -> Result<Header, Problem> {
    let head = &bytes[..bytes.len().min(MOST_BYTES)];
    let (mut at, mut kind) = (0, None);
    let (mut elements, mut comments) = (Vec::<Element>::new(), Vec::new());
    loop {
        let Some(length) = head[at..].iter().position(|byte| *byte == b'\n') else {
            return Err(match head.len() == MOST_BYTES {
                true => Problem::damaged(NAME, "its head has no end"),
                false => Problem::Truncated { format: NAME },
            });
        };
        let line = String::from_utf8_lossy(&head[at..at + length]).trim().to_owned();
        at += length + 1;
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["end_header"] => break,
            ["format", name, ..] => kind = Some(kind_of(name)?),
            ["comment", ..] => comments.push(line["comment".len()..].trim().to_owned()),
            ["element", name, count] => {
                let count =
                    count.parse().map_err(|_no_count| Problem::damaged(NAME, format!("it has {count:?} of {name}")))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new(), has_list: false });
            }
            ["property", rest @ ..] => match elements.last_mut() {
                Some(element) => add(element, rest)?,
                None => return Err(Problem::damaged(NAME, "a property stands before all elements")),
            },
            _ => {}
        }
    }
    let kind = kind.ok_or_else(|| Problem::damaged(NAME, "it does not say how its numbers are written"))?;
    Ok(Header { kind, elements, comments, end: at })
}

fn kind_of(name: &str) -> Result<Kind, Problem> {
    match name {
        "ascii" => Ok(Kind::Text),
        "binary_little_endian" => Ok(Kind::Binary),
        "binary_big_endian" => Err(Problem::Unsupported {
            format: NAME,
            reason: "its numbers are written big-endian".to_owned(),
            advice: "save it as binary_little_endian",
        }),
        other => Err(Problem::damaged(NAME, format!("its numbers are written as {other:?}"))),
    }
}

fn add(element: &mut Element, words: &[&str]) -> Result<(), Problem> {
    match words {
        ["list", ..] => element.has_list = true,
        [kind, name] => {
            let number = Number::named(kind).ok_or_else(|| Problem::damaged(NAME, format!("{kind:?} is no number")))?;
            if element.properties.len() == MOST_PROPERTIES {
                return Err(Problem::damaged(NAME, format!("it has more than {MOST_PROPERTIES} properties")));
            }
            let at = [element.stride(), element.properties.len()];
            element.properties.push(Property { name: (*name).to_owned(), number, at });
        }
        _ => return Err(Problem::damaged(NAME, "a property has no name")),
    }
    Ok(())
}
