//! Where a command writes to.

use std::path::Path;

use anyhow::Result;
use plenoscope::field::{Photo, Picture};
use plenoscope::io::save::{self, Origin, PictureOptions};
use plenoscope::scene::asked::Output;

/// A file to write, and the input that must stay as it is unless `--force` says otherwise.
pub fn output<'a>(file: &'a Path, input: &'a Path, force: bool) -> Output<'a> {
    Output { file, input: Some(input), force }
}

/// Writes a picture of sRGB light; the name's ending says the format. A photo's metadata goes along.
pub fn picture(output: &Output, picture: &Picture, photo: Option<&Photo>, bits: u8) -> Result<()> {
    let mut origin = photo.map(Origin::in_srgb).unwrap_or_default();
    origin.source = output.input.map(Path::to_owned);
    let options = PictureOptions { bits, origin, replace_source: output.force, ..PictureOptions::default() };
    Ok(save::picture(output.file, picture, &options)?)
}

/// The ending of a file's name, in small letters.
pub fn ending(file: &Path) -> String {
    file.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}
