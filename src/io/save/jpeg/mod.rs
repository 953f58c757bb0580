//! JPEG in strips on all cores, with Huffman tables made for the picture (ITU-T T.81).
//!
//! Each strip is encoded alone with the standard's example tables; between strips stands a restart marker. What symbols
//! all of them have says which tables are best, and each strip's symbols are written anew with those. So no more of a
//! picture lies in memory than its finished strips, all components go in one scan as cameras write them, and the pixels
//! are those that the encoder alone would give.

mod huffman;
mod scan;

use std::io::{Error, Write};

use jpeg_encoder::{ColorType, Encoder, EncodingError, SamplingFactor};
use rayon::prelude::*;

use huffman::{Counts, TABLES, Table};

/// Rows of a strip: blocks of 8×8 pixels, of which a restart interval may have 65,535.
const STRIP_ROWS: usize = 64;

/// How a picture is written.
pub struct Options<'a> {
    /// 1 … 100.
    pub quality: u8,
    /// Contents of segments 1 (EXIF, XMP), each of at most 65,533 bytes.
    pub segments: &'a [Vec<u8>],
    /// The colour profile.
    pub icc: Option<&'a [u8]>,
}

/// Writes RGB pixels, `[y, x, 3]`; each side has at most 65,535.
pub fn encode(out: &mut impl Write, rgb: &[u8], [width, height]: [u16; 2], how: &Options) -> Result<(), EncodingError> {
    let row = usize::from(width) * 3;
    let parts: Vec<&[u8]> = rgb[..row * usize::from(height)].chunks((row * STRIP_ROWS).max(1)).collect();
    let strips: Vec<Strip> = parts
        .par_iter()
        .enumerate()
        .map(|(i, part)| Strip::new(part, width, i == 0, how))
        .collect::<Result<_, EncodingError>>()?;
    let first = strips.first().ok_or(EncodingError::ZeroImageDimensions { width, height })?;
    let file = Segments::of(&first.bytes).ok_or_else(odd)?;
    let tables = file.tables().ok_or_else(odd)?;
    let counts = strips.par_iter().map(|strip| strip.counts(&tables)).reduce(Counts::default, Counts::plus);
    let best = counts.tables();
    let scans: Vec<Vec<u8>> =
        strips.par_iter().map(|strip| scan::rewritten(strip.scan(), strip.blocks, &tables, &best)).collect();
    let restart = (strips.len() > 1).then_some(first.blocks / 3);
    file.write_head(out, height, &best, restart)?;
    for (i, scan) in scans.iter().enumerate() {
        if i > 0 {
            out.write_all(&[0xFF, RESTART + ((i - 1) % 8) as u8])?;
        }
        out.write_all(scan)?;
    }
    Ok(out.write_all(&[0xFF, END])?)
}

const FRAME: u8 = 0xC0;
const HUFFMAN: u8 = 0xC4;
const RESTART: u8 = 0xD0;
const END: u8 = 0xD9;
const SCAN: u8 = 0xDA;
const INTERVAL: u8 = 0xDD;

/// The encoder has written something else than it is known to write.
fn odd() -> EncodingError {
    EncodingError::IoError(Error::other("the encoder's strip is not as it should be"))
}

/// A strip as a JPEG of its own.
struct Strip {
    bytes: Vec<u8>,
    /// Where its scan begins.
    scan_at: usize,
    /// Blocks of 8×8 values of all components.
    blocks: usize,
}

impl Strip {
    fn new(rgb: &[u8], width: u16, is_first: bool, how: &Options) -> Result<Self, EncodingError> {
        let rows = rgb.len() / (usize::from(width) * 3);
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, how.quality.clamp(1, 100));
        encoder.set_sampling_factor(SamplingFactor::F_1_1);
        for segment in how.segments.iter().filter(|_| is_first) {
            encoder.add_app_segment(1, segment)?;
        }
        if let Some(icc) = how.icc.filter(|_| is_first) {
            encoder.add_icc_profile(icc)?;
        }
        encoder.encode(rgb, width, rows as u16, ColorType::Rgb)?;
        let scan_at = Segments::of(&bytes).ok_or_else(odd)?.scan_at;
        Ok(Self { bytes, scan_at, blocks: usize::from(width).div_ceil(8) * rows.div_ceil(8) * 3 })
    }

    /// Its entropy-coded data, without the end marker.
    fn scan(&self) -> &[u8] {
        &self.bytes[self.scan_at..self.bytes.len() - 2]
    }

    fn counts(&self, tables: &[Table; TABLES]) -> Counts {
        let mut counts = Counts::default();
        scan::each_symbol(self.scan(), self.blocks, tables, |table, symbol, _, _| counts.add(table, symbol));
        counts
    }
}

/// What stands before a JPEG's scan.
struct Segments<'a> {
    /// Each with its marker; the start of the file is the first.
    all: Vec<(u8, &'a [u8])>,
    scan_at: usize,
}

impl<'a> Segments<'a> {
    fn of(bytes: &'a [u8]) -> Option<Self> {
        let mut at = 2;
        let mut all = vec![(bytes.get(1).copied()?, bytes.get(..2)?)];
        loop {
            let [_, marker, high, low] = *bytes.get(at..)?.first_chunk()?;
            let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
            all.push((marker, bytes.get(at..end)?));
            at = end;
            if marker == SCAN {
                return Some(Self { all, scan_at: at });
            }
        }
    }

    /// The Huffman tables, by their numbers.
    fn tables(&self) -> Option<[Table; TABLES]> {
        let found = self.all.iter().filter(|(marker, _)| *marker == HUFFMAN);
        let mut tables: Vec<_> = found.filter_map(|(_, segment)| Table::read(segment.get(4..)?)).collect();
        tables.sort_by_key(|(number, _)| *number);
        tables.into_iter().map(|(_, table)| table).collect::<Vec<_>>().try_into().ok()
    }

    /// The head of a picture of another height with other tables, and a restart marker after every so many units.
    fn write_head(
        &self,
        out: &mut impl Write,
        height: u16,
        tables: &[Table; TABLES],
        restart: Option<usize>,
    ) -> std::io::Result<()> {
        for (marker, segment) in &self.all {
            match *marker {
                HUFFMAN => {}
                FRAME => {
                    let (head, rest) = segment.split_at(5);
                    out.write_all(&[head, &height.to_be_bytes(), &rest[2..]].concat())?;
                }
                SCAN => {
                    for (number, table) in tables.iter().enumerate() {
                        out.write_all(&table.segment(number))?;
                    }
                    if let Some(units) = restart {
                        let [high, low] = (units as u16).to_be_bytes();
                        out.write_all(&[0xFF, INTERVAL, 0, 4, high, low])?;
                    }
                    out.write_all(segment)?;
                }
                _ => out.write_all(segment)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels of a smooth picture with noise in a part of it.
    fn picture(width: usize, height: usize) -> Vec<u8> {
        let mut seed = 7u32;
        let mut pixel = |x: usize, y: usize| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = if x > width / 2 { (seed >> 24) as usize } else { 0 };
            [x * 255 / width, y * 255 / height, noise].map(|v| v as u8)
        };
        (0..width * height).flat_map(|i| pixel(i % width, i / width)).collect()
    }

    fn decoded(bytes: &[u8]) -> Vec<u8> {
        let options = zune_core::options::DecoderOptions::default().set_strict_mode(true);
        let mut decoder = zune_jpeg::JpegDecoder::new_with_options(zune_core::bytestream::ZCursor::new(bytes), options);
        decoder.decode().unwrap()
    }

    #[test]
    fn strips_give_the_pixels_of_one_piece_in_fewer_bytes() {
        for (width, height, quality) in [(1, 1, 92), (17, 63, 92), (16, 64, 5), (203, 65, 100), (333, 717, 92)] {
            let rgb = picture(width, height);
            let mut plain = Vec::new();
            let mut encoder = Encoder::new(&mut plain, quality);
            encoder.set_sampling_factor(SamplingFactor::F_1_1);
            encoder.encode(&rgb, width as u16, height as u16, ColorType::Rgb).unwrap();
            let mut ours = Vec::new();
            let how = Options { quality, segments: &[vec![9; 100]], icc: Some(&[3; 70_000]) };
            encode(&mut ours, &rgb, [width as u16, height as u16], &how).unwrap();
            assert!(decoded(&ours) == decoded(&plain), "{width}×{height}");
            assert!(ours.len() < plain.len() + 70_300, "{width}×{height}: {} {}", ours.len(), plain.len());
            let restarts = ours.windows(2).filter(|pair| matches!(pair, [0xFF, 0xD0..=0xD7])).count();
            assert!(restarts >= height.div_ceil(STRIP_ROWS) - 1);
        }
    }

    #[test]
    fn nothing_is_no_picture() {
        let how = Options { quality: 92, segments: &[], icc: None };
        assert!(encode(&mut Vec::new(), &[], [0, 5], &how).is_err());
        assert!(encode(&mut Vec::new(), &[], [5, 0], &how).is_err());
    }
}
