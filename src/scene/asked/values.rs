//! Single values: which there are, and what is said of others.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::Path;

use super::Usage;
use crate::field::{FNumber, LensShape};
use crate::io::opening;
use crate::scene::OutputSize;

/// Long sides of a view, in pixels.
pub const LONG_SIDES: RangeInclusive<u32> = 16..=4096;
/// Threads that compute; 0 is one for each core.
pub const THREADS: RangeInclusive<u16> = 0..=1024;
/// Qualities of a JPEG.
pub const QUALITIES: RangeInclusive<u8> = 1..=100;
/// Rows of an epipolar slice for each view.
pub const EPI_SCALES: RangeInclusive<u32> = 1..=256;
/// The same where nobody asks for another number.
pub const EPI_SCALE: u32 = 8;
/// Sides of a picture, in pixels.
const SIDES: RangeInclusive<u32> = 1..=65_535;

fn wanted(text: &str) -> Usage {
    Usage(text.to_owned())
}

/// A number of a range.
pub fn within<T: PartialOrd + Display>(number: T, range: &RangeInclusive<T>) -> Result<T, Usage> {
    match range.contains(&number) {
        true => Ok(number),
        false => Err(Usage(format!("{number} is not in {}..={}", range.start(), range.end()))),
    }
}

/// A number that is one: neither NaN nor infinity.
pub fn number(n: f32) -> Result<f32, Usage> {
    if n.is_finite() { Ok(n) } else { Err(Usage(format!("\"{n}\" is not a number"))) }
}

/// An f-number from 28 (the photo) to 1.
pub fn f_number(n: f32) -> Result<FNumber, Usage> {
    let is_one = (FNumber::WIDEST.0..=FNumber::PHOTO.0).contains(&n);
    is_one.then_some(FNumber(n)).ok_or_else(|| wanted("an f-number from 28 (the photo as it is) to 1 is wanted"))
}

/// A number from 0 to 1.
pub fn share(n: f32) -> Result<f32, Usage> {
    if (0.0..=1.0).contains(&n) { Ok(n) } else { Err(wanted("a number from 0 to 1 is wanted")) }
}

/// 8 or 16 bits.
pub fn bits(n: u8) -> Result<u8, Usage> {
    if [8, 16].contains(&n) { Ok(n) } else { Err(wanted("8 or 16 is wanted")) }
}

/// `disc`, `square`, `blades:5` … `blades:9`, `ring`, `cat-eye`, or `picture:FILE`, which is read.
pub fn lens_shape(text: &str) -> Result<LensShape, Usage> {
    let (name, count) = text.split_once(':').unwrap_or((text, ""));
    match (name, count) {
        ("disc", "") => Ok(LensShape::Disc),
        ("square", "") => Ok(LensShape::Square),
        ("ring", "") => Ok(LensShape::Ring { inner: 0.6 }),
        ("cat-eye", "") => Ok(LensShape::CatEye { strength: 1.0 }),
        ("blades", count) => match count.parse() {
            Ok(count @ 5..=9) => Ok(LensShape::Blades { count, rotation_deg: 0.0, roundness: 0.0 }),
            _ => Err(wanted("5 to 9 blades are wanted, like blades:6")),
        },
        ("picture", file) if !file.is_empty() => match opening::read(Path::new(file)) {
            Ok(opening) => Ok(LensShape::Picture(opening)),
            Err(error) => Err(Usage(error.to_string())),
        },
        _ => Err(wanted("disc, square, blades:5 to blades:9, ring, cat-eye or picture:FILE is wanted")),
    }
}

/// A picture's size: `photo`, `light-field`, or `WxH`.
pub fn picture_size(text: &str) -> Result<OutputSize, Usage> {
    match text {
        "photo" => Ok(OutputSize::Photo),
        "light-field" => Ok(OutputSize::LightField),
        _ => match sides(text) {
            Ok(size) => Ok(OutputSize::Within(size)),
            Err(Usage(wanted)) => Err(Usage(format!("photo or light-field, or {wanted}"))),
        },
    }
}

/// `WxH`, in pixels.
pub fn sides(text: &str) -> Result<[u32; 2], Usage> {
    let side = |text: &str| text.trim().parse().ok().filter(|side| SIDES.contains(side));
    let both = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    both.ok_or_else(|| wanted("a width and a height in pixels are wanted, like 2048x1365"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lenses() {
        assert_eq!(lens_shape("disc"), Ok(LensShape::Disc));
        assert!(matches!(lens_shape("blades:7"), Ok(LensShape::Blades { count: 7, .. })));
        for wrong in ["blades", "blades:4", "blades:10", "disc:2", "lens", "picture:", "picture:/none.png", ""] {
            assert!(lens_shape(wrong).is_err(), "{wrong}");
        }
        assert_eq!(f_number(2.8), Ok(FNumber(2.8)));
        assert!(f_number(0.9).is_err() && f_number(29.0).is_err() && f_number(f32::INFINITY).is_err());
        assert!(number(f32::NAN).is_err() && share(1.1).is_err() && bits(12).is_err());
    }

    #[test]
    fn sizes() {
        assert_eq!(picture_size("photo"), Ok(OutputSize::Photo));
        assert_eq!(picture_size("640x480"), Ok(OutputSize::Within([640, 480])));
        for wrong in ["0x9", "99999999x1", "640", "large"] {
            assert!(picture_size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(within(8, &LONG_SIDES).unwrap_err().to_string(), "8 is not in 16..=4096");
    }
}
