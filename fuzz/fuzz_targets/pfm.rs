//! PFM maps.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _either = plenoscope::io::formats::pfm::parse_pfm(data);
});
