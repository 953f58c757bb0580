//! ONNX Runtime in tests: one environment a process.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![allow(clippy::explicit_write, reason = "the test harness keeps what eprintln! says to itself")]

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::OnceLock;

use ort::environment::Environment;

/// ONNX Runtime, where its library is; where it is not the test is skipped and says so.
pub fn runtime() -> Option<&'static Environment> {
    static RUNTIME: OnceLock<Option<Environment>> = OnceLock::new();
    let runtime = RUNTIME.get_or_init(|| {
        let library = std::env::var_os("ORT_DYLIB_PATH").map(PathBuf::from).filter(|path| path.is_file());
        let hint = "ORT_DYLIB_PATH names no ONNX Runtime library; `cargo xtask test` fetches it";
        let Some(library) = library else {
            assert!(std::env::var_os("CI").is_none(), "{hint}");
            writeln!(std::io::stderr(), "\nSKIPPED, tract was not compared with ONNX Runtime: {hint}\n").unwrap();
            return None;
        };
        Some(ort::init_from(library).unwrap().build().unwrap())
    });
    runtime.as_ref()
}
