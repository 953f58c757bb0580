//! Every reader under libFuzzer: `FUZZ_READER=jpeg` says which. `FUZZ_SEEDS=folder` writes whole files for all of them there
//! instead, and their names to the output. `scripts/fuzz.sh` does both.
#![no_main]
#![allow(dead_code, clippy::unwrap_used, reason = "parts of the tests, in which a panic is the failure")]

mod kernel;
#[path = "../tests/common/nets.rs"]
mod nets;
#[path = "../tests/bad_input/readers.rs"]
mod readers;
#[path = "../tests/bad_input/seeds.rs"]
mod seeds;

use std::cell::OnceCell;
use std::fs;
use std::path::PathBuf;

use readers::Reader;

thread_local! {
    /// libFuzzer works in one thread.
    static ASKED: OnceCell<Reader> = const { OnceCell::new() };
}

fn all() -> Vec<Reader> {
    let mut all = readers::all();
    all.push(kernel::as_reader());
    all
}

fn begin() {
    // libFuzzer's own hook ends the program at each panic, even one of a decoder that we catch. One that nobody catches
    // ends it all the same.
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    if let Some(folder) = std::env::var_os("FUZZ_SEEDS").map(PathBuf::from) {
        for reader in all() {
            let folder = folder.join(&reader.name);
            fs::create_dir_all(&folder).unwrap();
            let numbered = reader.whole.iter().enumerate();
            numbered.for_each(|(n, whole)| fs::write(folder.join(format!("seed-{n}")), whole).unwrap());
            println!("{}", reader.name);
        }
        std::process::exit(0);
    }
    let name = std::env::var("FUZZ_READER").unwrap_or_default();
    let Some(reader) = all().into_iter().find(|reader| reader.name == name) else {
        eprintln!("FUZZ_READER={name}: no such reader; FUZZ_SEEDS=folder lists them");
        std::process::exit(2);
    };
    ASKED.with(|asked| drop(asked.set(reader)));
}

libfuzzer_sys::fuzz_target!(init: begin(), |data: &[u8]| {
    ASKED.with(|asked| drop((asked.get().unwrap().read)(data)));
});
