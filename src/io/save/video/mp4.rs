//! ISO base media (MP4) with one AV1 track: the tables first, so that a film begins before it has come whole.

use std::io::{self, Write};

use super::Film;

/// A turn by nothing, as 16.16 and 2.30 numbers.
const MATRIX: [u32; 9] = [0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000];

/// Writes the file.
pub(super) fn write(out: &mut dyn Write, film: &Film) -> io::Result<()> {
    let kind = boxed(b"ftyp", [b"isom".as_slice(), &0x200u32.to_be_bytes(), b"isomiso6av01mp41"].concat());
    // The tables name the first frame's place, which is after them; their length does not hang on it.
    let tables = |first: u32| boxed(b"moov", [header(film), track(film, first)].concat());
    let first = kind.len() + tables(0).len() + 8;
    let bytes: usize = film.frames.iter().map(|frame| frame.data.len()).sum();
    let whole = |len: usize| u32::try_from(len).map_err(|e| io::Error::other(format!("a film of more than 4 GB: {e}")));
    out.write_all(&kind)?;
    out.write_all(&tables(whole(first + bytes)? - bytes as u32))?;
    out.write_all(&whole(bytes + 8)?.to_be_bytes())?;
    out.write_all(b"mdat")?;
    film.frames.iter().try_for_each(|frame| out.write_all(&frame.data))
}

fn boxed(kind: &[u8; 4], content: Vec<u8>) -> Vec<u8> {
    [&(content.len() as u32 + 8).to_be_bytes()[..], kind, &content].concat()
}

/// A box with a version and flags.
fn full(kind: &[u8; 4], flags: u32, content: &[&[u8]]) -> Vec<u8> {
    boxed(kind, [&flags.to_be_bytes()[..], &content.concat()].concat())
}

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

fn frames(film: &Film) -> u32 {
    film.frames.len() as u32
}

/// The film's clock counts frames.
fn header(film: &Film) -> Vec<u8> {
    let clock = words(&[0, 0, film.frames_per_second, frames(film), 0x1_0000]);
    full(b"mvhd", 0, &[&clock, &[1, 0], &[0; 10], &words(&MATRIX), &[0; 24], &words(&[2])])
}

fn track(film: &Film, first: u32) -> Vec<u8> {
    let size = film.size.map(|side| side << 16);
    let place = words(&[0, 0, 1, 0, frames(film), 0, 0, 0, 0]);
    let head = full(b"tkhd", 3, &[&place, &words(&MATRIX), &words(&size)]);
    let clock =
        full(b"mdhd", 0, &[&words(&[0, 0, film.frames_per_second, frames(film)]), &0x55c4u16.to_be_bytes(), &[0; 2]]);
    let handler = full(b"hdlr", 0, &[&[0; 4], b"vide", &[0; 12], b"Plenoscope\0"]);
    let own_file = full(b"dref", 0, &[&words(&[1]), &full(b"url ", 1, &[])]);
    let inside = [full(b"vmhd", 1, &[&[0; 8]]), boxed(b"dinf", own_file), samples(film, first)].concat();
    boxed(b"trak", [head, boxed(b"mdia", [clock, handler, boxed(b"minf", inside)].concat())].concat())
}

/// What the frames are, how long, which can be jumped to, how large, and where.
fn samples(film: &Film, first: u32) -> Vec<u8> {
    let count = frames(film);
    let keys: Vec<u32> = (1..).zip(&film.frames).filter(|(_, frame)| frame.is_key).map(|(number, _)| number).collect();
    let sizes: Vec<u32> = film.frames.iter().map(|frame| frame.data.len() as u32).collect();
    let parts = [
        full(b"stsd", 0, &[&words(&[1]), &entry(film)]),
        full(b"stts", 0, &[&words(&[1, count, 1])]),
        full(b"stss", 0, &[&words(&[keys.len() as u32]), &words(&keys)]),
        full(b"stsc", 0, &[&words(&[1, 1, count, 1])]),
        full(b"stsz", 0, &[&words(&[0, count]), &words(&sizes)]),
        full(b"stco", 0, &[&words(&[1, first])]),
    ];
    boxed(b"stbl", parts.concat())
}

/// The AV1 sample entry: size, 72 dots an inch, colours, and the codec's own record.
fn entry(film: &Film) -> Vec<u8> {
    let size = film.size.map(|side| (side as u16).to_be_bytes()).concat();
    let picture = [
        &[0; 6][..],
        &[0, 1],
        &[0; 16],
        &size,
        &words(&[0x48_0000, 0x48_0000, 0]),
        &[0, 1],
        &[0; 32],
        &[0, 24, 0xff, 0xff],
    ];
    // Primaries 1, curve 13, matrix 1, not the full range: as in the sequence header.
    let colors = boxed(b"colr", [b"nclx".as_slice(), &[0, 1, 0, 13, 0, 1, 0]].concat());
    boxed(b"av01", [picture.concat(), boxed(b"av1C", film.codec.clone()), colors].concat())
}
