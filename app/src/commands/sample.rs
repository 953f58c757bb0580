//! `sample`: the built-in photo and its disparity as files, to try the other commands on.

use anyhow::Result;
use plenoscope::io::formats::depth_out;
use plenoscope::io::sample::{Sample as Drawn, sample};
use plenoscope::io::save::{self, PictureOptions, Pixels, Samples, SaveError};
use plenoscope::job::{Job, Stage};

use crate::cli::Sample;

/// Draws and writes `sample.png` and `sample.pfm`.
pub fn run(args: &Sample, job: &Job) -> Result<()> {
    let folder = &args.output;
    std::fs::create_dir_all(folder).map_err(|error| SaveError::from_io(&error, folder))?;
    let Drawn { photo, disparity } = sample()?;
    let rgb = photo.srgb8().chunks_exact(4).flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]).collect();
    job.advance(Stage::Save, 0, 1)?;
    let picture = Pixels { size: photo.size(), samples: Samples::Eight(rgb) };
    save::pixels(&folder.join("sample.png"), &picture, &PictureOptions::default())?;
    Ok(depth_out::write_pfm(&folder.join("sample.pfm"), &disparity)?)
}
