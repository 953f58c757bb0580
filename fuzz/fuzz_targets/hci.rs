//! The `parameters.cfg` of a benchmark folder.
#![no_main]

use std::fs;

use plenoscope::job::{Cancel, Job};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(folder) = tempfile::tempdir() else { return };
    for view in 0..4 {
        let _either = fs::write(folder.path().join(format!("input_Cam00{view}.ppm")), b"P6\n1 1\n255\nabc");
    }
    let _either = fs::write(folder.path().join("parameters.cfg"), data);
    let _either = plenoscope::io::open(folder.path(), &Job { cancel: &Cancel::default(), sink: &() });
});
