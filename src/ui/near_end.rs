//! A depth map of one's own does not say which end is near: it is read both ways.

use std::path::Path;
use std::sync::Arc;

use egui::{Color32, ColorImage, Context, TextureHandle};

use crate::field::{DisparityMap, FieldError};
use crate::io::formats::depth_map::{DepthMap, GivenDepth, NearEnd};
use crate::render::cpu::Colormap;

/// Long side of the small pictures, in pixels.
pub const PREVIEW: u32 = 320;
/// Shapes that differ by less than this are one shape: maps are cut to even sizes.
const SAME_SHAPE: f32 = 0.02;

/// A map read both ways.
#[derive(Clone, Debug)]
pub struct Reading {
    /// Which end is near.
    pub end: NearEnd,
    /// What it says then.
    pub depth: GivenDepth,
    /// A small picture of it, near is yellow.
    image: Arc<ColorImage>,
}

/// Both readings of a map, the likelier first. For a thread: the map may be large.
///
/// # Errors
/// Disparities that are no numbers.
pub fn readings(map: &DepthMap) -> Result<[Reading; 2], FieldError> {
    let image = |depth: &GivenDepth| Arc::new(small(&depth.disparity()));
    Ok(map.previews()?.map(|(end, depth)| Reading { end, image: image(&depth), depth }))
}

/// A small picture of a map, near is yellow.
pub fn small(map: &DisparityMap) -> ColorImage {
    let [w, h] = map.size();
    let step = w.max(h).div_ceil(PREVIEW).max(1);
    let [far, near] = map.range_px();
    let scale = 1.0 / (near - far).max(1e-6);
    let color = |x: u32, y: u32| {
        let [r, g, b] = Colormap::Viridis.srgb((map.at(x, y) - far) * scale).map(|v| (v * 255.0) as u8);
        Color32::from_rgb(r, g, b)
    };
    let pixels = (0..h).step_by(step as usize).flat_map(|y| (0..w).step_by(step as usize).map(move |x| color(x, y)));
    ColorImage::new([w.div_ceil(step), h.div_ceil(step)].map(|side| side as usize), pixels.collect())
}

/// The question, while it is asked.
pub struct Question {
    /// The map's file.
    pub name: String,
    /// The likelier reading first.
    pub readings: [Reading; 2],
    /// Small pictures of both.
    pub textures: [TextureHandle; 2],
    size: [u32; 2],
}

impl Question {
    /// About the map of a file.
    pub fn new(path: &Path, size: [u32; 2], readings: [Reading; 2], ctx: &Context) -> Self {
        let texture = |reading: &Reading| ctx.load_texture("near_end", Arc::clone(&reading.image), Default::default());
        let textures = [texture(&readings[0]), texture(&readings[1])];
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Self { name, readings, textures, size }
    }

    /// Whether the map has the shape of a photo.
    pub fn fits(&self, photo: [u32; 2]) -> bool {
        let shape = |[w, h]: [u32; 2]| w as f32 / h as f32;
        self.size == [1, 1] || (shape(self.size) / shape(photo) - 1.0).abs() < SAME_SHAPE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Raster;

    #[test]
    fn both_readings_are_offered_and_differ() {
        let values = (0..12 * 8).map(|i| (i / 12) as f32 / 7.0).collect();
        let map = DepthMap { values: Raster::new([12, 8], values).unwrap(), is_disparity: false };
        let [likely, other] = readings(&map).unwrap();
        assert_eq!((likely.end, other.end), (NearEnd::White, NearEnd::Black));
        assert!(likely.depth.disparity().at(0, 7) > likely.depth.disparity().at(0, 0), "below is near");
        assert!(other.depth.disparity().at(0, 7) < other.depth.disparity().at(0, 0));
        assert_eq!(likely.image.pixels[0], other.image.pixels[12 * 7], "far here is near there");
    }
}
