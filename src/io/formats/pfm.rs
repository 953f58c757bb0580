//! PFM: maps of 32-bit floats, rows bottom-up (Debevec's portable float map).

use std::io::{self, Write};
use std::path::Path;

use super::depth_map::DepthMap;
use crate::field::{DisparityMap, Raster};
use crate::io::file_type::FileType;
use crate::io::open::{MAX_FILE_BYTES, read_up_to};
use crate::io::raster::check_size;
use crate::io::{OpenError, Problem};

const FORMAT: &str = "PFM";
/// PFM maps: disparities in px per view step at their own width.
pub(crate) const TYPE: FileType = FileType {
    name: FORMAT,
    suffixes: &["pfm"],
    begins: |bytes| matches!(bytes, [b'P', b'f' | b'F', b'\n' | b'\r' | b' ', ..]),
    map: Some(|bytes| parse_pfm(bytes).map(|values| DepthMap { values, is_disparity: true })),
    ..FileType::UNKNOWN
};
/// A header with comments that somebody wrote by hand.
const MAX_HEADER_BYTES: u64 = 64 << 10;

/// Reads a map of one channel from a file.
///
/// # Errors
/// [`OpenError`], if it is cut off, too large, or has three channels.
pub fn read_pfm(path: &Path) -> Result<DisparityMap, OpenError> {
    read_up_to(path, MAX_FILE_BYTES).and_then(|bytes| disparity(parse_pfm(&bytes)?)).map_err(OpenError::at(Some(path)))
}

/// Reads disparities that must have this size; a file that is too long for it is not read.
pub(crate) fn read_sized(path: &Path, size: [u32; 2]) -> Result<DisparityMap, Problem> {
    disparity(values_sized(path, size)?)
}

/// The same, whatever its values are.
pub(super) fn values_sized(path: &Path, size: [u32; 2]) -> Result<Raster<f32>, Problem> {
    let most = u64::from(size[0]) * u64::from(size[1]) * 4 + MAX_HEADER_BYTES;
    let map = parse_pfm(&read_up_to(path, most)?)?;
    if map.size() != size {
        let ([w, h], [want_w, want_h]) = (map.size(), size);
        return Err(Problem::damaged(FORMAT, format!("it has {w}×{h} values for views of {want_w}×{want_h} pixels")));
    }
    Ok(map)
}

/// The values as disparities.
fn disparity(map: Raster<f32>) -> Result<DisparityMap, Problem> {
    DisparityMap::new(map.size(), map.into_pixels()).map_err(Problem::Map)
}

/// Reads a map of one channel from memory, whatever its values are.
///
/// # Errors
/// [`Problem`], if it is cut off, too large, or has three channels.
pub fn parse_pfm(bytes: &[u8]) -> Result<Raster<f32>, Problem> {
    let mut rest = bytes;
    if next_word(&mut rest)? != "Pf" {
        return Err(Problem::damaged(FORMAT, "a map of one channel begins with `Pf`"));
    }
    let width: u32 = next_number(&mut rest)?;
    let height: u32 = next_number(&mut rest)?;
    let scale: f32 = next_number(&mut rest)?;
    check_size(width.into(), height.into(), 4, bytes.len())?;
    if scale == 0.0 || !scale.is_finite() {
        return Err(Problem::damaged(FORMAT, "its scale is 0 or not a number"));
    }
    let plane = width as usize * height as usize;
    let data = rest.get(..plane * 4).ok_or(Problem::Truncated { format: FORMAT })?;
    let factor = scale.abs();
    let value = |b: &[u8; 4]| factor * if scale < 0.0 { f32::from_le_bytes(*b) } else { f32::from_be_bytes(*b) };
    let rows = data.as_chunks().0.chunks_exact(width as usize).rev();
    Ok(Raster::new([width, height], rows.flatten().map(value).collect())?)
}

/// The next word of the header; comment lines are skipped, one white space behind the word is eaten.
fn next_word<'a>(rest: &mut &'a [u8]) -> Result<&'a str, Problem> {
    let bad = || Problem::damaged(FORMAT, "its header is not text");
    loop {
        while let [b' ' | b'\t' | b'\r' | b'\n', tail @ ..] = rest {
            *rest = tail;
        }
        if rest.first() != Some(&b'#') {
            break;
        }
        let line = rest.iter().position(|&b| b == b'\n').ok_or(Problem::Truncated { format: FORMAT })?;
        *rest = &rest[line..];
    }
    let end = rest.iter().take(64).position(u8::is_ascii_whitespace).ok_or_else(bad)?;
    let word = std::str::from_utf8(&rest[..end]).map_err(|_utf8| bad())?;
    // Windows line ends have two characters; the second one is not data, as a float may not begin behind a lone `\r`.
    let behind = if rest[end..].starts_with(b"\r\n") { end + 2 } else { end + 1 };
    *rest = &rest[behind..];
    Ok(word)
}

fn next_number<T: std::str::FromStr>(rest: &mut &[u8]) -> Result<T, Problem> {
    let word = next_word(rest)?;
    word.parse().map_err(|_parse| Problem::damaged(FORMAT, format!("`{word}` in its header is no number")))
}

/// Writes a map, little-endian, bottom-up, scale 1; every bit of every value is kept.
///
/// # Errors
/// What the writer says.
pub fn write_pfm(out: &mut impl Write, size: [u32; 2], values: &[f32]) -> io::Result<()> {
    write!(out, "Pf\n{} {}\n-1.0\n", size[0], size[1])?;
    let mut line = Vec::with_capacity(size[0] as usize * 4);
    for row in values.chunks_exact(size[0].max(1) as usize).rev() {
        line.clear();
        line.extend(row.iter().flat_map(|value| value.to_le_bytes()));
        out.write_all(&line)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> Raster<f32> {
        Raster::new([3, 2], vec![1.0, -2.5, 0.1, f32::MIN_POSITIVE, 4e9, -0.0]).unwrap()
    }

    fn written() -> Vec<u8> {
        let mut bytes = Vec::new();
        write_pfm(&mut bytes, map().size(), map().pixels()).unwrap();
        bytes
    }

    #[test]
    fn every_bit_survives() {
        let back = parse_pfm(&written()).unwrap();
        assert_eq!(back.size(), map().size());
        let bits = |map: &Raster<f32>| map.pixels().iter().map(|d| d.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&map()));
    }

    #[test]
    fn rows_lie_bottom_up_and_big_endian_scales_and_comments_are_read() {
        let mut bytes = b"Pf\n# made by hand\n1 2\n2.0\n".to_vec();
        bytes.extend(1.0f32.to_be_bytes());
        bytes.extend(3.0f32.to_be_bytes());
        let map = parse_pfm(&bytes).unwrap();
        assert_eq!(map.pixels(), [6.0, 2.0]);
    }

    #[test]
    fn cut_off_and_lying_files_are_refused() {
        let whole = written();
        for end in 0..whole.len() {
            assert!(parse_pfm(&whole[..end]).is_err(), "cut at {end}");
        }
        assert!(matches!(parse_pfm(b"Pf\n40000 40000\n-1\n"), Err(Problem::TooLarge { .. })));
        assert!(matches!(parse_pfm(b"Pf\n16000 16000\n-1\n"), Err(Problem::Implausible { .. })));
        assert!(parse_pfm(b"Pf\n4 4\n0\n0123").is_err());
        assert!(parse_pfm(b"PF\n1 1\n-1\n000011112222").is_err());
    }
}
