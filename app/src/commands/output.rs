//! Where a command writes to, and what it must not write over.

use std::path::Path;

use anyhow::{Result, bail};
use plenoscope::field::{Photo, Picture};
use plenoscope::io::save::{self, Origin, PictureOptions};
use plenoscope::scene::export::Kind;

/// A file to write, and the input that must stay as it is unless `--force` says otherwise.
pub struct Output<'a> {
    pub file: &'a Path,
    pub input: &'a Path,
    pub force: bool,
}

impl Output<'_> {
    /// Refuses what would write over the input, before any work is done.
    pub fn check(&self) -> Result<()> {
        if !self.force && self.hits_input() {
            bail!(
                "the output is the input — it would be lost — choose another name or add --force: {}",
                self.file.display()
            );
        }
        if self.file.is_dir() {
            bail!("the output is a folder — a file is written — name a file in it: {}", self.file.display());
        }
        Ok(())
    }

    /// The same for what is written of a kind: of several files only the folder itself must not be the input.
    pub fn check_written(&self, kind: Kind) -> Result<()> {
        if !kind.is_folder() {
            return self.check();
        }
        if !self.force && save::same_file(self.file, self.input) {
            bail!("the output is the input — it would be lost — choose another name: {}", self.file.display());
        }
        Ok(())
    }

    /// Whether the file is the input, or lies in a folder that is the input.
    fn hits_input(&self) -> bool {
        let folder = self
            .file
            .parent()
            .map_or(Path::new("."), |dir| if dir.as_os_str().is_empty() { Path::new(".") } else { dir });
        save::same_file(self.file, self.input)
            || (self.file.exists() && self.input.is_dir() && save::same_file(folder, self.input))
    }

    /// Writes a picture of sRGB light; the name's ending says the format. A photo's metadata goes along.
    pub fn picture(&self, picture: &Picture, photo: Option<&Photo>, bits: u8) -> Result<()> {
        let mut origin = photo.map(Origin::in_srgb).unwrap_or_default();
        origin.source = Some(self.input.to_owned());
        let options = PictureOptions { bits, origin, replace_source: self.force, ..PictureOptions::default() };
        Ok(save::picture(self.file, picture, &options)?)
    }
}

/// The ending of a file's name, in small letters.
pub fn ending(file: &Path) -> String {
    file.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}
