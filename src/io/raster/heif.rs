//! What HEIC and AVIF have in common (ISO/IEC 23008-12): colours by number, turns, pictures put together from parts.

use heifer::heifer_isobmff::boxes::{ColorInfo, Property};
use heifer::heifer_isobmff::{HeifFile, ItemId};
use moxcms::{
    CicpColorPrimaries, CicpProfile, ColorProfile, LocalizableString, MatrixCoefficients, ProfileText,
    TransferCharacteristics,
};

use super::Samples;
use crate::io::Problem;

/// Whether bytes begin as an AVIF file does.
pub(crate) fn is_avif(bytes: &[u8]) -> bool {
    brands(bytes).is_some_and(|(main, others)| match main {
        b"avif" | b"avis" => true,
        b"mif1" | b"mif2" | b"miaf" | b"msf1" => others.contains(b"avif"),
        _ => false,
    })
}

/// Whether bytes begin as a HEIC file does.
pub(crate) fn is_heic(bytes: &[u8]) -> bool {
    const MAIN: [&[u8; 4]; 9] = [b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"mif2", b"msf1"];
    !is_avif(bytes) && brands(bytes).is_some_and(|(main, _)| MAIN.contains(&main))
}

/// The main brand, which may say only that it is some picture, and all of them (a version lies between).
fn brands(bytes: &[u8]) -> Option<(&[u8; 4], &[[u8; 4]])> {
    let length = u32::from_be_bytes(*bytes.first_chunk()?) as usize;
    let brands = bytes[..bytes.len().min(length)].strip_prefix(&bytes[..4])?.strip_prefix(b"ftyp")?;
    Some((brands.first_chunk()?, brands.get(8..).unwrap_or_default().as_chunks().0))
}

/// Most pictures that one picture may be put together from; a phone's has a few hundred tiles.
const MAX_PARTS: usize = 2048;

/// Colours by number (ITU-T H.273); 2 says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cicp {
    /// 1 sRGB, 9 BT.2020, 12 Display P3.
    pub(crate) primaries: u16,
    /// 13 sRGB, 16 PQ, 18 HLG.
    pub(crate) transfer: u16,
    /// 0 RGB itself, 1 BT.709, 5 and 6 BT.601, 9 BT.2020.
    pub(crate) matrix: u16,
    /// Whether black is 0 and white the largest number.
    pub(crate) full_range: bool,
}

impl Cicp {
    /// What the container says of an item.
    pub(crate) fn of(file: &HeifFile, id: ItemId) -> Option<Self> {
        file.item_properties(id).ok()?.find_map(|property| match *property {
            Property::Color(ColorInfo::Nclx { primaries, transfer, matrix, full_range }) => {
                Some(Self { primaries, transfer, matrix, full_range })
            }
            _ => None,
        })
    }

    /// A profile that says the same; none where that is sRGB. Video's transfer curves are taken for that of sRGB, as
    /// browsers do; those of HDR screens have been applied already ([`super::hdr`]).
    pub(crate) fn profile(self) -> Option<Vec<u8>> {
        let transfer_characteristics = match self.transfer {
            4 => TransferCharacteristics::Bt470M,
            5 => TransferCharacteristics::Bt470Bg,
            8 => TransferCharacteristics::Linear,
            _ => TransferCharacteristics::Srgb,
        };
        let color_primaries = match CicpColorPrimaries::try_from(u8::try_from(self.primaries).ok()?).ok()? {
            CicpColorPrimaries::Reserved | CicpColorPrimaries::Unspecified | CicpColorPrimaries::Xyz => {
                CicpColorPrimaries::Bt709
            }
            known => known,
        };
        let plain = transfer_characteristics == TransferCharacteristics::Srgb;
        match color_primaries {
            CicpColorPrimaries::Bt709 if plain => None,
            CicpColorPrimaries::Smpte432 if plain => ColorProfile::new_display_p3().encode().ok(),
            _ => {
                let matrix_coefficients = MatrixCoefficients::Bt709;
                let cicp =
                    CicpProfile { color_primaries, transfer_characteristics, matrix_coefficients, full_range: true };
                let mut profile = ColorProfile::new_from_cicp(cicp);
                let name = format!("{color_primaries:?}, {transfer_characteristics:?}");
                let text = LocalizableString::new("en".to_owned(), "US".to_owned(), name);
                profile.description = Some(ProfileText::Localizable(vec![text]));
                profile.encode().ok()
            }
        }
    }
}

/// Refuses an item that is put together from parts, and they from others, without end.
pub(crate) fn check_parts(file: &HeifFile, id: ItemId, format: &'static str) -> Result<(), Problem> {
    let (mut parts, mut next) = (vec![id], 0);
    while let Some(&part) = parts.get(next) {
        parts.extend(file.referenced_items(part, b"dimg"));
        next += 1;
        if parts.len() > MAX_PARTS {
            return Err(Problem::damaged(format, format!("it is put together from more than {MAX_PARTS} pictures")));
        }
    }
    Ok(())
}

/// An item's turns as an EXIF orientation: `irot` (anticlockwise quarters), then `imir`.
pub(crate) fn turn(file: &HeifFile, id: ItemId) -> u8 {
    let (mut quarters, mut mirror) = (0, None);
    for property in file.item_properties(id).into_iter().flatten() {
        match property {
            Property::Rotation(q) => quarters = q % 4,
            Property::Mirror(top_bottom) => mirror = Some(*top_bottom),
            _ => {}
        }
    }
    let row = match mirror {
        None => [1, 8, 3, 6],
        Some(false) => [2, 7, 4, 5],
        Some(true) => [4, 5, 2, 7],
    };
    row[usize::from(quarters)]
}

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    at: [u32; 2],
    pub(crate) size: [u32; 2],
}

impl Part {
    /// The part's own pixels.
    pub(crate) fn cut(self, samples: Samples, whole: [u32; 2]) -> Samples {
        match samples {
            Samples::Eight(pixels) => Samples::Eight(self.rows(&pixels, whole)),
            Samples::Sixteen(pixels) => Samples::Sixteen(self.rows(&pixels, whole)),
        }
    }

    fn rows<P: Copy>(self, pixels: &[P], whole: [u32; 2]) -> Vec<P> {
        let [left, top, width, height] = [self.at[0], self.at[1], self.size[0], self.size[1]].map(|n| n as usize);
        let rows = pixels.chunks_exact(whole[0] as usize).skip(top).take(height);
        rows.flat_map(|row| row[left..left + width].iter().copied()).collect()
    }
}

/// The part that is meant to be seen (`clap`: its size, and how far its middle lies from the picture's, in fractions;
/// ISO/IEC 14496-12, 12.1.4). None where that is not a part of the picture.
pub(crate) fn clean_aperture(file: &HeifFile, id: ItemId, whole: [u32; 2]) -> Option<Part> {
    file.item_properties(id).ok()?.find_map(|property| match *property {
        Property::CleanAperture { width, height, horiz_offset, vert_offset } => {
            let [x, size_x] = side(width, horiz_offset, whole[0])?;
            let [y, size_y] = side(height, vert_offset, whole[1])?;
            Some(Part { at: [x, y], size: [size_x, size_y] })
        }
        _ => None,
    })
}

/// Start and length of a side of the part.
fn side(length: (u32, u32), offset: (i32, u32), whole: u32) -> Option<[u32; 2]> {
    let length = f64::from(length.0) / f64::from(length.1);
    let start = (f64::from(whole) - length) / 2.0 + f64::from(offset.0) / f64::from(offset.1);
    let inside = length >= 1.0 && start >= 0.0 && start + length <= f64::from(whole);
    inside.then(|| {
        let start = start.round() as u32;
        [start, (length.round() as u32).min(whole - start)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clean_aperture_is_a_part() {
        // 20 of 24 pixels whose middle lies 1 to the right of the picture's.
        assert_eq!(side((20, 1), (1, 1), 24), Some([3, 20]));
        assert_eq!(side((19, 1), (1, 2), 24), Some([3, 19]));
        for (length, offset) in
            [((25, 1), (0, 1)), ((0, 1), (0, 1)), ((20, 0), (0, 1)), ((20, 1), (9, 0)), ((20, 1), (9, 1))]
        {
            assert_eq!(side(length, offset, 24), None, "{length:?} {offset:?}");
        }
        let part = Part { at: [1, 1], size: [2, 1] };
        let cut = part.cut(Samples::Eight((0..9).map(|n| [n; 4]).collect()), [3, 3]);
        assert!(matches!(cut, Samples::Eight(px) if px == [[4; 4], [5; 4]]));
    }

    #[test]
    fn colours_by_number_become_profiles() {
        let of = |primaries, transfer| Cicp { primaries, transfer, matrix: 6, full_range: true }.profile();
        assert!(of(1, 13).is_none() && of(2, 2).is_none() && of(1, 1).is_none() && of(0, 0).is_none());
        for (primaries, transfer, word) in [(12, 13, "P3"), (9, 14, "Bt2020"), (1, 8, "Linear"), (1, 4, "Bt470M")] {
            let name = super::super::profile_name(&of(primaries, transfer).unwrap()).unwrap();
            assert!(name.contains(word), "{name}");
        }
        assert!(of(999, 13).is_none());
    }
}
