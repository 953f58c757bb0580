//! Small depth nets of public architectures, exported by a Python of their own, for `cargo xtask test --all`.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::run;

/// The versions with which half precision of symbolic axes can be exported.
const PACKAGES: [&str; 7] = [
    "torch==2.4.1",
    "transformers==4.46.3",
    "onnx==1.16.2",
    "onnxruntime==1.19.2",
    "onnxconverter-common==1.14.0",
    "numpy<2",
    "packaging",
];

/// The folder of the nets; made at the first call, which fetches some gigabytes.
pub fn folder(root: &Path) -> Result<PathBuf> {
    let place = root.join("target/nets");
    let (python, nets) = (place.join("python"), place.join("exported"));
    if nets.join("done").exists() {
        return Ok(nets);
    }
    eprintln!("xtask: PyTorch is fetched, to export depth nets (some gigabytes)");
    run(Command::new("python3.11").args(["-m", "venv"]).arg(&python))
        .context("PyTorch 2.4 needs Python 3.11 — install python3.11 and python3.11-venv")?;
    let python = python.join("bin/python");
    run(Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(PACKAGES))?;
    run(Command::new(&python).arg(root.join("tests/foreign_nets/export.py")).arg(&nets))?;
    std::fs::write(nets.join("done"), "")?;
    Ok(nets)
}
