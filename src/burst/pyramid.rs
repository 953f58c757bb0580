//! A frame's brightness at halving sizes, for matching.

use rayon::prelude::*;

use crate::field::{Filter, Raster, Size, View, fit_long_side};

/// Long side of the finest level, in pixels.
pub const FINEST: u32 = 1280;
/// No level is smaller than this.
const COARSEST: u32 = 40;
/// A slight blur (three taps), so that places between pixels can be told apart.
const BLUR: [f32; 3] = [0.2, 0.6, 0.2];

/// Brightness, 0 … 1 as it is stored, finest first; each level is half of the one before.
pub struct Pyramid(Vec<Raster<f32>>);

impl Pyramid {
    /// Of a picture.
    pub fn new(view: &View) -> Self {
        let luma = view.map(|[r, g, b, _]| (0.3 * f32::from(r) + 0.6 * f32::from(g) + 0.1 * f32::from(b)) / 255.0);
        let first = blurred(&luma.resized(fit_long_side(view.size(), FINEST), Filter::Area));
        let mut levels = vec![first];
        while let Some(size) = levels.last().map(|level| level.size().map(|side| side.div_ceil(2))) {
            if size[0].max(size[1]) < COARSEST {
                break;
            }
            let next = levels.last().map(|level| level.resized(size, Filter::Area));
            levels.extend(next);
        }
        Self(levels)
    }

    /// The levels, finest first.
    pub fn levels(&self) -> &[Raster<f32>] {
        &self.0
    }

    /// The finest level.
    pub fn finest(&self) -> &Raster<f32> {
        &self.0[0]
    }

    /// The level whose long side is nearest to so many pixels.
    pub fn near(&self, long_side: u32) -> usize {
        let long = |size: Size| size[0].max(size[1]).abs_diff(long_side);
        (0..self.0.len()).min_by_key(|i| long(self.0[*i].size())).unwrap_or_default()
    }
}

fn blurred(picture: &Raster<f32>) -> Raster<f32> {
    let [w, h] = picture.sides();
    let three = |i: usize, n: usize| [i.saturating_sub(1), i, (i + 1).min(n - 1)];
    let across = Raster::par_from_fn(picture.size(), |x, y| {
        three(x, w).iter().zip(BLUR).map(|(x, weight)| weight * picture.at(*x, y)).sum::<f32>()
    });
    Raster::par_from_fn(picture.size(), |x, y| {
        three(y, h).iter().zip(BLUR).map(|(y, weight)| weight * across.at(x, *y)).sum::<f32>()
    })
}

/// Corners of a picture (Shi and Tomasi 1994): the best of each cell, so that they lie everywhere.
pub fn corners(picture: &Raster<f32>, wanted: usize) -> Vec<[f32; 2]> {
    /// Half the side of the window.
    const HALF: usize = 3;
    /// Pixels at the border without corners.
    const BORDER: usize = 8;
    /// Least of the smaller eigenvalue, against the best of all.
    const LEAST: f32 = 2e-4;
    let [w, h] = picture.sides();
    if w < 4 * BORDER || h < 4 * BORDER {
        return Vec::new();
    }
    let gradient = |x: usize, y: usize| {
        let dx = picture.at((x + 1).min(w - 1), y) - picture.at(x.saturating_sub(1), y);
        let dy = picture.at(x, (y + 1).min(h - 1)) - picture.at(x, y.saturating_sub(1));
        [dx * dx, dx * dy, dy * dy]
    };
    let products = Raster::par_from_fn(picture.size(), gradient);
    let window = |i: usize, n: usize| i.saturating_sub(HALF)..(i + HALF + 1).min(n);
    let add = |sum: [f32; 3], more: [f32; 3]| [0, 1, 2].map(|c| sum[c] + more[c]);
    let across =
        Raster::par_from_fn(picture.size(), |x, y| window(x, w).map(|x| products.at(x, y)).fold([0.0; 3], add));
    let least = Raster::par_from_fn(picture.size(), |x, y| {
        let [a, b, c] = window(y, h).map(|y| across.at(x, y)).fold([0.0; 3], add);
        0.5 * (a + c - ((a - c).powi(2) + 4.0 * b * b).sqrt())
    });
    let best = least.pixels().iter().copied().fold(0.0, f32::max);
    let cell = (((w * h) as f32 / wanted.max(1) as f32).sqrt() as usize).max(4);
    let [columns, rows] = [w - 2 * BORDER, h - 2 * BORDER].map(|side| side.div_ceil(cell));
    let in_cell = |i: usize| {
        let [x0, y0] = [BORDER + i % columns * cell, BORDER + i / columns * cell];
        let places =
            (y0..(y0 + cell).min(h - BORDER)).flat_map(|y| (x0..(x0 + cell).min(w - BORDER)).map(move |x| (x, y)));
        let (x, y) = places.max_by(|a, b| least.at(a.0, a.1).total_cmp(&least.at(b.0, b.1)))?;
        (least.at(x, y) > LEAST * best && best > 0.0).then_some([x as f32, y as f32])
    };
    (0..columns * rows).into_par_iter().filter_map(in_cell).collect()
}
