//! Embeds the models that `models/models.toml` names: writes a table of their files for `synth::library`.
//!
//! A checkout without models compiles too; the program then says that it has none.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=models");
    let models = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("models");
    let mut files = Vec::new();
    if let Ok(index) = fs::read_to_string(models.join("models.toml")) {
        files.push("models.toml".to_owned());
        for id in quoted(&index).filter(|id| models.join(id).join("manifest.toml").is_file()) {
            files.extend(in_folder(&models, id));
        }
    }
    files.dedup();
    let mut table = String::from("&[\n");
    for file in &files {
        let path = models.join(file);
        let _ = writeln!(table, "    ({file:?}, include_bytes!({path:?})),");
    }
    table.push_str("]\n");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("embedded_models.rs");
    if let Err(error) = fs::write(&out, table) {
        println!("cargo::error=cannot write {}: {error}", out.display());
    }
}

/// The texts between double quotes, comments left out.
fn quoted(toml: &str) -> impl Iterator<Item = &str> {
    toml.lines()
        .map(|line| line.split('#').next().unwrap_or_default())
        .flat_map(|line| line.split('"').skip(1).step_by(2))
}

/// The manifest and ONNX files of one model, relative to the models folder.
fn in_folder(models: &Path, id: &str) -> Vec<String> {
    let entries = fs::read_dir(models.join(id)).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.retain(|name| name == "manifest.toml" || name.ends_with(".onnx"));
    names.sort();
    names.iter().map(|name| format!("{id}/{name}")).collect()
}
