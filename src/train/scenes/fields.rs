//! Real light fields, decoded once, with the ray depth that their files hold or a sweep over their views finds (without
//! its grain: [`super::steady`]).

use std::path::Path;

use rayon::prelude::*;

use super::SceneError;
use super::library::to_u8;
use super::raster::{Raster, Rgb};
use super::steady::steadied;
use crate::field::TrueField;

/// Light fields that the trainer never sees: they are what it is judged by.
pub const VALIDATION_LIGHT_FIELDS: [&str; 2] = ["yellow_f01", "shrubs_f01"];

/// Endings of files that may hold all views of a light field.
const PICTURES: [&str; 6] = ["png", "jpg", "jpeg", "webp", "tif", "tiff"];

/// How near windows of light fields come: views are kept so many times as large as the working scale.
const NEAREST: f32 = 2.5;

/// One real light field.
pub struct Field {
    /// Its file's or folder's name.
    pub name: String,
    /// 64 views in `[v, u]` order.
    pub views: Vec<Raster<[u8; 3]>>,
    /// Ray depth of the reference view, pixels per view step at the size of the views.
    pub disparity: Raster<f32>,
}

/// The training light fields of a data folder, in any format that the viewer opens, as large as windows at
/// `long_side` need.
///
/// # Errors
/// What is no light field, or has too few views.
pub fn read(data: &Path, long_side: usize) -> Result<Vec<Field>, SceneError> {
    let Ok(entries) = std::fs::read_dir(data.join("lightfields")) else { return Ok(Vec::new()) };
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).filter(|path| is_wanted(path)).collect();
    paths.sort();
    paths.iter().map(|path| read_field(path, long_side)).collect()
}

/// Folders and pictures, but for those that the trainer is judged by and what is hidden.
fn is_wanted(path: &Path) -> bool {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let picture =
        || path.extension().is_some_and(|ending| PICTURES.iter().any(|known| ending.eq_ignore_ascii_case(known)));
    !VALIDATION_LIGHT_FIELDS.contains(&&*name) && !name.starts_with('.') && (path.is_dir() || picture())
}

fn read_field(path: &Path, long_side: usize) -> Result<Field, SceneError> {
    let field = TrueField::open(path)?;
    // Each view larger than a crop, and never enlarged.
    let scale = (NEAREST * long_side as f32 / field.size[0].max(field.size[1]) as f32).min(1.0);
    let size = field.size.map(|side| (side as f32 * scale).round() as usize);
    let to_px = size[0] as f32 / field.size[0] as f32;
    let disparity = field.reference_disparity()?.map(|&d| [d * to_px]).resized(size).map(|d| d[0]);
    let is_swept = field.own_reference_depth().is_none();
    let disparity = if is_swept { steadied(&disparity, field.reference().resized(size)) } else { disparity };
    let small = |view: &Rgb| to_u8(&view.map(|texel| texel.map(|c| 255.0 * c)).resized(size));
    Ok(Field { views: field.views.par_iter().map(small).collect(), disparity, name: field.name })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pattern in the plane of 0.5 px per view step: view(v, u)[x] = reference[x + (u − zero)·0.5].
    fn write_plane(folder: &Path, side: u8) {
        std::fs::create_dir_all(folder).unwrap();
        let pattern = |x: f32, y: f32| 128.0 + 60.0 * (x * 0.55).sin() + 60.0 * (y * 0.45 + 0.2 * x).cos();
        for (v, u) in (0..side).flat_map(|v| (0..side).map(move |u| (v, u))) {
            let [du, dv] = [u, v].map(|i| 0.5 * (f32::from(i) - f32::from(side / 2)));
            let view = image::GrayImage::from_fn(96, 72, |x, y| [pattern(x as f32 + du, y as f32 + dv) as u8].into());
            view.save(folder.join(format!("view_{v}_{u}.png"))).unwrap();
        }
    }

    #[test]
    fn a_light_fields_ray_depth_is_measured() {
        let data = tempfile::tempdir().unwrap();
        write_plane(&data.path().join("lightfields/slanted"), 8);
        let [field] = &read(data.path(), 32).unwrap()[..] else { panic!("one light field") };
        // Views of 2.5 times the working scale, and disparities in their pixels.
        assert_eq!((field.views[0].size, field.disparity.size), ([80, 60], [80, 60]));
        let expected = 0.5 * 80.0 / 96.0;
        let far = |d: &&f32| (*d - expected).abs() > 0.05;
        assert!(field.disparity.px.iter().filter(far).count() < field.disparity.px.len() / 20);
    }

    #[test]
    fn grids_of_other_sizes_are_read_and_what_is_judged_by_is_not() {
        let data = tempfile::tempdir().unwrap();
        let folder = data.path().join("lightfields");
        write_plane(&folder.join("nine"), 9);
        write_plane(&folder.join(VALIDATION_LIGHT_FIELDS[0]), 8);
        std::fs::write(folder.join("README.md"), "ours").unwrap();
        let fields = read(data.path(), 48).unwrap();
        assert_eq!(fields.iter().map(|field| (&*field.name, field.views.len())).collect::<Vec<_>>(), [("nine", 64)]);
        image::GrayImage::new(64, 48).save(folder.join("holiday.png")).unwrap();
        let error = read(data.path(), 48).err().unwrap().to_string();
        assert!(error.contains("one photo") && error.contains("holiday.png"), "{error}");
    }
}
