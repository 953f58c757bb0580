//! What goes through the pipes between a program and its decoder. Numbers are little-endian. Neither side believes the
//! other a length that it cannot bear.

use std::io::{self, Read, Write};

use heifer::heifer_isobmff::ItemId;
use rayon::prelude::*;

use super::{Decoded, RgbaPixels};
use crate::io::Problem;
use crate::io::formats::phone::heic;
use crate::io::open::MAX_FILE_BYTES;
use crate::io::raster::{MAX_DECODED_BYTES, Samples, avif};

/// The longest word of an error.
const MOST_LETTERS: u64 = 4096;
/// Numbers of 16 bits that are sent at once.
const PIECE: usize = 1 << 15;
/// The smallest page of any system, and what a thread touches at once: a large page.
const PAGE_BYTES: usize = 1 << 12;
const TOUCHED_BYTES: usize = 1 << 21;

/// What is to be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Task {
    /// The main picture of a HEIC file.
    Heic,
    /// Another picture of a HEIC file.
    HeicItem(ItemId),
    /// The main picture of an AVIF file.
    Avif,
}

impl Task {
    pub(super) fn decode(self, bytes: &[u8]) -> Result<Decoded, Problem> {
        match self {
            Self::Heic => heic::decode_pixels(bytes),
            Self::HeicItem(id) => heic::decode_other(bytes, id),
            Self::Avif => avif::decode_pixels(bytes),
        }
    }

    pub(super) fn format(self) -> &'static str {
        match self {
            Self::Heic | Self::HeicItem(_) => heic::FORMAT,
            Self::Avif => avif::FORMAT,
        }
    }

    fn number(self) -> [u32; 2] {
        match self {
            Self::Heic => [0, 0],
            Self::HeicItem(id) => [1, id],
            Self::Avif => [2, 0],
        }
    }

    fn of(number: [u32; 2]) -> io::Result<Self> {
        match number {
            [0, _] => Ok(Self::Heic),
            [1, id] => Ok(Self::HeicItem(id)),
            [2, _] => Ok(Self::Avif),
            _ => Err(io::ErrorKind::InvalidData.into()),
        }
    }
}

pub(super) fn write_request(to: &mut impl Write, task: Task, bytes: &[u8]) -> io::Result<()> {
    let [kind, id] = task.number();
    to.write_all(&[kind.to_le_bytes(), id.to_le_bytes()].concat())?;
    to.write_all(&(bytes.len() as u64).to_le_bytes())?;
    to.write_all(bytes)
}

pub(super) fn read_request(from: &mut impl Read) -> io::Result<(Task, Vec<u8>)> {
    let task = Task::of([number(from)?, number(from)?])?;
    let length = u64::from(number(from)?) | u64::from(number(from)?) << 32;
    Ok((task, read_bytes(from, length, MAX_FILE_BYTES)?))
}

pub(super) fn write_answer(to: &mut impl Write, answer: &Result<Decoded, Problem>) -> io::Result<()> {
    let decoded = match answer {
        Ok(decoded) => decoded,
        Err(problem) => return write_problem(to, problem),
    };
    let is_deep = matches!(decoded.pixels, RgbaPixels::Samples(Samples::Sixteen(_)));
    let head = [0, decoded.size[0], decoded.size[1], u32::from(is_deep) | u32::from(decoded.has_alpha) << 1];
    let told = decoded.told.map(u32::from);
    head.iter().chain(&told).try_for_each(|number| to.write_all(&number.to_le_bytes()))?;
    match &decoded.pixels {
        RgbaPixels::Bytes(bytes) => to.write_all(bytes),
        RgbaPixels::Samples(Samples::Eight(pixels)) => to.write_all(pixels.as_flattened()),
        RgbaPixels::Samples(Samples::Sixteen(pixels)) => pixels.as_flattened().chunks(PIECE).try_for_each(|values| {
            to.write_all(&values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
        }),
    }
}

pub(super) fn read_answer(from: &mut impl Read, task: Task) -> io::Result<Result<Decoded, Problem>> {
    let kind = number(from)?;
    if kind != 0 {
        return read_problem(from, kind, task.format()).map(Err);
    }
    let size = [number(from)?, number(from)?];
    let flags = number(from)?;
    let mut told = [0; 4];
    for value in &mut told {
        *value = number(from)? as u16;
    }
    let is_deep = flags & 1 != 0;
    let count = u64::from(size[0]) * u64::from(size[1]);
    if count.saturating_mul(if is_deep { 8 } else { 4 }) > MAX_DECODED_BYTES {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let samples = if is_deep {
        let mut pixels = vec![[0_u16; 4]; count as usize];
        let mut piece = vec![0; 2 * PIECE];
        for values in pixels.as_flattened_mut().chunks_mut(PIECE) {
            let bytes = &mut piece[..2 * values.len()];
            from.read_exact(bytes)?;
            values.iter_mut().zip(bytes.as_chunks().0).for_each(|(value, two)| *value = u16::from_le_bytes(*two));
        }
        Samples::Sixteen(pixels)
    } else {
        let mut pixels = vec![[0_u8; 4]; count as usize];
        touch(pixels.as_flattened_mut());
        from.read_exact(pixels.as_flattened_mut())?;
        Samples::Eight(pixels)
    };
    Ok(Ok(Decoded { size, pixels: RgbaPixels::Samples(samples), has_alpha: flags & 2 != 0, told }))
}

/// Writes to each page of fresh memory, on all threads: the system clears it then, which takes longer than what comes
/// through the pipe.
fn touch(bytes: &mut [u8]) {
    bytes.par_chunks_mut(TOUCHED_BYTES).for_each(|part| part.iter_mut().step_by(PAGE_BYTES).for_each(|byte| *byte = 0));
}

/// A problem is its kind, its words and its numbers; what has no kind is told as damage.
fn write_problem(to: &mut impl Write, problem: &Problem) -> io::Result<()> {
    let (kind, words, numbers): (u32, String, [u64; 3]) = match problem {
        Problem::Truncated { .. } => (1, String::new(), [0; 3]),
        Problem::Damaged { reason, .. } => (2, reason.clone(), [0; 3]),
        Problem::Unsupported { reason, .. } => (3, reason.clone(), [0; 3]),
        Problem::TooLarge { width, height, limit_mib } => (4, String::new(), [*width, *height, *limit_mib]),
        Problem::Implausible { width, height, file_kib } => (5, String::new(), [*width, *height, *file_kib as u64]),
        other => (2, other.to_string(), [0; 3]),
    };
    to.write_all(&kind.to_le_bytes())?;
    numbers.iter().try_for_each(|number| to.write_all(&number.to_le_bytes()))?;
    to.write_all(&(words.len() as u32).to_le_bytes())?;
    to.write_all(words.as_bytes())
}

fn read_problem(from: &mut impl Read, kind: u32, format: &'static str) -> io::Result<Problem> {
    let mut long = || Ok::<_, io::Error>(u64::from(number(from)?) | u64::from(number(from)?) << 32);
    let [width, height, third] = [long()?, long()?, long()?];
    let length = u64::from(number(from)?);
    let reason = String::from_utf8_lossy(&read_bytes(from, length, MOST_LETTERS)?).into_owned();
    Ok(match kind {
        1 => Problem::Truncated { format },
        3 => Problem::Unsupported { format, reason, advice: "save it as JPEG or PNG" },
        4 => Problem::TooLarge { width, height, limit_mib: third },
        5 => Problem::Implausible { width, height, file_kib: third as usize },
        _ => Problem::damaged(format, reason),
    })
}

fn number(from: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

fn read_bytes(from: &mut impl Read, length: u64, most: u64) -> io::Result<Vec<u8>> {
    if length > most {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let mut bytes = Vec::new();
    from.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(answer: Result<Decoded, Problem>) -> Result<Decoded, Problem> {
        let mut bytes = Vec::new();
        write_answer(&mut bytes, &answer).unwrap();
        let back = read_answer(&mut &bytes[..], Task::Avif).unwrap();
        for cut in 0..bytes.len() {
            assert!(read_answer(&mut &bytes[..cut], Task::Avif).is_err(), "cut at {cut}");
        }
        back
    }

    #[test]
    fn requests_come_through() {
        for task in [Task::Heic, Task::HeicItem(70_000), Task::Avif] {
            let mut bytes = Vec::new();
            write_request(&mut bytes, task, b"file").unwrap();
            assert_eq!(read_request(&mut &bytes[..]).unwrap(), (task, b"file".to_vec()));
            assert!(read_request(&mut &bytes[..bytes.len() - 1]).is_err());
        }
        assert!(read_request(&mut &[9; 16][..]).is_err(), "no such task");
        assert!(read_request(&mut &[&[0; 8][..], &[255; 8]].concat()[..]).is_err(), "no such length");
    }

    #[test]
    fn pictures_and_problems_come_through() {
        let bytes = RgbaPixels::Bytes(vec![1, 2, 3, 4, 5, 6, 7, 8]);
        let back = through(Ok(Decoded { size: [2, 1], pixels: bytes, has_alpha: true, told: [9, 16, 9, 1] })).unwrap();
        assert_eq!((back.size, back.has_alpha, back.told), ([2, 1], true, [9, 16, 9, 1]));
        assert!(matches!(back.pixels.into_samples(), Samples::Eight(px) if px == [[1, 2, 3, 4], [5, 6, 7, 8]]));
        let sixteen = RgbaPixels::Samples(Samples::Sixteen(vec![[1000, 2, 3, 65_535]]));
        let back = through(Ok(Decoded { size: [1, 1], pixels: sixteen, has_alpha: false, told: [0; 4] })).unwrap();
        assert!(matches!(back.pixels.into_samples(), Samples::Sixteen(px) if px == [[1000, 2, 3, 65_535]]));
        let advice = "save it as JPEG or PNG";
        for problem in [
            Problem::Truncated { format: "AVIF" },
            Problem::damaged("AVIF", "it is odd"),
            Problem::Unsupported { format: "AVIF", reason: "it is new".to_owned(), advice },
            Problem::TooLarge { width: 1 << 40, height: 3, limit_mib: 1024 },
            Problem::Implausible { width: 5, height: 6, file_kib: 7 },
        ] {
            let text = problem.to_string();
            assert_eq!(through(Err(problem)).unwrap_err().to_string(), text);
        }
    }

    #[test]
    fn a_size_that_cannot_be_is_not_allocated() {
        let head = [0_u32, u32::MAX, u32::MAX, 0, 0, 0, 0, 0];
        let bytes: Vec<u8> = head.iter().flat_map(|number| number.to_le_bytes()).collect();
        assert!(read_answer(&mut &bytes[..], Task::Heic).is_err());
    }
}
