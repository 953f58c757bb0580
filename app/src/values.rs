//! Values of arguments that are more than a number: places, ranges, sizes, lens shapes.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use plenoscope::field::{FNumber, LensShape};
use plenoscope::scene::Movement;
use plenoscope::scene::export::{Group, KINDS, Kind, Settings};

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

/// The longest side that is rendered.
const MAX_SIDE: u32 = 65_535;

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "a width and a height in pixels are wanted, like 2048x1365";
        let (w, h) = text.split_once(['x', 'X', '×']).ok_or(wanted)?;
        let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| (1..=MAX_SIDE).contains(side));
        Ok(Self([side(w).ok_or(wanted)?, side(h).ok_or(wanted)?]))
    }
}

/// The size of a refocused picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureSize {
    /// That of the photo.
    Photo,
    /// That of a view.
    LightField,
    /// As asked for.
    Custom(Size),
}

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "photo" => Ok(Self::Photo),
            "light-field" => Ok(Self::LightField),
            _ => text.parse().map(Self::Custom).map_err(|wanted| format!("photo or light-field, or {wanted}")),
        }
    }
}

/// An f-number from 28 (the photo) to 1.
pub fn f_number(text: &str) -> Result<FNumber, String> {
    let n = number(text.trim_start_matches("f/"))?;
    if (FNumber::WIDEST.0..=FNumber::PHOTO.0).contains(&n) {
        Ok(FNumber(n))
    } else {
        Err("an f-number from 28 (the photo as it is) to 1 is wanted".to_owned())
    }
}

/// What can be written, as `--as` names it.
pub fn kinds() -> impl TypedValueParser<Value = Kind> {
    named(KINDS.iter().map(|spec| (spec.id, spec.hint, spec.kind)).collect())
}

/// Formats that hold a whole light field.
pub fn field_formats() -> impl TypedValueParser<Value = Kind> {
    let all = KINDS.iter().filter(|spec| spec.group == Group::LightField);
    named(all.map(|spec| (spec.id, spec.hint, spec.kind)).collect())
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

/// `disc`, `square`, `blades:5` … `blades:9`, `ring` or `cat-eye`.
pub fn lens_shape(text: &str) -> Result<LensShape, String> {
    let (name, count) = text.split_once(':').unwrap_or((text, ""));
    match (name, count) {
        ("disc", "") => Ok(LensShape::Disc),
        ("square", "") => Ok(LensShape::Square),
        ("ring", "") => Ok(LensShape::Ring { inner: 0.6 }),
        ("cat-eye", "") => Ok(LensShape::CatEye { strength: 1.0 }),
        ("blades", count) => match count.parse() {
            Ok(count @ 5..=9) => Ok(LensShape::Blades { count, rotation_deg: 0.0, roundness: 0.0 }),
            _ => Err("5 to 9 blades are wanted, like blades:6".to_owned()),
        },
        _ => Err("disc, square, blades:5 to blades:9, ring or cat-eye is wanted".to_owned()),
    }
}

/// A number from 0 to 100.
pub fn percent(text: &str) -> Result<f32, String> {
    number(text).ok().filter(|n| (0.0..=100.0).contains(n)).ok_or_else(|| "a number from 0 to 100 is wanted".to_owned())
}

/// A number from 0 to 1.
pub fn share(text: &str) -> Result<f32, String> {
    let share = number(text)?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err("a number from 0 to 1 is wanted".to_owned()) }
}

/// 8 or 16 bits.
pub fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("8 or 16 is wanted".to_owned()),
    }
}

/// A finite number.
pub fn number(text: &str) -> Result<f32, String> {
    let number = text.trim().parse::<f32>().ok().filter(|n| n.is_finite());
    number.ok_or_else(|| format!("\"{}\" is not a number", text.trim()))
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
        assert_eq!("photo".parse(), Ok(PictureSize::Photo));
        assert_eq!("8x9".parse(), Ok(PictureSize::Custom(Size([8, 9]))));
        assert!(
            "0x9".parse::<Size>().is_err() && "99999999x1".parse::<Size>().is_err() && "640".parse::<Size>().is_err()
        );
    }

    #[test]
    fn lenses() {
        assert_eq!(lens_shape("disc"), Ok(LensShape::Disc));
        assert!(matches!(lens_shape("blades:7"), Ok(LensShape::Blades { count: 7, .. })));
        for wrong in ["blades", "blades:4", "blades:10", "disc:2", "lens", ""] {
            assert!(lens_shape(wrong).is_err(), "{wrong}");
        }
        assert_eq!(f_number("f/2.8"), Ok(FNumber(2.8)));
        assert!(f_number("0.9").is_err() && f_number("29").is_err() && f_number("inf").is_err());
    }
}
