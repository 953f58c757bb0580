//! That the compiled half is a module an interpreter can load. With a test beside it, cargo builds it for `cargo test`,
//! and `cargo xtask python` takes it from there.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::Path;

#[test]
fn the_library_names_its_module() {
    let program = std::env::current_exe().unwrap();
    let name = format!("{DLL_PREFIX}plenoscope_python{DLL_SUFFIX}");
    let library = program.parent().unwrap_or(Path::new(".")).join(name);
    let bytes = std::fs::read(&library).unwrap();
    let entry = b"PyInit__native";
    assert!(bytes.windows(entry.len()).any(|window| window == entry), "{} is no module", library.display());
}
