//! Animated WebP without loss: still pictures of the encoder, put into the container for animations
//! (WebP Container Specification, "Animation").

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use super::SaveError;
use crate::field::Picture;

/// Sides are kept as 24 bits in the container, and as 14 bits in a picture.
const MAX_SIDE: u32 = 1 << 14;
/// Bit of the flags that says that there is an animation.
const ANIMATED: u8 = 1 << 1;
/// A frame stands in place of what is there, and stays.
const REPLACES: u8 = 1 << 1;

/// Writes frames, each shown for `frame_ms`, without end.
pub fn write<W: Write + Seek>(
    out: &mut W,
    size: [u32; 2],
    frames: impl Iterator<Item = Result<Picture, SaveError>>,
    frame_ms: u32,
) -> Result<(), SaveError> {
    if size.into_iter().any(|side| side > MAX_SIDE) {
        let why = "a WebP is at most 16384 pixels wide and high; choose a smaller size".to_owned();
        return Err(SaveError::Encode { why, path: Path::new("").to_owned() });
    }
    let failed = |e: std::io::Error| SaveError::from_io(&e, Path::new(""));
    out.write_all(b"RIFF\0\0\0\0WEBP").map_err(failed)?;
    let mut head = vec![ANIMATED, 0, 0, 0];
    size.into_iter().for_each(|side| head.extend(three_bytes(side - 1)));
    chunk(out, b"VP8X", &head).map_err(failed)?;
    // Background (unused, as frames are opaque) and the number of rounds, 0 for no end.
    chunk(out, b"ANIM", &[0; 6]).map_err(failed)?;
    for picture in frames {
        chunk(out, b"ANMF", &frame(&picture?, frame_ms)?).map_err(failed)?;
    }
    let end = out.stream_position().map_err(failed)?;
    let bytes = u32::try_from(end - 8).map_err(|_too_large| SaveError::Encode {
        why: "a WebP is at most 4 GiB large; choose a smaller size or fewer frames".to_owned(),
        path: Path::new("").to_owned(),
    })?;
    out.seek(SeekFrom::Start(4)).and_then(|_| out.write_all(&bytes.to_le_bytes())).map_err(failed)?;
    out.seek(SeekFrom::Start(end)).map(drop).map_err(failed)
}

/// What stands in a frame's chunk: place, size, time, and the picture's own chunk.
fn frame(picture: &Picture, frame_ms: u32) -> Result<Vec<u8>, SaveError> {
    let [width, height] = picture.size;
    let rgb: Vec<u8> = picture.to_srgb8().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut still = Vec::new();
    image_webp::WebPEncoder::new(&mut still)
        .encode(&rgb, width, height, image_webp::ColorType::Rgb8)
        .map_err(|e| SaveError::Encode { why: e.to_string(), path: Path::new("").to_owned() })?;
    let mut frame = vec![0; 6];
    [width - 1, height - 1, frame_ms].into_iter().for_each(|number| frame.extend(three_bytes(number)));
    frame.push(REPLACES);
    // A still picture is a RIFF head of 12 bytes and one chunk.
    frame.extend_from_slice(still.get(12..).unwrap_or_default());
    Ok(frame)
}

fn three_bytes(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}

fn chunk(out: &mut impl Write, name: &[u8; 4], bytes: &[u8]) -> std::io::Result<()> {
    out.write_all(name)?;
    out.write_all(&(bytes.len() as u32).to_le_bytes())?;
    out.write_all(bytes)?;
    // Chunks begin at even places.
    if bytes.len() % 2 == 1 { out.write_all(&[0]) } else { Ok(()) }
}
