//! Contact sheets: small pictures in rows, for a person to look at.

use std::path::Path;

use plenoscope::io::save::{SaveError, atomic};

use super::Rgb;
use crate::scenes::raster::Raster;

/// Space between tiles, in pixels.
const GAP: usize = 4;

/// A depth map from blue (far) over green to red (near); grey where it is not a number.
pub fn depth_tile(disparity_px: &[f32], size: [usize; 2], range: [f32; 2]) -> Rgb {
    let colour = |d: &f32| {
        if d.is_finite() { turbo((d - range[0]) / (range[1] - range[0]).max(1e-6)) } else { [0.5; 3] }
    };
    Raster { size, px: disparity_px.iter().map(colour).collect() }
}

/// Least and greatest of a map without the outermost 2 %.
pub fn usual_range(disparity_px: &[f32]) -> [f32; 2] {
    let mut sorted: Vec<f32> = disparity_px.iter().copied().filter(|d| d.is_finite()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let at = |share: f32| sorted.get((sorted.len().saturating_sub(1) as f32 * share) as usize).copied();
    [at(0.02).unwrap_or(0.0), at(0.98).unwrap_or(1.0)]
}

/// The epipolar image of row `y`: the 8 views of the reference's row of views, each `scale` lines high.
pub fn epi_tile<'a>(view: impl Fn(usize) -> &'a Rgb, y: usize, scale: usize) -> Rgb {
    let width = view(36).size[0];
    Raster::from_fn([width, 8 * scale], |x, line| view(32 + line / scale).at(x, y))
}

/// Google's Turbo colour map (polynomial by Mikhailov and Colin), 0 … 1.
pub fn turbo(value: f32) -> [f32; 3] {
    const RED: [f32; 6] = [0.135_721, 4.615_393, -42.660_32, 132.131_08, -152.942_4, 59.286_38];
    const GREEN: [f32; 6] = [0.091_403, 2.194_188, 4.842_967, -14.185_033, 4.277_299, 2.829_566];
    const BLUE: [f32; 6] = [0.106_673, 12.641_946, -60.582_05, 110.362_77, -89.903_11, 27.348_25];
    let x = value.clamp(0.0, 1.0);
    [RED, GREEN, BLUE].map(|k| k.iter().rev().fold(0.0, |sum, c| sum * x + c).clamp(0.0, 1.0))
}

/// Tiles in rows on one picture, each `tile_width` wide.
pub fn join(rows: &[Vec<Rgb>], tile_width: usize) -> Rgb {
    let fitted: Vec<Vec<Rgb>> = rows
        .iter()
        .map(|row| {
            row.iter()
                .map(|tile| {
                    let height = (tile.size[1] * tile_width).div_ceil(tile.size[0].max(1)).max(1);
                    tile.resized([tile_width, height])
                })
                .collect()
        })
        .collect();
    let heights: Vec<usize> = fitted.iter().map(|row| row.iter().map(|t| t.size[1]).max().unwrap_or(1)).collect();
    let columns = fitted.iter().map(Vec::len).max().unwrap_or(1).max(1);
    let size = [columns * (tile_width + GAP), heights.iter().map(|h| h + GAP).sum::<usize>().max(1)];
    let mut sheet = Raster { size, px: vec![[0.08; 3]; size[0] * size[1]] };
    let mut top = 0;
    for (row, height) in fitted.iter().zip(&heights) {
        for (i, tile) in row.iter().enumerate() {
            for (y, line) in tile.px.chunks_exact(tile_width).enumerate() {
                let start = (top + y) * size[0] + i * (tile_width + GAP);
                sheet.px[start..start + tile_width].copy_from_slice(line);
            }
        }
        top += height + GAP;
    }
    sheet
}

/// Writes a picture as PNG, whole or not at all.
///
/// # Errors
/// What the disk says.
pub fn write_png(path: &Path, picture: &Rgb) -> Result<(), SaveError> {
    let bytes: Vec<u8> =
        picture.px.iter().flat_map(|texel| texel.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)).collect();
    let [w, h] = picture.size.map(|side| side as u32);
    atomic(path, |file| {
        let encoder = image::codecs::png::PngEncoder::new(std::io::BufWriter::new(file));
        image::ImageEncoder::write_image(encoder, &bytes, w, h, image::ExtendedColorType::Rgb8)
            .map_err(|e| SaveError::Encode { why: e.to_string(), path: path.to_owned() })
    })
}
