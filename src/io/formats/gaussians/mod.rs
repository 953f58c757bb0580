//! Gaussian splats: PLY in the layout of Kerbl et al. 2023, as most programs write it, with the camera that Apple's SHARP
//! adds, or that our own files name in a comment. Text and binary, little-endian.
//!
//! A Gaussian has `x y z`, `f_dc_0 … 2` and perhaps `f_rest_0 … 44` (spherical harmonics, channel after channel), `opacity`
//! (logit), `scale_0 … 2` (logarithm) and `rot_0 … 3` (quaternion, w first). What else there is, is passed over.
//! And SPZ, the same in few bytes (`spz.rs`).

mod header;
mod read;
mod spz;
#[cfg(test)]
mod tests;
mod write;

use std::sync::Arc;

use crate::io::file_type::FileType;
use crate::io::raster::{Raster, Samples};
use crate::io::{FileKind, PhotoFile, Problem};
use crate::job::Job;
use crate::splats::{NamedCamera, Pictured, Rig, Stage};

pub use write::write;

/// How such a file is told, and opened: as the picture that its camera sees, with all that is needed for others.
pub(crate) const TYPE: FileType = FileType { name: NAME, begins, photo: Some(open), ..FileType::UNKNOWN };

/// The same of packed ones.
pub(crate) const SPZ: FileType =
    FileType { name: spz::NAME, begins: spz::begins, photo: Some(open_packed), ..FileType::UNKNOWN };

const NAME: &str = "PLY";
/// What `info` says of it.
const FORMAT: &str = "Gaussian splats (PLY)";
/// How our own files name their camera: focal length in pixels, width, height, view step, inverse distance of disparity 0.
const CAMERA: &str = "plenoscope camera";

fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

fn open(bytes: &[u8], job: &Job) -> Result<PhotoFile, Problem> {
    pictured(read::read(bytes)?, FORMAT, job)
}

fn open_packed(bytes: &[u8], job: &Job) -> Result<PhotoFile, Problem> {
    pictured(spz::read(bytes)?, spz::FORMAT, job)
}

/// The picture of what was read, which knows its scene. One can take seconds to draw, so it looks whether it is still wanted.
fn pictured(read: read::Read, format: &'static str, job: &Job) -> Result<PhotoFile, Problem> {
    let count = read.cloud.gaussians.len();
    let mut stage = Stage::new(read.cloud, read.camera, job)?;
    stage.in_metres = read.in_metres;
    if let Some([step, zero]) = read.steps {
        stage.rig = Rig { step, zero, ..stage.rig };
    }
    let (rgba, map) = stage.photo(job)?;
    let mut file = PhotoFile::from_raster(picture(stage.size(), rgba), format)?;
    let found = match stage.named {
        NamedCamera::File => "from the file",
        NamedCamera::Found => "none in the file: a view was looked for",
    };
    file.info.kind = FileKind::Splats;
    file.info.disparity_px = Some(map.range_px());
    file.info.notes.push(("Gaussians".to_owned(), count.to_string()));
    file.info.notes.push(("camera".to_owned(), found.to_owned()));
    read.warnings.into_iter().for_each(|text| file.warn(text));
    file.splats = Some(Arc::new(Pictured { stage, map: Arc::new(map) }));
    Ok(file)
}

/// A picture without anything beside it.
fn picture(size: [u32; 2], rgba: Vec<u8>) -> Raster {
    let samples = Samples::Eight(rgba.as_chunks().0.to_vec());
    let (icc, exif, xmp) = (None, None, None);
    Raster { size, samples, has_alpha: false, icc, exif, xmp, orientation: 1, warnings: Vec::new() }
}
