//! Both eyes as two JPEGs in one file (MPO; CIPA DC-007, type "disparity"): for 3-D screens, cameras and viewers that know it.
//! Who does not know it sees the left eye's picture.

use std::io::Write;
use std::path::Path;

use jpeg_encoder::{ColorType as JpegColor, Encoder, SamplingFactor};

use super::out;
use crate::field::Picture;
use crate::io::save::SaveError;

/// The left eye's picture, which stands for both, and the right eye's.
const TYPES: [u32; 2] = [0x2002_0002, 0x0002_0002];
/// What an index begins with.
const HEAD: &[u8] = b"MPF\0";
/// Quality of the JPEGs.
const QUALITY: u8 = 95;

/// Writes two pictures of one size, left eye first.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, left: &Picture, right: &Picture) -> Result<(), SaveError> {
    let why = |why: String| SaveError::Encode { why, path: path.to_owned() };
    let right = jpeg(right, &individual(2)).map_err(why)?;
    let mut left = jpeg(left, &index([0, right.len()], 0)).map_err(why)?;
    let at = left.windows(HEAD.len()).position(|window| window == HEAD).map_or(0, |at| at + HEAD.len());
    let index = index([left.len(), right.len()], left.len() - at);
    left[at - HEAD.len()..at - HEAD.len() + index.len()].copy_from_slice(&index);
    out::single(path, |out| out.write_all(&left).and_then(|()| out.write_all(&right)))
}

/// The index of the pictures: their lengths, and where the second one begins, counted from behind the head.
fn index(lengths: [usize; 2], second: usize) -> Vec<u8> {
    let mut entries = Vec::new();
    for ((kind, length), offset) in TYPES.into_iter().zip(lengths).zip([0, second]) {
        [kind, length as u32, offset as u32, 0].iter().for_each(|number| entries.extend(number.to_be_bytes()));
    }
    // Behind the head, the count, three fields and the end of the list.
    let place = 8 + 2 + 3 * 12 + 4;
    let fields = [
        field(0xb000, 7, 4, *b"0100"),
        field(0xb001, 4, 1, 2u32.to_be_bytes()),
        field(0xb002, 7, 32, [0, 0, 0, place]),
    ];
    [HEAD, b"MM\0\x2a\0\0\0\x08\0\x03", &fields.concat(), &[0; 4], &entries].concat()
}

/// Which picture of the file it is.
fn individual(number: u32) -> Vec<u8> {
    let fields = [field(0xb000, 7, 4, *b"0100"), field(0xb101, 4, 1, number.to_be_bytes())];
    [HEAD, b"MM\0\x2a\0\0\0\x08\0\x02", &fields.concat(), &[0; 4]].concat()
}

/// A field of a TIFF directory.
fn field(tag: u16, kind: u16, count: u32, value: [u8; 4]) -> Vec<u8> {
    [&tag.to_be_bytes()[..], &kind.to_be_bytes(), &count.to_be_bytes(), &value].concat()
}

fn jpeg(picture: &Picture, segment: &[u8]) -> Result<Vec<u8>, String> {
    let [width, height] = picture.size.map(u16::try_from);
    let (Ok(width), Ok(height)) = (width, height) else { return Err("a JPEG is at most 65535 pixels wide".to_owned()) };
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, QUALITY);
    encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
    encoder.add_app_segment(2, segment).map_err(|error| error.to_string())?;
    encoder.encode(&picture.to_srgb8(), width, height, JpegColor::Rgba).map_err(|error| error.to_string())?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::several;
    use crate::job::{Cancel, Job};

    #[test]
    fn both_eyes_are_read_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("pair.mpo");
        let plain = |light: [f32; 3]| Picture { size: [24, 16], rgb_linear: light.repeat(24 * 16) };
        write(&path, &plain([0.8, 0.0, 0.0]), &plain([0.0, 0.0, 0.8])).unwrap();
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let eyes = several::photos(&path, &job).unwrap();
        let red = |eye: usize| eyes[eye].photo.srgb8()[0];
        assert!(eyes.len() == 2 && red(0) > 200 && red(1) < 30, "left is the red one");
    }
}
