//! Fetches the ONNX Runtime library from the Python package index: one version, its checksum known, kept in `target/`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use sha2::{Digest, Sha256};

use crate::run;

/// The version that the engines are compared with.
pub const VERSION: &str = "1.31.1";

/// A wheel of that version: the platform's name in Python's words and the file's SHA-256.
struct Wheel {
    platform: &'static str,
    sha256: &'static str,
}

/// The wheel for this machine; its Python part is never used, so any Python's will do.
fn wheel() -> Result<Wheel> {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => Ok(Wheel {
            platform: "manylinux_2_28_x86_64",
            sha256: "5752bd508126ae7c49894d3b9d2e83f0c3d487319246d04c444b393308d7ad7f",
        }),
        ("linux", "aarch64") => Ok(Wheel {
            platform: "manylinux_2_28_aarch64",
            sha256: "da05378364c44d4407e463982d2bf8d5e4cfea873283757e48beeb41df97b7f3",
        }),
        (os, arch) => {
            bail!("no ONNX Runtime is pinned for {os} on {arch} — set ORT_DYLIB_PATH to a library of {VERSION}")
        }
    }
}

/// Path of the library: what `ORT_DYLIB_PATH` names, else the pinned one, fetched at the first call.
pub fn library(root: &Path) -> Result<PathBuf> {
    if let Some(path) = std::env::var_os("ORT_DYLIB_PATH") {
        return Ok(path.into());
    }
    let wheel = wheel()?;
    let folder = root.join("target/onnxruntime").join(VERSION);
    let library = folder.join(format!("onnxruntime/capi/libonnxruntime.so.{VERSION}"));
    let file = folder.join(format!("onnxruntime-{VERSION}-cp311-cp311-{}.whl", wheel.platform));
    if !file.exists() {
        download(&wheel, &folder)?;
    }
    let found = sha256(&file)?;
    if found != wheel.sha256 {
        fs::remove_file(&file).ok();
        bail!(
            "the fetched ONNX Runtime has the checksum {found}, not {} — try again: {}",
            wheel.sha256,
            file.display()
        );
    }
    if !library.exists() {
        run(Command::new("python3").args(["-m", "zipfile", "-e"]).arg(&file).arg(&folder))?;
    }
    Ok(library)
}

fn download(wheel: &Wheel, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    eprintln!("xtask: fetching ONNX Runtime {VERSION}");
    run(Command::new("python3")
        .args(["-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:", "--python-version", "3.11"])
        .args(["--platform", wheel.platform, &format!("onnxruntime=={VERSION}"), "--dest"])
        .arg(folder))
    .context("the Python package index did not give ONNX Runtime — is pip there, and the network?")
}

fn sha256(file: &Path) -> Result<String> {
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    Ok(Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect())
}
