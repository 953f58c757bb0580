//! A cloud as a file that the usual viewers open.

use std::io::Write;
use std::path::Path;

use super::CAMERA;
use crate::io::exif;
use crate::io::formats::out::{self, FieldToWrite};
use crate::io::save::SaveError;
use crate::job::Job;
use crate::splats::{SplatError, Stage, from_field};

/// Writes one Gaussian for each point that the light field's rays end at, merged over its views. The camera stands in a
/// comment, as further elements confuse some viewers.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, source: &FieldToWrite, job: &Job) -> Result<(), SaveError> {
    let depths = source.need_depths(path)?;
    let f35_mm = source.photo.and_then(|photo| exif::f35_mm(photo.metadata().exif.as_deref()?));
    let stage = from_field(source.field, depths, f35_mm.map(|mm| mm / FILM_MM), job).map_err(|error| match error {
        SplatError::Cancelled(_) => SaveError::Cancelled,
        SplatError::Field(error) => SaveError::Encode { why: error.to_string(), path: path.to_owned() },
    })?;
    out::single(path, |out| put(out, &stage))
}

/// Width of a frame of 35-mm film.
const FILM_MM: f32 = 36.0;

/// Normals are written as zeros, as all do: some viewers count on them.
const PROPERTIES: [&str; 17] = [
    "x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
    "rot_1", "rot_2", "rot_3",
];

pub(super) fn put(out: &mut impl Write, stage: &Stage) -> std::io::Result<()> {
    let (cloud, rig) = (&stage.cloud, &stage.rig);
    let [w, h] = rig.camera.size;
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment made by Plenoscope")?;
    writeln!(out, "comment {CAMERA} {} {w} {h} {} {}", rig.camera.focal_px.x, rig.step, rig.zero)?;
    writeln!(out, "element vertex {}", cloud.gaussians.len())?;
    for name in PROPERTIES {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "end_header")?;
    for (number, gaussian) in cloud.gaussians.iter().enumerate() {
        let center = gaussian.center.to_array();
        let scale = gaussian.scale.map(|scale| scale.max(1e-30).ln()).to_array();
        let [x, y, z, w] = gaussian.rotation.to_array();
        let opacity = gaussian.opacity.clamp(1e-6, 1.0 - 1e-6);
        let logit = (opacity / (1.0 - opacity)).ln();
        let values = center.into_iter().chain([0.0; 3]).chain(cloud.coefficients(number)[0]);
        for value in values.chain([logit]).chain(scale).chain([w, x, y, z]) {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    Ok(())
}
