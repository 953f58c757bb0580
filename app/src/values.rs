//! Values of arguments that are more than a number: places, ranges, sizes, lens shapes.

use std::ffi::OsString;
use std::ops::RangeInclusive;
use std::path::Path;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, RangedI64ValueParser, TypedValueParser};
use plenoscope::field::{FNumber, Strength, ViewOffset};
use plenoscope::io::formats::quilt;
use plenoscope::scene::Movement;
use plenoscope::scene::asked::{self, FocusAsked, Usage};
use plenoscope::scene::export::{KINDS, Kind, Settings};
use plenoscope::scene::real::{DISTANCES_M, FORMATS, KnownLens, known_lenses};

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

/// What is to be sharp: a pixel, or the subject.
pub fn focus(text: &str) -> Result<FocusAsked, String> {
    if text == "subject" {
        return Ok(FocusAsked::Subject);
    }
    let wanted = "two numbers with a comma between them are wanted, like 120,80, or subject";
    text.parse().map(|at: Pair| FocusAsked::At(at.into())).map_err(|_no_pair: String| wanted.to_owned())
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

/// What is to stay sharp: a band of disparities, or a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeepSharp {
    /// Disparities around the focal plane.
    Band(Range),
    /// A pixel of the upright photo, one of up to three.
    At(Pair),
}

impl FromStr for KeepSharp {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains("..") {
            return text.parse().map(Self::Band);
        }
        let wanted = "disparities like -0.2..0.4 or one to three pixels like 120,80 300,200 are wanted";
        text.parse().map(Self::At).map_err(|_no_pixel| wanted.to_owned())
    }
}

/// Something of the photo whose length is known, `X,Y..X,Y=20cm`: its ends as pixels of the upright photo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownLength {
    /// Where it begins and ends.
    pub ends: [Pair; 2],
    /// How long it is.
    pub metres: f32,
}

impl FromStr for KnownLength {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || "two pixels and the length between them are wanted, like 120,80..300,90=20cm".to_owned();
        let (ends, length) = text.rsplit_once('=').ok_or_else(wanted)?;
        let (from, to) = ends.split_once("..").ok_or_else(wanted)?;
        let end = |text: &str| text.parse().map_err(|_no_pixel: String| wanted());
        Ok(Self { ends: [end(from)?, end(to)?], metres: self::length(length)? })
    }
}

/// `--keep-sharp A B C` as three times `--keep-sharp`: an option that takes several values would swallow what follows it.
pub fn spread(args: impl Iterator<Item = OsString>) -> Vec<OsString> {
    const NAME: &str = "--keep-sharp";
    let mut spread: Vec<OsString> = Vec::new();
    // How many values of the option stand before.
    let mut values = None;
    for arg in args {
        let is_pixel = arg.to_str().is_some_and(|text| text.parse::<Pair>().is_ok());
        values = match values {
            _ if arg == NAME => Some(0),
            Some(0) => Some(1),
            Some(n) if is_pixel => {
                spread.push(NAME.into());
                Some(n + 1)
            }
            _ => None,
        };
        spread.push(arg);
    }
    spread
}

/// A lens by the name that `lenses` lists, or a TOML file.
pub fn known_lens(text: &str) -> Result<KnownLens, String> {
    if Path::new(text).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return KnownLens::read(Path::new(text)).map_err(|error| error.to_string());
    }
    let (lenses, _) = known_lenses();
    let names: Vec<String> = lenses.iter().map(KnownLens::id).collect();
    let found = lenses.into_iter().find(|lens| lens.id() == text.to_lowercase());
    found.ok_or_else(|| format!("there is no such lens — name one of {}, or a TOML file", names.join(", ")))
}

/// A number with a unit of length, or metres: 0.6m, 60cm, 600mm.
fn in_metres(text: &str) -> Result<f32, String> {
    let units = [("mm", 1e-3), ("cm", 1e-2), ("km", 1e3), ("m", 1.0), ("", 1.0)];
    let (digits, unit) = units.iter().find_map(|(name, m)| Some((text.strip_suffix(name)?, *m))).unwrap_or((text, 1.0));
    Ok(number(digits.trim())? * unit)
}

/// A length in metres.
fn length(text: &str) -> Result<f32, String> {
    let metres = in_metres(text)?;
    let is_one = (1e-4..=1e4).contains(&metres);
    is_one.then_some(metres).ok_or_else(|| "a length from 0.1mm to 10km is wanted, like 20cm".to_owned())
}

/// A distance in metres: 0.6m, 60cm, 600mm.
pub fn distance(text: &str) -> Result<f32, String> {
    let metres = in_metres(text)?;
    let [least, most] = DISTANCES_M;
    let is_one = (least..=most).contains(&metres);
    is_one.then_some(metres).ok_or_else(|| "a distance from 1cm to 10km is wanted, like 0.6m".to_owned())
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

/// A share from -1 to 1.
pub fn signed_share(text: &str) -> Result<f32, String> {
    let n = number(text)?;
    (-1.0..=1.0).contains(&n).then_some(n).ok_or_else(|| "a number from -1 to 1 is wanted".to_owned())
}

/// A strength from 0.2 to 4.
pub fn strength(text: &str) -> Result<Strength, String> {
    let strength = Strength(number(text.trim_end_matches(['x', '×']))?);
    strength.is_valid().then_some(strength).ok_or_else(|| "a strength from 0.2 to 4 is wanted".to_owned())
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

/// Sensors, by the place of their format.
pub fn sensors() -> impl TypedValueParser<Value = usize> {
    named(FORMATS.iter().enumerate().map(|(at, format)| (format.id, format.name, at)).collect())
}

/// Frames of a stack or an animation.
pub fn frames() -> impl TypedValueParser<Value = u16> {
    clap::value_parser!(u16).range(2..=i64::from(Settings::MOST_FRAMES))
}

/// The displays that quilts are for, by their places in the list.
pub fn displays() -> impl TypedValueParser<Value = usize> {
    named(quilt::DEVICES.iter().enumerate().map(|(place, device)| (device.id, device.name, place)).collect())
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

/// A share of a baseline: a little beyond it, the frames still see something.
pub fn baseline(text: &str) -> Result<f64, String> {
    let share = number(text).ok().filter(|n| (0.05..=4.0).contains(n)).map(f64::from);
    share.ok_or_else(|| "a number from 0.05 to 4 is wanted".to_owned())
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
    fn what_is_kept_sharp_may_stand_together() {
        let spread = |text: &str| {
            let all = spread(text.split(' ').map(OsString::from));
            all.iter().map(|arg| arg.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(spread("p refocus --keep-sharp 1,2 3,4 a.jpg"), "p refocus --keep-sharp 1,2 --keep-sharp 3,4 a.jpg");
        for same in
            ["p --keep-sharp -0.2..0.3 a.jpg", "p --at 1,2 3,4", "p --keep-sharp 1,2 --at 3,4", "p --keep-sharp"]
        {
            assert_eq!(spread(same), same);
        }
    }

    #[test]
    fn distances_have_units() {
        for (text, metres) in [("0.6m", 0.6), ("60cm", 0.6), ("600 mm", 0.6), ("2", 2.0), ("1.5km", 1500.0)] {
            assert!((distance(text).unwrap() - metres).abs() < 1e-4 * metres, "{text}");
        }
        assert!(["0", "-1m", "nanm", "m", "20km", "6 feet"].iter().all(|text| distance(text).is_err()));
    }

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
