//! `cargo xtask package`: what people install, for the system that it runs on.
//!
//! Linux: `.deb`, AppImage and `tar.gz`, all of one folder that looks like `/usr` ([`stage`]). Elsewhere cargo-packager
//! makes the installer. Beside them lie an SBOM, the licences of all crates, and checksums.

mod crates;
#[cfg(target_os = "linux")]
mod linux;
mod stage;
#[cfg(not(target_os = "linux"))]
mod tools;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use sha2::{Digest, Sha256};

use crate::run;
use stage::Stage;

/// What is packaged, and where.
pub struct Package {
    root: PathBuf,
    version: String,
    /// Where the packages go.
    out: PathBuf,
    /// The program as cargo built it.
    program: PathBuf,
}

/// Builds the program and makes all packages; gives their paths.
pub fn make(root: &Path) -> Result<Vec<PathBuf>> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let name = format!("plenoscope{}", std::env::consts::EXE_SUFFIX);
    let package = Package {
        root: root.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        out: target.join("packages"),
        program: target.join("release").join(name),
    };
    let build = ["build", "--release", "--locked", "--package", "plenoscope-app"];
    run(Command::new(env!("CARGO")).current_dir(root).args(build))?;
    if package.out.exists() {
        fs::remove_dir_all(&package.out).with_context(|| format!("cannot empty {}", package.out.display()))?;
    }
    let crates = crates::of_program(&package)?;
    let stage = Stage::make(&package, &crates)?;
    let mut made = installers(&package, &stage)?;
    let sbom = package.out.join(format!("plenoscope-{}.cdx.json", package.version));
    fs::write(&sbom, crates::sbom(&package, &crates))?;
    made.push(sbom);
    checksums(&made, &package.out)?;
    Ok(made)
}

#[cfg(target_os = "linux")]
fn installers(package: &Package, stage: &Stage) -> Result<Vec<PathBuf>> {
    linux::make(package, stage)
}

/// The installers of macOS and Windows, as `[package.metadata.packager]` of `app/Cargo.toml` describes them.
#[cfg(not(target_os = "linux"))]
fn installers(package: &Package, _: &Stage) -> Result<Vec<PathBuf>> {
    let formats: &[&str] = match std::env::consts::OS {
        "macos" => &["dmg"],
        "windows" => &["nsis", "wix"],
        other => bail!("there is no package for {other} — the program itself is {}", package.program.display()),
    };
    let packager = tools::installed(package, "cargo-packager", "0.11.8")?;
    let before = listed(&package.out)?;
    let mut command = Command::new(packager);
    command.current_dir(&package.root).args(["packager", "--release", "--packages", "plenoscope-app"]);
    run(command.args(["--formats", &formats.join(",")]).arg("--out-dir").arg(&package.out))?;
    Ok(listed(&package.out)?.into_iter().filter(|file| !before.contains(file)).collect())
}

#[cfg(not(target_os = "linux"))]
fn listed(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.collect::<std::io::Result<Vec<_>>>()?;
    Ok(entries.into_iter().map(|entry| entry.path()).filter(|path| path.is_file()).collect())
}

/// `SHA256SUMS` as `sha256sum --check` reads it.
fn checksums(files: &[PathBuf], out: &Path) -> Result<()> {
    let mut text = String::new();
    for file in files {
        let bytes = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
        let hex: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        writeln!(text, "{hex}  {name}")?;
    }
    Ok(fs::write(out.join("SHA256SUMS"), text)?)
}

/// What a command prints.
fn printed(command: &mut Command) -> Result<Vec<u8>> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().with_context(|| format!("cannot start {name}"))?;
    if !output.status.success() {
        bail!("{name} failed ({}): {}", output.status, String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(output.stdout)
}
