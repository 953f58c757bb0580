//! One picture as AV1 codes it: three planes of numbers (or one), of 8, 10 or 12 bits.

use re_rav1d::dav1d::{Decoder, Error, Picture, PixelLayout, PlanarImageComponent, Settings};

use super::FORMAT;
use crate::io::Problem;
use crate::io::raster::heif::Cicp;
use crate::panics;

/// Most frames in one picture: a progressive one has up to four, each with what it refers to.
const MAX_FRAMES: usize = 8;

/// A decoded picture.
pub(super) struct Coded {
    picture: Picture,
    pub(super) size: [u32; 2],
    /// Bits of a number: 8, 10 or 12.
    pub(super) bits: usize,
    /// Pixels of one colour sample, across and down; none where there is no colour.
    pub(super) subsampled: Option<[usize; 2]>,
    /// What the codec's own header says of the colours; the container comes first.
    pub(super) cicp: Cicp,
}

/// Decodes a picture of the size that the container says; `operating_point` picks among layers.
pub(super) fn decode(data: &[u8], size: [u32; 2], operating_point: u8) -> Result<Coded, Problem> {
    // The decoder takes nothing for a mistake of its caller.
    if data.is_empty() {
        return Err(Problem::Truncated { format: FORMAT });
    }
    if frames(data) > MAX_FRAMES {
        return Err(Problem::damaged(FORMAT, format!("one picture of it has more than {MAX_FRAMES} frames")));
    }
    panics::caught(|| decode_first(data.to_vec(), size, operating_point))
        .unwrap_or_else(|| Err(Problem::damaged(FORMAT, "the codec cannot make sense of it")))
}

fn decode_first(data: Vec<u8>, size: [u32; 2], operating_point: u8) -> Result<Coded, Problem> {
    let mut settings = Settings::new();
    // Tiles of a grid are decoded side by side; within one, a thread that breaks would leave the others waiting.
    settings.set_n_threads(1);
    settings.set_max_frame_delay(1);
    settings.set_all_layers(false);
    settings.set_operating_point(u32::from(operating_point & 31));
    settings.set_frame_size_limit(size[0].saturating_mul(size[1]));
    let mut decoder = Decoder::with_settings(&settings).map_err(problem)?;
    match decoder.send_data(data, None, None, None) {
        Ok(()) | Err(Error::Again) => {}
        Err(error) => return Err(problem(error)),
    }
    // A picture in layers comes out when the decoder hears that no more follow.
    let picture = decoder.get_picture().or_else(|_first| decoder.get_picture()).map_err(problem)?;
    Coded::new(picture, size)
}

fn problem(error: Error) -> Problem {
    match error {
        Error::Again => Problem::Truncated { format: FORMAT },
        Error::InvalidArgument => Problem::damaged(FORMAT, "its picture data contradict themselves"),
        Error::NotEnoughMemory => Problem::damaged(FORMAT, "there is not enough memory for it"),
        Error::UnsupportedBitstream => Problem::damaged(FORMAT, "its picture data are not those of AV1"),
        _ => Problem::damaged(FORMAT, "its picture data do not fit its header"),
    }
}

impl Coded {
    fn new(picture: Picture, size: [u32; 2]) -> Result<Self, Problem> {
        let own = [picture.width(), picture.height()];
        if own != size {
            let reason = format!("a picture of {}×{} pixels, where {}×{} are told", own[0], own[1], size[0], size[1]);
            return Err(Problem::damaged(FORMAT, reason));
        }
        let subsampled = match picture.pixel_layout() {
            PixelLayout::I400 => None,
            PixelLayout::I420 => Some([2, 2]),
            PixelLayout::I422 => Some([2, 1]),
            PixelLayout::I444 => Some([1, 1]),
        };
        // These panic on reserved numbers, which is caught.
        let cicp = Cicp {
            primaries: picture.color_primaries() as u16,
            transfer: picture.transfer_characteristic() as u16,
            matrix: picture.matrix_coefficients() as u16,
            full_range: is_full_range(&picture),
        };
        Ok(Self { size, bits: picture.bit_depth(), subsampled, cicp, picture })
    }

    /// A row of a plane: 0 is brightness, 1 and 2 are colours.
    pub(super) fn read_row(&self, plane: usize, y: usize, row: &mut [f32]) {
        let plane = PlanarImageComponent::from(plane);
        let bytes = self.picture.plane(plane);
        let bytes = &bytes[y * self.picture.stride(plane) as usize..];
        if self.bits == 8 {
            row.iter_mut().zip(bytes).for_each(|(to, &from)| *to = f32::from(from));
        } else {
            row.iter_mut().zip(bytes.as_chunks().0).for_each(|(to, &two)| *to = f32::from(u16::from_ne_bytes(two)));
        }
    }
}

fn is_full_range(picture: &Picture) -> bool {
    matches!(picture.color_range(), re_rav1d::dav1d::pixel::YUVRange::Full)
}

/// Counts the frames in a chain of open bitstream units (AV1 specification, 5.3).
fn frames(data: &[u8]) -> usize {
    const FRAME_HEADER: u8 = 3;
    const FRAME: u8 = 6;
    let (mut at, mut count) = (0, 0);
    while let Some(&head) = data.get(at) {
        let kind = head >> 3 & 15;
        count += usize::from(kind == FRAME || kind == FRAME_HEADER);
        at += 1 + usize::from(head >> 2 & 1);
        if head & 2 == 0 {
            break;
        }
        let Some((length, length_bytes)) = leb128(&data[at.min(data.len())..]) else { break };
        at = at.saturating_add(length_bytes).saturating_add(length);
    }
    count
}

/// A number of 7 bits a byte, the lowest first, and how many bytes it takes.
fn leb128(bytes: &[u8]) -> Option<(usize, usize)> {
    let last = bytes.iter().take(8).position(|byte| byte & 0x80 == 0)?;
    let number = bytes[..=last].iter().rev().fold(0u64, |number, byte| number << 7 | u64::from(byte & 0x7f));
    Some((usize::try_from(number).ok()?, last + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_counted() {
        // Temporal delimiter, sequence header of 2 bytes, frame of 130 bytes with extension, frame header to the end.
        let mut data = vec![0x12, 0, 0x0a, 2, 9, 9, 0x36, 0, 0x82, 0x01];
        data.extend([0; 130]);
        data.extend([0x18, 1, 2, 3]);
        assert_eq!(frames(&data), 2);
        assert_eq!(frames(&[0x32, 0xff, 0xff]), 1);
        assert_eq!(frames(&[]), 0);
    }
}
