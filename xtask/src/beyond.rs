//! What goes beyond one machine and one system: a job array on Slurm, and the package in bare Debian systems.

use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::{package, run, system};

/// Suites of Debian that the `.deb` is installed into.
const SUITES: [&str; 2] = ["bookworm", "trixie"];

/// All of it; an error if one thing failed, a line for each that is skipped.
pub fn all(root: &Path) -> Result<()> {
    let made = package::make(root)?;
    let slurm = slurm(root);
    let Some(deb) = made.iter().find(|file| file.extension().is_some_and(|ending| ending == "deb")) else {
        skipped("the .deb is installed nowhere: there is none on this system");
        return slurm;
    };
    let installed: Vec<Result<()>> = SUITES.iter().map(|suite| bare_debian(root, deb, suite)).collect();
    slurm?;
    installed.into_iter().collect()
}

/// `docs/scale/slurm.sh` on two nodes that are both this machine.
fn slurm(root: &Path) -> Result<()> {
    if !system::brings(&["slurm-wlm", "munge"], &["slurmctld", "slurmd", "munged"])? {
        skipped("no job array runs on Slurm: it needs root and Debian's slurm-wlm and munge");
        return Ok(());
    }
    let program = root.join("target/packages/stage/usr/bin/plenoscope");
    run(Command::new(root.join("docs/scale/try-slurm.sh")).arg(program))
}

/// The package in a system that has nothing but itself.
fn bare_debian(root: &Path, deb: &Path, suite: &str) -> Result<()> {
    if !system::brings(&["debootstrap"], &["debootstrap"])? {
        skipped("the .deb is installed nowhere: that needs root and debootstrap");
        return Ok(());
    }
    run(Command::new(root.join("scripts/try-deb.sh")).arg(deb).arg(suite))
}

fn skipped(what: &str) {
    eprintln!("\nxtask: SKIPPED: {what}\n");
}
