//! Real light fields, decoded once, and the ray depth that a sweep over their views finds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use plenoscope::field::{LightField, View, ViewGrid};
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::sweep;
use rayon::prelude::*;

use super::SceneError;
use super::library::{read_rgb, to_u8};
use super::raster::Raster;

/// Light fields that the trainer never sees: they are what it is judged by.
pub const VALIDATION_LIGHT_FIELDS: [&str; 2] = ["yellow_f01", "shrubs_f01"];

/// One real light field.
pub struct Field {
    /// Its folder's name.
    pub name: String,
    /// 64 views in `[v, u]` order.
    pub views: Vec<Raster<[u8; 3]>>,
    /// Ray depth of the reference view, pixels per view step at the size of the views.
    pub disparity: Raster<f32>,
}

/// The training light fields of a data folder, as large as crops of `long_side` need.
pub fn read(data: &Path, long_side: usize) -> Result<Vec<Field>, SceneError> {
    let Ok(entries) = std::fs::read_dir(data.join("lightfields")) else { return Ok(Vec::new()) };
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    paths.sort();
    paths.retain(|path| !VALIDATION_LIGHT_FIELDS.contains(&name(path).as_str()));
    paths.retain(|path| path.join("view_4_4.png").exists());
    paths.iter().map(|path| read_field(path, long_side)).collect()
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn read_field(folder: &Path, long_side: usize) -> Result<Field, SceneError> {
    let views = read_views(folder)?;
    let full = views[0].size;
    // Each view a little larger than a crop, and never enlarged.
    let scale = (1.15 * long_side as f32 / full[0].max(full[1]) as f32).min(1.0);
    let size = full.map(|side| (side as f32 * scale).round() as usize);
    let disparity = swept(folder, &views)?.resized(size);
    let to_px = size[0] as f32 / full[0] as f32;
    Ok(Field {
        name: name(folder),
        views: views.par_iter().map(|view| to_u8(&view.map(|texel| texel.map(f32::from)).resized(size))).collect(),
        disparity: disparity.map(|d| d[0] * to_px),
    })
}

/// All 64 views of a folder in `[v, u]` order.
fn read_views(folder: &Path) -> Result<Vec<Raster<[u8; 3]>>, SceneError> {
    let grid = ViewGrid::PAPER;
    let path = |v: u8, u: u8| -> PathBuf { folder.join(format!("view_{v}_{u}.png")) };
    let reference = read_rgb("view", &path(4, 4))?.size;
    let read = |layer: usize| {
        let at = grid.view_from_layer(layer);
        let path = path(at.v, at.u);
        let view = read_rgb("view", &path)?;
        if view.size != reference {
            let beside = "view_4_4.png";
            return Err(SceneError::Size { what: "view", got: view.size, want: reference, beside, path });
        }
        Ok(to_u8(&view))
    };
    (0..grid.count()).into_par_iter().map(read).collect()
}

/// The viewer's own plane sweep over all views.
fn swept(folder: &Path, views: &[Raster<[u8; 3]>]) -> Result<Raster<[f32; 1]>, SceneError> {
    let wrong =
        |reason: &dyn std::fmt::Display| SceneError::read("light field", folder, reason, "64 views of one size");
    let size = views[0].size;
    let view = |raster: &Raster<[u8; 3]>| {
        let rgba = raster.px.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        View::new(size.map(|side| side as u32), rgba).map(Arc::new)
    };
    let views = views.iter().map(view).collect::<Result<_, _>>().map_err(|e| wrong(&e))?;
    let field = LightField::new(ViewGrid::PAPER, views).map_err(|e| wrong(&e))?;
    let cancel = Cancel::default();
    let map = sweep::reference_map(&field, &Job { cancel: &cancel, sink: &() }).map_err(|e| wrong(&e))?;
    Ok(Raster { size, px: map.disparity_px.into_iter().map(|d| [d]).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_fields_ray_depth_is_measured() {
        let data = tempfile::tempdir().unwrap();
        let folder = data.path().join("lightfields/slanted");
        std::fs::create_dir_all(&folder).unwrap();
        // A pattern in the plane of 0.5 px per view step: view(v, u)[x] = reference[x + (u − 4)·0.5].
        let pattern = |x: f32, y: f32| 128.0 + 60.0 * (x * 0.55).sin() + 60.0 * (y * 0.45 + 0.2 * x).cos();
        for (v, u) in (0..8).flat_map(|v| (0..8).map(move |u| (v, u))) {
            let [du, dv] = [u, v].map(|i| 0.5 * (i as f32 - 4.0));
            let view = image::GrayImage::from_fn(96, 72, |x, y| [pattern(x as f32 + du, y as f32 + dv) as u8].into());
            view.save(folder.join(format!("view_{v}_{u}.png"))).unwrap();
        }
        let [field] = &read(data.path(), 48).unwrap()[..] else { panic!("one light field") };
        // Views of 1.15 times the working scale, and disparities in their pixels.
        assert_eq!((field.views[0].size, field.disparity.size), ([55, 41], [55, 41]));
        let expected = 0.5 * 55.0 / 96.0;
        let far = |d: &&f32| (*d - expected).abs() > 0.05;
        assert!(field.disparity.px.iter().filter(far).count() < field.disparity.px.len() / 20);
    }
}
