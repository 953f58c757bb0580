//! Anything that may be a photo, told by content: JPEG with phone depth, HEIC, AVIF, LFP, PNG, TIFF, WebP, BMP, GIF, PNM. A
//! corpus of one format fuzzes that format's parser: `cargo +nightly fuzz run photo corpus/heic`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _either = plenoscope::io::open_bytes(data, None);
});
