//! What every parser owes: an answer or one sentence, in bounded memory, without a panic.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::alloc::peak_bytes;

/// The most memory that a bad file may cost.
pub const MAX_BYTES: usize = 1 << 30;
/// Files that are tried of each parser where neither `PLENOSCOPE_FUZZ_FILES` nor `PLENOSCOPE_FUZZ_SECS` asks for more.
const FEW: u64 = 120;

/// The most bytes that a parser took since somebody last asked.
static MOST_BYTES: AtomicUsize = AtomicUsize::new(0);
/// One at a time, so that the memory that is counted is that of one parser.
static ALONE: Mutex<()> = Mutex::new(());

/// Runs a parser, and fails where it panics, takes too much memory or says what a person cannot read.
pub fn run<T, E: Display>(what: &str, parse: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    run_within(MAX_BYTES, what, parse)
}

/// The same with a limit of its own.
pub fn run_within<T, E: Display>(
    max_bytes: usize,
    what: &str,
    parse: impl FnOnce() -> Result<T, E>,
) -> Result<T, String> {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let (answer, bytes) = peak_bytes(|| catch_unwind(AssertUnwindSafe(parse)));
    MOST_BYTES.fetch_max(bytes, Ordering::Relaxed);
    assert!(bytes <= max_bytes, "{what}: took {} MiB", bytes >> 20);
    let answer = answer.unwrap_or_else(|_| panic!("{what}: the parser panicked"));
    answer.map_err(|error| {
        let text = error.to_string();
        assert!(!text.contains('\n') && text.contains(" — ") && text.len() < 500, "{what}: {text:?}");
        text
    })
}

/// A small generator, so that a failure can be repeated.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// From 0 up to, not including, `n`.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) % n.max(1) as u64) as usize
    }

    fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// A damaged copy: bits, numbers, lengths, lines, pieces doubled, moved and cut.
    pub fn damage(&mut self, whole: &[u8]) -> Vec<u8> {
        let mut bytes = whole.to_vec();
        for _ in 0..1 + self.below(5) {
            self.damage_once(&mut bytes);
        }
        bytes
    }

    fn damage_once(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return bytes.push(self.below(256) as u8);
        }
        // Heads matter more than pixels.
        let at = if self.below(2) == 0 { self.below(bytes.len().min(256)) } else { self.below(bytes.len()) };
        match self.below(9) {
            0 => bytes[at] ^= 1 << self.below(8),
            1 => bytes[at] = self.pick(&[0, 1, 0x7f, 0x80, 0xff, b'<', b'"', b'0', b'9', b'-']),
            2 | 3 => {
                let number: u64 = self.pick(&[0, 1, 0x7fff, 0xffff, 30_000, 0x7fff_ffff, 0xffff_ffff, u64::MAX]);
                let width = self.pick(&[2, 4, 8]);
                let ends = if self.below(2) == 0 { number.to_be_bytes() } else { number.to_le_bytes() };
                let from = if ends[0] == 0 && number != 0 { 8 - width } else { 0 };
                let room = bytes.len() - at;
                (0..width.min(room)).for_each(|i| bytes[at + i] = ends[(from + i).min(7)]);
            }
            4 => bytes.truncate(at),
            5 => {
                let end = (at + 1 + self.below(64)).min(bytes.len());
                bytes.drain(at..end);
            }
            6 => {
                let from = self.below(bytes.len());
                let piece = bytes[from..(from + 1 + self.below(64)).min(bytes.len())].to_vec();
                bytes.splice(at..at, piece);
            }
            7 => self.other_number(bytes, at),
            _ => (0..1 + self.below(8)).for_each(|_| {
                let at = self.below(bytes.len());
                bytes[at] = self.below(256) as u8;
            }),
        }
    }

    /// Replaces the next number that is written in digits.
    fn other_number(&mut self, bytes: &mut Vec<u8>, at: usize) {
        let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|n| at + n) else { return };
        let end = bytes[start..].iter().position(|b| !b.is_ascii_digit()).map_or(bytes.len(), |n| start + n);
        let number = self.pick(&["0", "-1", "17", "4294967296", "99999999999999999999", "1e300", "NaN", "0.5", ""]);
        bytes.splice(start..end, number.bytes());
    }
}

/// Damages seeds again and again and gives them to a parser: a few times, as often as `PLENOSCOPE_FUZZ_FILES` or for as many
/// seconds as `PLENOSCOPE_FUZZ_SECS` says. A file that fails is kept and named.
pub fn fuzz<T, E: Display>(parser: &str, seeds: &[Vec<u8>], parse: impl Fn(&[u8]) -> Result<T, E>) {
    for whole in seeds {
        assert!(run(parser, || parse(whole)).is_ok(), "{parser}: an undamaged file is refused");
    }
    let asked = |name| std::env::var(name).ok().and_then(|number| number.parse::<u64>().ok());
    let files = asked("PLENOSCOPE_FUZZ_FILES").unwrap_or(FEW);
    let end = asked("PLENOSCOPE_FUZZ_SECS").map(|secs| Instant::now() + Duration::from_secs(secs));
    let mut slowest = (Duration::ZERO, 0);
    MOST_BYTES.store(0, Ordering::Relaxed);
    let mut seed = 0;
    while end.map_or(seed < files, |end| Instant::now() < end) {
        let bytes = Random::new(seed).damage(&seeds[seed as usize % seeds.len()]);
        let started = Instant::now();
        let tried = catch_unwind(AssertUnwindSafe(|| drop(run(parser, || parse(&bytes)))));
        slowest = slowest.max((started.elapsed(), seed));
        if tried.is_err() {
            let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{parser}-{seed}"));
            std::fs::write(&path, &bytes).unwrap();
            panic!("{parser}: damaged file {seed} failed; it is kept: {}", path.display());
        }
        seed += 1;
    }
    let most_mib = MOST_BYTES.load(Ordering::Relaxed).div_ceil(1 << 20);
    let secs = slowest.0.as_secs_f32();
    eprintln!(
        "{parser}: {seed} damaged files, the slowest ({}) took {secs:.2} s, the largest {most_mib} MiB",
        slowest.1
    );
}
