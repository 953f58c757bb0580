//! Quilts: the layout stands in the name.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _either = plenoscope::io::open_bytes(data, Some(Path::new("q_qs4x2a1.5.png")));
});
