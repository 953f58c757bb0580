//! `completions` and `man`, made from the same description that parses the arguments; `icons`.

use std::path::Path;

use anyhow::{Result, anyhow};
use clap::CommandFactory;
use clap_complete::Shell;
use plenoscope::ui::icon;

use crate::cli::Cli;
use crate::output::write_out;

/// Prints a shell's completions.
pub fn completions(shell: Shell) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "plenoscope", &mut text);
    write_out(&text)
}

/// Prints the man page, or writes one for each command into a folder.
pub fn man(folder: Option<&Path>) -> Result<()> {
    if let Some(folder) = folder {
        return std::fs::create_dir_all(folder)
            .and_then(|()| clap_mangen::generate_to(Cli::command(), folder))
            .map_err(|error| {
                anyhow!("the man pages cannot be written — {error} — choose another folder: {}", folder.display())
            });
    }
    let mut text = Vec::new();
    clap_mangen::Man::new(Cli::command()).render(&mut text)?;
    write_out(&text)
}

/// Writes the icon in all sizes, for packages.
pub fn icons(folder: &Path) -> Result<()> {
    let put = |file: &str, bytes: Vec<u8>| {
        let path = folder.join(file);
        let written =
            std::fs::create_dir_all(path.parent().unwrap_or(folder)).and_then(|()| std::fs::write(&path, bytes));
        written.map_err(|error| {
            anyhow!("the icon cannot be written — {error} — choose another folder: {}", path.display())
        })
    };
    for side in icon::SIDES {
        put(&format!("{side}x{side}/apps/plenoscope.png"), icon::png(side)?)?;
    }
    if cfg!(windows) {
        put("plenoscope.ico", icon::ico()?)?;
    }
    put("scalable/apps/plenoscope.svg", icon::svg().into_bytes())
}
