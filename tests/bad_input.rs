//! Bad input of every format: one sentence, no panic, bounded memory; a photo whose extra depth is broken still opens.
//!
//! Each reader also gets files that are damaged at random, the same ones at every run. `PLENOSCOPE_FUZZ_SECS=600
//! cargo test --test bad_input` goes on for that long with each; `scripts/fuzz.sh` tries them with a coverage-guided fuzzer.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![allow(unsafe_code, reason = "an allocator that counts cannot be written without")]

#[path = "bad_input/alloc.rs"]
mod alloc;
#[path = "bad_input/cases.rs"]
mod cases;
#[path = "bad_input/harness.rs"]
mod harness;
#[path = "common/nets.rs"]
mod nets;
#[path = "bad_input/readers.rs"]
mod readers;
#[path = "bad_input/seeds.rs"]
mod seeds;

use std::path::Path;

use harness::fuzz;
use plenoscope::io::formats::TABLE;
use plenoscope::io::{self, OpenError, Opened};
use plenoscope::job::{Cancel, Job};

#[global_allocator]
static ALLOCATOR: alloc::Counting = alloc::Counting;

fn open(bytes: &[u8]) -> Result<Opened, OpenError> {
    io::open_bytes(bytes, None)
}

fn open_path(path: &Path) -> Result<Opened, OpenError> {
    io::open(path, &Job { cancel: &Cancel::default(), sink: &() })
}

#[test]
fn every_line_of_the_table_that_is_read_is_damaged_here() {
    for line in TABLE.iter().filter(|line| line.is_read()) {
        assert!(
            !seeds::of(line.name).is_empty(),
            "the table reads \"{}\", and no file of it is damaged here",
            line.name
        );
    }
}

#[test]
fn every_reader() {
    // For two cores, or to try one again: `PLENOSCOPE_FUZZ_ONLY=jpeg,png`.
    let only = std::env::var("PLENOSCOPE_FUZZ_ONLY").ok();
    let is_asked = |name: &str| only.as_ref().is_none_or(|only| only.split(',').any(|asked| asked == name));
    for reader in readers::all().iter().filter(|reader| is_asked(&reader.name)) {
        fuzz(&reader.name, &reader.whole, &reader.read);
    }
}
