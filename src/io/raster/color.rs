//! ICC profiles → the sRGB working copy.

use std::sync::Arc;

use moxcms::{ColorProfile, DataColorSpace, Layout, ProfileText, TransformExecutor, TransformOptions};

use crate::field::{PixelsPart, ToSrgb8};
use crate::within::plain_words;

/// The 8-bit value nearest to a 16-bit one.
pub(crate) fn eight_from_sixteen(value: u16) -> u8 {
    ((u32::from(value) * 255 + 32_767) / 65_535) as u8
}

/// What makes the working copy of 8-bit RGBA pixels; none where their profile is sRGB and they are it themselves.
pub(super) fn srgb8_from_eight(icc: Option<&[u8]>, warnings: &mut Vec<String>) -> Option<ToSrgb8> {
    let profile = icc.and_then(|icc| parse(icc, warnings))?;
    let made = profile.create_transform_8bit(Layout::Rgba, &ColorProfile::new_srgb(), Layout::Rgba, options());
    let Ok(transform) = made else {
        warnings.push("the colour profile cannot be used, so the colours are taken as sRGB".to_owned());
        return None;
    };
    (!is_identity(&*transform)).then(|| {
        let convert: ToSrgb8 = Arc::new(move |from, to| match from {
            PixelsPart::Eight(from) if transform.transform(from, to).is_err() => to.copy_from_slice(from),
            PixelsPart::Eight(_) => {}
            PixelsPart::Sixteen(from) => narrow(from, to),
        });
        convert
    })
}

/// What makes the working copy of 16-bit RGBA pixels.
pub(super) fn srgb8_from_sixteen(icc: Option<&[u8]>, warnings: &mut Vec<String>) -> ToSrgb8 {
    let transform = icc.and_then(|icc| parse(icc, warnings)).and_then(|profile| {
        profile.create_transform_16bit(Layout::Rgba, &ColorProfile::new_srgb(), Layout::Rgba, options()).ok()
    });
    Arc::new(move |from, to| {
        let PixelsPart::Sixteen(from) = from else { return };
        let mut srgb = vec![0; from.len()];
        match &transform {
            Some(transform) if transform.transform(from, &mut srgb).is_ok() => narrow(&srgb, to),
            _ => narrow(from, to),
        }
    })
}

fn narrow(from: &[u16], to: &mut [u8]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = eight_from_sixteen(from));
}

/// Grey samples with their own profile → sRGB grey.
pub(super) fn srgb_from_gray(gray: &[u8], icc: &[u8]) -> Option<Vec<[u8; 3]>> {
    let profile =
        ColorProfile::new_from_slice(icc).ok().filter(|profile| profile.color_space == DataColorSpace::Gray)?;
    let to = ColorProfile::new_srgb();
    let transform = profile.create_transform_8bit(Layout::Gray, &to, Layout::Rgb, options()).ok()?;
    let mut out = vec![[0; 3]; gray.len()];
    transform.transform(gray, out.as_flattened_mut()).ok()?;
    Some(out)
}

/// CMYK ink amounts (0 none … 255 full) with their profile → sRGB.
pub(super) fn srgb_from_cmyk(inks: &[u8], icc: &[u8]) -> Option<Vec<[u8; 3]>> {
    let profile =
        ColorProfile::new_from_slice(icc).ok().filter(|profile| profile.color_space == DataColorSpace::Cmyk)?;
    let to = ColorProfile::new_srgb();
    let transform = profile.create_transform_8bit(Layout::Rgba, &to, Layout::Rgb, options()).ok()?;
    let mut out = vec![[0; 3]; inks.len() / 4];
    transform.transform(inks, out.as_flattened_mut()).ok()?;
    Some(out)
}

/// Whether a profile is one for RGB pixels.
pub(super) fn is_rgb(icc: &[u8]) -> bool {
    ColorProfile::new_from_slice(icc).is_ok_and(|profile| profile.color_space == DataColorSpace::Rgb)
}

/// The name that a profile gives itself.
pub(crate) fn profile_name(icc: &[u8]) -> Option<String> {
    let text = match ColorProfile::new_from_slice(icc).ok()?.description? {
        ProfileText::PlainString(text) => text,
        ProfileText::Localizable(texts) => texts.into_iter().next()?.value,
        ProfileText::Description(text) => text.ascii_string,
    };
    let text = plain_words(text.trim_matches(['\0', ' ', '\n']), 200);
    (!text.is_empty()).then_some(text)
}

fn options() -> TransformOptions {
    TransformOptions::default()
}

fn parse(icc: &[u8], warnings: &mut Vec<String>) -> Option<ColorProfile> {
    let profile = ColorProfile::new_from_slice(icc).ok().filter(|profile| profile.color_space == DataColorSpace::Rgb);
    if profile.is_none() {
        warnings.push("the colour profile cannot be read, so the colours are taken as sRGB".to_owned());
    }
    profile
}

/// Whether a transform leaves 9³ colours where they are, give or take 1.
fn is_identity(transform: &(dyn TransformExecutor<u8> + Send + Sync)) -> bool {
    let level = |n: usize| ((n * 255) / 8) as u8;
    let colors: Vec<u8> = (0..9 * 9 * 9).flat_map(|n| [level(n / 81), level(n / 9 % 9), level(n % 9), 255]).collect();
    let mut out = vec![0; colors.len()];
    transform.transform(&colors, &mut out).is_ok() && colors.iter().zip(&out).all(|(a, b)| a.abs_diff(*b) <= 1)
}
