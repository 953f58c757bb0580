//! Tools of cargo that are not in this workspace, one version each, kept in `target/tools`.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use super::Package;
use crate::run;

/// Path of a tool; installed from the registry at the first call.
pub(super) fn installed(package: &Package, name: &str, version: &str) -> Result<PathBuf> {
    let folder = package.root.join("target/tools").join(format!("{name}-{version}"));
    let tool = folder.join("bin").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    if !tool.exists() {
        eprintln!("xtask: installing {name} {version}");
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["install", name, "--version", version, "--locked", "--root"]).arg(&folder);
        run(&mut cargo).with_context(|| format!("{name} is needed — is the registry reachable?"))?;
    }
    Ok(tool)
}
