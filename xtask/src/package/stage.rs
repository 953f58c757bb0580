//! The folder that every package is made of: the program and all that comes with it, as they lie below `/usr`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use super::crates::{self, Crate};
use super::{Package, printed};
use crate::run;

/// Files of the repository that go along, and where to.
const FILES: [(&str, &str); 6] = [
    ("app/package/plenoscope.desktop", "share/applications/plenoscope.desktop"),
    ("app/package/org.plenoscope.Plenoscope.metainfo.xml", "share/metainfo/org.plenoscope.Plenoscope.metainfo.xml"),
    ("LICENSE-MIT", "share/doc/plenoscope/LICENSE-MIT"),
    ("LICENSE-APACHE", "share/doc/plenoscope/LICENSE-APACHE"),
    ("README.md", "share/doc/plenoscope/README.md"),
    ("src/ui/fonts/OFL.txt", "share/doc/plenoscope/fonts-OFL.txt"),
];

/// Completions: the shell, and where it looks for them.
const COMPLETIONS: [(&str, &str); 3] = [
    ("bash", "share/bash-completion/completions/plenoscope"),
    ("zsh", "share/zsh/vendor-completions/_plenoscope"),
    ("fish", "share/fish/vendor_completions.d/plenoscope.fish"),
];

/// The folder.
pub(super) struct Stage {
    /// What becomes `/usr`.
    pub(super) usr: PathBuf,
}

impl Stage {
    /// Fills the folder; what the program can print it is asked for.
    pub(super) fn make(package: &Package, crates: &[Crate]) -> Result<Self> {
        let stage = Self { usr: package.out.join("stage/usr") };
        let program = package.program.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let program = stage.put(&format!("bin/{program}"), &fs::read(&package.program)?)?;
        make_executable(&program)?;
        if cfg!(unix) {
            // Names of functions and lines are for who builds it.
            run(Command::new("strip").arg(&program))?;
        }
        for (from, to) in FILES {
            let from = package.root.join(from);
            stage.put(to, &fs::read(&from).with_context(|| format!("cannot read {}", from.display()))?)?;
        }
        for (shell, to) in COMPLETIONS {
            stage.put(to, &printed(Command::new(&program).args(["completions", shell]))?)?;
        }
        run(Command::new(&program).args(["man", "-o"]).arg(stage.usr.join("share/man/man1")))?;
        run(Command::new(&program).args(["icons", "-o"]).arg(stage.usr.join("share/icons/hicolor")))?;
        stage.put("share/doc/plenoscope/licences-of-crates.txt", &crates::licences(&package.root, crates)?)?;
        Ok(stage)
    }

    /// Writes a file of the folder.
    pub(super) fn put(&self, to: &str, bytes: &[u8]) -> Result<PathBuf> {
        let path = self.usr.join(to);
        fs::create_dir_all(path.parent().unwrap_or(&self.usr))?;
        fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }
}

#[cfg(unix)]
fn make_executable(file: &Path) -> Result<()> {
    Ok(fs::set_permissions(file, std::os::unix::fs::PermissionsExt::from_mode(0o755))?)
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> Result<()> {
    Ok(())
}
