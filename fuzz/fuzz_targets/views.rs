//! The index of a folder of views.
#![no_main]

use std::fs;

use plenoscope::job::{Cancel, Job};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(folder) = tempfile::tempdir() else { return };
    for name in ["view_0_0.ppm", "view_0_1.ppm", "view_1_0.ppm", "view_1_1.ppm"] {
        let _either = fs::write(folder.path().join(name), b"P6\n1 1\n255\nabc");
    }
    let _either = fs::write(folder.path().join("lightfield.json"), data);
    let _either = plenoscope::io::open(folder.path(), &Job { cancel: &Cancel::default(), sink: &() });
});
