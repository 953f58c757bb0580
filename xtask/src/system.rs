//! What the tests need from the system: a software Vulkan, a virtual display, keyboard tables.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, bail};

use crate::run;

/// A Debian package and a way to see whether what it brings is there.
struct Needed {
    package: &'static str,
    there: fn() -> bool,
}

const NEEDED: [Needed; 4] = [
    Needed { package: "mesa-vulkan-drivers", there: || any_in("/usr/share/vulkan/icd.d", "lvp_icd") },
    Needed { package: "libvulkan1", there: || has_library("libvulkan.so.1") },
    Needed { package: "libxkbcommon-x11-0", there: || has_library("libxkbcommon-x11.so.0") },
    Needed { package: "xvfb", there: || on_path("Xvfb") },
];

/// Checks that all is there; installs it where that needs nobody's password, else names the one command.
pub fn ensure() -> Result<()> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    let missing: Vec<&str> = NEEDED.iter().filter(|needed| !(needed.there)()).map(|needed| needed.package).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let by_hand = format!("sudo apt-get install -y --no-install-recommends {}", missing.join(" "));
    if !(on_path("apt-get") && is_root()) {
        return by_hand_only(&by_hand);
    }
    eprintln!("xtask: installing {}", missing.join(" "));
    run(Command::new("apt-get").args(["update", "-q"]))?;
    run(Command::new("apt-get").args(["install", "-yq", "--no-install-recommends"]).args(&missing))
}

/// Whether programs of further packages are there, installed first where that needs nobody's password.
pub fn brings(packages: &[&str], programs: &[&str]) -> Result<bool> {
    let all_there = || programs.iter().all(|program| on_path(program));
    if is_root() && !all_there() && on_path("apt-get") {
        run(Command::new("apt-get").args(["update", "-q"]))?;
        run(Command::new("apt-get").args(["install", "-yq", "--no-install-recommends"]).args(packages))?;
    }
    Ok(is_root() && all_there())
}

/// In CI a missing package is an error; elsewhere the tests that need it skip, and this says so first.
fn by_hand_only(command: &str) -> Result<()> {
    if std::env::var_os("CI").is_some() {
        bail!("the system lacks what the tests need — run: {command}");
    }
    eprintln!("\nxtask: SKIPPED will be what needs a GPU or a display — for all tests run: {command}\n");
    Ok(())
}

fn is_root() -> bool {
    Command::new("id").arg("-u").output().is_ok_and(|out| out.stdout.trim_ascii() == b"0")
}

/// Whether a program is on the path.
pub fn on_path(program: &str) -> bool {
    std::env::var_os("PATH").is_some_and(|path| std::env::split_paths(&path).any(|dir| dir.join(program).is_file()))
}

fn has_library(name: &str) -> bool {
    ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"]
        .iter()
        .any(|dir| Path::new(dir).join(name).exists())
}

fn any_in(dir: &str, prefix: &str) -> bool {
    std::fs::read_dir(dir)
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with(prefix)))
}
