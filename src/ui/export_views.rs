//! Views and ray depths as a folder: `view_V_U.png` and `depth_V_U.pfm`, written aside and renamed as a whole.

use std::path::Path;

use crate::field::{LightField, RayDepths};
use crate::io::formats::pfm;
use crate::job::{Job, Stage};

/// Writes the folder; nothing half-written stays when it fails or is stopped.
pub fn write(target: &Path, field: &LightField, depths: Option<&RayDepths>, job: &Job) -> Result<(), String> {
    let parent = target.parent().unwrap_or(Path::new("."));
    if target.exists() {
        return Err(format!(
            "could not write the views — the folder exists — choose another name: {}",
            target.display()
        ));
    }
    let could_not = |error: &dyn std::error::Error| {
        format!("could not write the views — {error} — choose another folder: {}", parent.display())
    };
    let aside =
        tempfile::Builder::new().prefix(".plenoscope-").tempdir_in(parent).map_err(|error| could_not(&error))?;
    let total = field.grid().count() as u32;
    for (done, at) in (0..).zip(field.grid().views()) {
        let view = field.view(at);
        let [w, h] = view.size();
        let rgb: Vec<u8> = view.rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let path = aside.path().join(format!("view_{}_{}.png", at.v, at.u));
        image::save_buffer(&path, &rgb, w, h, image::ExtendedColorType::Rgb8).map_err(|error| could_not(&error))?;
        if let Some(depths) = depths {
            let path = aside.path().join(format!("depth_{}_{}.pfm", at.v, at.u));
            let mut file = std::io::BufWriter::new(std::fs::File::create(&path).map_err(|error| could_not(&error))?);
            pfm::write_pfm(&mut file, depths.size(), depths.view(at)).map_err(|error| could_not(&error))?;
            std::io::Write::flush(&mut file).map_err(|error| could_not(&error))?;
        }
        job.advance(Stage::Save, done + 1, total).map_err(|stopped| stopped.to_string())?;
    }
    std::fs::rename(aside.path(), target).map_err(|error| could_not(&error))?;
    // The folder has moved: there is nothing left to clean up.
    let _ = aside.keep();
    Ok(())
}
