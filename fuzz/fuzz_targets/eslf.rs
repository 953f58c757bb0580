//! Lenslet pictures.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _either = plenoscope::io::open_bytes(data, Some(Path::new("a_eslf.png")));
});
