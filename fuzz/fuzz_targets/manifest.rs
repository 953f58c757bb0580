//! Manifests of models.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _either = plenoscope::synth::Manifest::parse(text, "manifest.toml");
});
