//! Values of arguments that are more than a number: places, ranges, sizes, lens shapes.

use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, RangedI64ValueParser, TypedValueParser};
use plenoscope::field::{FNumber, ViewOffset};
use plenoscope::scene::Movement;
use plenoscope::scene::asked::{self, Usage};
use plenoscope::scene::export::{KINDS, Kind, Settings};

/// Two numbers with a comma between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair(pub f32, pub f32);

impl FromStr for Pair {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (a, b) = text.split_once(',').ok_or("two numbers with a comma between them are wanted, like 120,80")?;
        Ok(Self(number(a)?, number(b)?))
    }
}

impl From<Pair> for [f32; 2] {
    fn from(Pair(a, b): Pair) -> Self {
        [a, b]
    }
}

impl From<Pair> for ViewOffset {
    fn from(Pair(du, dv): Pair) -> Self {
        Self { dv, du }
    }
}

/// A range of disparities, `D0..D1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The lesser end.
    pub lo: f32,
    /// The greater end.
    pub hi: f32,
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (a, b) = text.split_once("..").ok_or("two numbers with .. between them are wanted, like -0.2..0.4")?;
        let (a, b) = (number(a)?, number(b)?);
        Ok(Self { lo: a.min(b), hi: a.max(b) })
    }
}

/// `WxH`, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl FromStr for Size {
    type Err = Usage;

    fn from_str(text: &str) -> Result<Self, Usage> {
        asked::sides(text).map(Self)
    }
}

/// An f-number from 28 (the photo) to 1.
pub fn f_number(text: &str) -> Result<FNumber, Usage> {
    asked::f_number(number(text.trim_start_matches("f/")).map_err(Usage)?)
}

/// What can be written, as `--as` names it.
pub fn kinds() -> impl TypedValueParser<Value = Kind> {
    named(KINDS.iter().map(|spec| (spec.id, spec.hint, spec.kind)).collect())
}

/// Formats that hold a whole light field.
pub fn field_formats() -> impl TypedValueParser<Value = Kind> {
    named(asked::field_formats().map(|spec| (spec.id, spec.hint, spec.kind)).collect())
}

/// What moves in an animation.
pub fn movements() -> impl TypedValueParser<Value = Movement> {
    named(Movement::ALL.iter().map(|(movement, id, _, hint)| (*id, *hint, *movement)).collect())
}

/// Frames of a stack or an animation.
pub fn frames() -> impl TypedValueParser<Value = u16> {
    clap::value_parser!(u16).range(2..=i64::from(Settings::MOST_FRAMES))
}

/// One of a list of names, each with what it is good for.
fn named<T: Copy + Send + Sync + 'static>(
    all: Vec<(&'static str, &'static str, T)>,
) -> impl TypedValueParser<Value = T> {
    let names = all.iter().map(|(id, hint, _)| PossibleValue::new(id).help(hint));
    PossibleValuesParser::new(names)
        .try_map(move |name| all.iter().find(|(id, ..)| *id == name).map(|(.., value)| *value).ok_or("no such name"))
}

/// Distance of two eyes, in view steps.
pub fn eyes_apart(text: &str) -> Result<f32, String> {
    let steps = number(text)?;
    if (0.0..=16.0).contains(&steps) {
        Ok(steps)
    } else {
        Err("a distance from 0 to 16 view steps is wanted".to_owned())
    }
}

/// A number from 0 to 1.
pub fn share(text: &str) -> Result<f32, Usage> {
    asked::share(number(text).map_err(Usage)?)
}

/// 8 or 16 bits.
pub fn bits(text: &str) -> Result<u8, Usage> {
    asked::bits(text.parse().unwrap_or(0))
}

/// A number from 0 to 100.
pub fn percent(text: &str) -> Result<f32, String> {
    number(text).ok().filter(|n| (0.0..=100.0).contains(n)).ok_or_else(|| "a number from 0 to 100 is wanted".to_owned())
}

/// A finite number.
pub fn number(text: &str) -> Result<f32, String> {
    let number = text.trim().parse::<f32>().ok().filter(|n| n.is_finite());
    number.ok_or_else(|| format!("\"{}\" is not a number", text.trim()))
}

/// A whole number of a range that the library has.
pub fn whole<T>(range: RangeInclusive<T>) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + TryFrom<i64> + Into<i64> + 'static,
    <T as TryFrom<i64>>::Error: std::error::Error + Send + Sync + 'static,
{
    RangedI64ValueParser::<T>::new().range(range.start().clone().into()..=range.end().clone().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_numbers_are_numbers() {
        assert_eq!("-3,-2.5".parse(), Ok(Pair(-3.0, -2.5)));
        assert_eq!("0.4..-0.2".parse(), Ok(Range { lo: -0.2, hi: 0.4 }));
        assert!("nan,1".parse::<Pair>().is_err() && "1".parse::<Pair>().is_err() && "1,".parse::<Pair>().is_err());
    }

    #[test]
    fn sizes() {
        assert_eq!("640x480".parse(), Ok(Size([640, 480])));
        assert!(
            "0x9".parse::<Size>().is_err() && "99999999x1".parse::<Size>().is_err() && "640".parse::<Size>().is_err()
        );
    }

    #[test]
    fn numbers() {
        assert_eq!(f_number("f/2.8"), Ok(FNumber(2.8)));
        assert!(f_number("0.9").is_err() && f_number("29").is_err() && f_number("inf").is_err());
        assert_eq!((bits("16"), share("0.5")), (Ok(16), Ok(0.5)));
        assert!(bits("12").is_err() && bits("x").is_err() && share("2").is_err());
    }
}
