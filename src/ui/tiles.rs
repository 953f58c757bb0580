//! Large pictures on the screen: a pyramid of tiles that are uploaded when they are seen, so that no picture is too large
//! for the adapter and no frame waits for a whole one.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use egui::{Color32, ColorImage, Painter, Pos2, Rect, TextureHandle, TextureOptions, pos2, vec2};
use rayon::prelude::*;

use super::theme;
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
    /// Cuts an sRGB picture (`[y, x, 4]`) into tiles, with all its smaller levels. For a worker thread.
    pub fn new(size: [u32; 2], rgba: &[u8]) -> Self {
        let mut levels = vec![cut(size, rgba)];
        let mut current = (size, Vec::new());
        while current.0[0].max(current.0[1]) > SMALLEST {
            let source = if current.1.is_empty() { rgba } else { &current.1 };
            current = half(current.0, source);
            levels.push(cut(current.0, &current.1));
        }
        Self { levels }
    }

    /// As [`TileSet::new`], from a picture in linear light.
    pub fn of_picture(picture: &Picture) -> Self {
        Self::new(picture.size, &picture.to_srgb8())
    }
}

/// Half the size by the mean of 2×2 pixels. In sRGB: for the screen alone, where the picture is halved once or twice.
fn half(size: [u32; 2], rgba: &[u8]) -> ([u32; 2], Vec<u8>) {
    let small = size.map(|side| side.div_ceil(2));
    let mut out = vec![0; small[0] as usize * small[1] as usize * 4];
    out.par_chunks_mut(small[0] as usize * 4).enumerate().for_each(|(y, row)| {
        let line = |dy: usize| (y * 2 + dy).min(size[1] as usize - 1) * size[0] as usize;
        for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
            let column = |dx: usize| (x * 2 + dx).min(size[0] as usize - 1);
            for (c, value) in pixel.iter_mut().enumerate() {
                let at = |dx, dy| u16::from(rgba[(line(dy) + column(dx)) * 4 + c]);
                *value = ((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4) as u8;
            }
        }
    });
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
            let pixels = (y0..y1).flat_map(|y| row(y).chunks_exact(4));
            let pixels = pixels.map(|p| Color32::from_rgb(p[0], p[1], p[2])).collect();
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

    /// Draws the picture over `rect`; what is outside the painter's clip is neither drawn nor uploaded.
    pub fn paint(&mut self, painter: &Painter, rect: Rect) {
        let pixels = rect.width() * painter.pixels_per_point();
        // The level that is at least as fine as the screen.
        let fits = |level: &Level| level.size[0] as f32 >= pixels * 0.99;
        let best = self.set.levels.iter().rposition(fits).unwrap_or(0);
        let coarsest = self.set.levels.len() - 1;
        let mut budget = TILES_PER_FRAME;
        self.paint_level(painter, rect, coarsest, &mut budget);
        if best != coarsest {
            self.paint_level(painter, rect, best, &mut budget);
        }
    }

    fn paint_level(&mut self, painter: &Painter, rect: Rect, level: usize, budget: &mut usize) {
        let set = Arc::clone(&self.set);
        let size = set.levels[level].size;
        let scale = vec2(rect.width() / size[0] as f32, rect.height() / size[1] as f32);
        let place = |x: u32, y: u32| rect.min + vec2(x as f32, y as f32) * scale;
        for (index, tile) in set.levels[level].tiles.iter().enumerate() {
            let [x0, y0, x1, y1] = tile.place;
            let on_screen = Rect::from_min_max(place(x0, y0), place(x1, y1));
            if !on_screen.intersects(painter.clip_rect()) {
                continue;
            }
            if let Some(texture) = self.texture(painter, (level, index), tile, budget) {
                painter.image(texture.id(), on_screen, tile.uv(), theme::AS_IS);
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
