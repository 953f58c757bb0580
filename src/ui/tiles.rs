//! Large pictures on the screen: a pyramid of tiles that are uploaded when they are seen, so that no picture is too large
//! for the adapter and no frame waits for a whole one.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use egui::{Color32, ColorImage, Painter, Pos2, Rect, TextureHandle, TextureOptions, pos2, vec2};
use rayon::prelude::*;

use super::theme;
use crate::field::{Histogram, pixels};
use crate::render::Picture;

/// Side of a tile, in pixels, without its rim.
const TILE: u32 = 1024;
/// The smallest level is not longer than this, and so one tile.
const SMALLEST: u32 = 1000;
/// Tiles uploaded in one frame: 4 MiB each.
const TILES_PER_FRAME: usize = 2;

/// A pyramid: level 0 is the picture, each further one half its size.
#[derive(Debug)]
pub struct TileSet {
    levels: Vec<Level>,
    /// How bright it is; none of a preview.
    histogram: Option<Histogram>,
}

#[derive(Debug)]
struct Level {
    size: [u32; 2],
    tiles: Vec<Tile>,
}

#[derive(Debug)]
struct Tile {
    /// Place in the level, without the rim.
    place: [u32; 4],
    /// One pixel of the neighbours on each side, so that no seam shows.
    rim: [u32; 2],
    image: Arc<ColorImage>,
}

impl TileSet {
    /// About as large as the screen, at once: what is shown until all tiles are there. None where that is the picture.
    pub fn preview(size: [u32; 2], rgba: &[u8]) -> Option<Self> {
        let by = size[0].max(size[1]) / SMALLEST;
        (by > 1).then(|| {
            let (size, rgba) = shrunk(size, rgba, by);
            Self { levels: vec![cut(size, &rgba)], histogram: None }
        })
    }

    /// Cuts an opaque sRGB picture (`[y, x, 4]`) into tiles, with all its smaller levels. For a worker thread.
    pub fn new(size: [u32; 2], rgba: &[u8]) -> Self {
        let histogram = Some(Histogram::of_srgb8(rgba));
        let mut levels = vec![cut(size, rgba)];
        let mut current = (size, Vec::new());
        while current.0[0].max(current.0[1]) > SMALLEST {
            let source = if current.1.is_empty() { rgba } else { &current.1 };
            current = shrunk(current.0, source, 2);
            levels.push(cut(current.0, &current.1));
        }
        Self { levels, histogram }
    }

    /// As [`TileSet::new`], from a picture in linear light.
    pub fn of_picture(picture: &Picture) -> Self {
        Self::new(picture.size, &picture.to_srgb8())
    }
}

/// A size divided by a whole number, by the mean of that many pixels squared. In sRGB: for the screen alone, where the
/// picture is halved once or twice.
fn shrunk(size: [u32; 2], rgba: &[u8], by: u32) -> ([u32; 2], Vec<u8>) {
    let small = size.map(|side| side.div_ceil(by));
    let (row_bytes, block_bytes) = (size[0] as usize * 4, by as usize * 4);
    let mut out = vec![0; pixels(small) * 4];
    let blocks = rgba.par_chunks(row_bytes * by as usize);
    out.par_chunks_exact_mut(small[0] as usize * 4).zip(blocks).for_each_init(
        || vec![[0u32; 4]; small[0] as usize],
        |sums, (out, rows)| {
            sums.fill([0; 4]);
            for row in rows.chunks_exact(row_bytes) {
                for (sum, block) in sums.iter_mut().zip(row.chunks(block_bytes)) {
                    block
                        .as_chunks::<4>()
                        .0
                        .iter()
                        .for_each(|pixel| (0..4).for_each(|c| sum[c] += u32::from(pixel[c])));
                }
            }
            let height = rows.len() / row_bytes;
            for (x, (pixel, sum)) in out.as_chunks_mut::<4>().0.iter_mut().zip(sums).enumerate() {
                let width = by.min(size[0] - x as u32 * by);
                let count = width * height as u32;
                *pixel = sum.map(|sum| ((sum + count / 2) / count) as u8);
            }
        },
    );
    (small, out)
}

fn cut(size: [u32; 2], rgba: &[u8]) -> Level {
    let starts = |side: u32| (0..side).step_by(TILE as usize);
    let places: Vec<[u32; 4]> = starts(size[1])
        .flat_map(|y| starts(size[0]).map(move |x| [x, y, (x + TILE).min(size[0]), (y + TILE).min(size[1])]))
        .collect();
    let tiles = places
        .into_par_iter()
        .map(|place| {
            let [x0, y0] = [place[0].saturating_sub(1), place[1].saturating_sub(1)];
            let [x1, y1] = [(place[2] + 1).min(size[0]), (place[3] + 1).min(size[1])];
            let row = |y: u32| &rgba[(y as usize * size[0] as usize + x0 as usize) * 4..][..(x1 - x0) as usize * 4];
            let mut pixels: Vec<Color32> = Vec::with_capacity(((x1 - x0) * (y1 - y0)) as usize);
            (y0..y1).for_each(|y| pixels.extend_from_slice(bytemuck::cast_slice(row(y))));
            let image = Arc::new(ColorImage::new([(x1 - x0) as usize, (y1 - y0) as usize], pixels));
            Tile { place, rim: [place[0] - x0, place[1] - y0], image }
        })
        .collect();
    Level { size, tiles }
}

/// A tile set on the device.
pub struct Tiled {
    set: Arc<TileSet>,
    textures: HashMap<(usize, usize), TextureHandle>,
}

impl Tiled {
    /// Nothing is uploaded yet.
    pub fn new(set: Arc<TileSet>) -> Self {
        Self { set, textures: HashMap::new() }
    }

    /// How bright the picture is.
    pub fn histogram(&self) -> Option<&Histogram> {
        self.set.histogram.as_ref()
    }

    /// Draws the picture over `rect`; what is outside the painter's clip is neither drawn nor uploaded.
    pub fn paint(&mut self, painter: &Painter, rect: Rect) {
        let pixels = rect.width() * painter.pixels_per_point();
        // The level that is at least as fine as the screen.
        let fits = |level: &Level| level.size[0] as f32 >= pixels * 0.99;
        let best = self.set.levels.iter().rposition(fits).unwrap_or(0);
        let coarsest = self.set.levels.len() - 1;
        let mut budget = TILES_PER_FRAME;
        let seen = self.set.levels[best].seen(painter, rect);
        // What is not there yet shows the coarsest level, which is one tile.
        if !seen.iter().all(|(index, _)| self.textures.contains_key(&(best, *index))) {
            self.paint_tiles(painter, coarsest, &self.set.levels[coarsest].seen(painter, rect), &mut budget);
        }
        self.paint_tiles(painter, best, &seen, &mut budget);
    }

    fn paint_tiles(&mut self, painter: &Painter, level: usize, seen: &[(usize, Rect)], budget: &mut usize) {
        let set = Arc::clone(&self.set);
        for (index, on_screen) in seen {
            let tile = &set.levels[level].tiles[*index];
            if let Some(texture) = self.texture(painter, (level, *index), tile, budget) {
                painter.image(texture.id(), *on_screen, tile.uv(), theme::AS_IS);
            }
        }
    }

    fn texture(
        &mut self,
        painter: &Painter,
        key: (usize, usize),
        tile: &Tile,
        budget: &mut usize,
    ) -> Option<&TextureHandle> {
        if let Entry::Vacant(free) = self.textures.entry(key) {
            if *budget == 0 {
                painter.ctx().request_repaint();
                return None;
            }
            *budget -= 1;
            let texture = painter.ctx().load_texture("tile", Arc::clone(&tile.image), TextureOptions::LINEAR);
            free.insert(texture);
        }
        self.textures.get(&key)
    }
}

impl Level {
    /// The tiles that a painter shows, and where, when the picture lies at `rect`.
    fn seen(&self, painter: &Painter, rect: Rect) -> Vec<(usize, Rect)> {
        let scale = rect.size() / vec2(self.size[0] as f32, self.size[1] as f32);
        let place = |x: u32, y: u32| rect.min + vec2(x as f32, y as f32) * scale;
        let on_screen = |tile: &Tile| {
            let [x0, y0, x1, y1] = tile.place;
            Rect::from_min_max(place(x0, y0), place(x1, y1))
        };
        let tiles = self.tiles.iter().map(on_screen).enumerate();
        tiles.filter(|(_, at)| at.intersects(painter.clip_rect())).collect()
    }
}

impl Tile {
    /// Texture coordinates of the tile without its rim.
    fn uv(&self) -> Rect {
        let [w, h] = self.image.size.map(|side| side as f32);
        let corner = |x: u32, y: u32| -> Pos2 { pos2(x as f32 / w, y as f32 / h) };
        let [x0, y0, x1, y1] = self.place;
        let [rx, ry] = self.rim;
        Rect::from_min_max(corner(rx, ry), corner(rx + x1 - x0, ry + y1 - y0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shrunk_picture_is_the_mean_of_what_there_is() {
        let value = |x: u32, y: u32| ((x * 10 + y * 3) % 256) as u8;
        let rgba: Vec<u8> = (0..3).flat_map(|y| (0..5).flat_map(move |x| [value(x, y), 0, 7, 255])).collect();
        let (size, out) = shrunk([5, 3], &rgba, 2);
        assert_eq!(size, [3, 2]);
        assert_eq!(out[..4], [7, 0, 7, 255], "0, 10, 3, 13 and half a step more");
        assert_eq!(out[(3 + 2) * 4], value(4, 2), "a corner that is one pixel");
        assert_eq!(TileSet::preview([5, 3], &rgba).map(|set| set.levels.len()), None);
    }

    #[test]
    fn tiles_cover_every_level_once_and_carry_their_pixels() {
        let size = [2100, 1030];
        let rgba: Vec<u8> =
            (0..size[0] * size[1]).flat_map(|i| [(i % 251) as u8, (i / 2100 % 251) as u8, 7, 255]).collect();
        let set = TileSet::new(size, &rgba);
        assert_eq!(set.levels.iter().map(|l| l.size).collect::<Vec<_>>(), [[2100, 1030], [1050, 515], [525, 258]]);
        for level in &set.levels {
            let area: u32 = level.tiles.iter().map(|t| (t.place[2] - t.place[0]) * (t.place[3] - t.place[1])).sum();
            assert_eq!(area, level.size[0] * level.size[1]);
        }
        let tile = &set.levels[0].tiles[4];
        assert_eq!((tile.place, tile.rim), ([1024, 1024, 2048, 1030], [1, 1]));
        let first = tile.image.pixels[tile.image.size[0] + 1];
        let at = (1024 * 2100 + 1024) * 4;
        assert_eq!(first, Color32::from_rgb(rgba[at], rgba[at + 1], 7));
    }
}
