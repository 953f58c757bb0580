//! Where a photo lies on a canvas: crop, zoom, flip, a slight turn, and its colours.

use super::raster::{Raster, Texel, window};
use super::{Config, FOCAL_NEARNESS};
use crate::rng::Rng;

/// The picture to be made, and room around it for views to look into.
#[derive(Clone, Copy)]
pub struct Canvas {
    /// Width and height of the picture.
    pub size: [usize; 2],
    /// Pixels on every side.
    pub margin: usize,
    /// Pixels per view step between nearness 0 and 1.
    pub range_px: f32,
    /// Nearness of the focal plane.
    pub focus: f32,
}

impl Canvas {
    /// A canvas whose margin holds the farthest shift, four steps.
    pub fn new(size: [usize; 2], range_px: f32) -> Self {
        Self { size, margin: (4.0 * range_px).ceil() as usize + 2, range_px, focus: FOCAL_NEARNESS }
    }

    /// Width and height with the margin.
    pub fn full(&self) -> [usize; 2] {
        self.size.map(|side| side + 2 * self.margin)
    }

    /// Disparity of a nearness.
    pub fn disparity(&self, nearness: f32) -> f32 {
        self.range_px * (nearness - self.focus)
    }

    /// The picture's part of a canvas-sized raster.
    pub fn crop<T: Copy>(&self, raster: &Raster<T>) -> Vec<T> {
        window(&raster.px, raster.size[0], [self.margin; 2], self.size)
    }
}

/// The affine map from canvas pixels to a source picture's pixels.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Source step for a step right, and for a step down.
    axes: [[f32; 2]; 2],
    /// Source place of canvas pixel (0, 0).
    origin: [f32; 2],
    /// See [`super::Sample::yx`].
    pub yx: [f32; 4],
    /// Picture coordinates −1 … 1 of canvas pixel (0, 0) and their steps, y then x.
    rows: [f32; 2],
}

impl Place {
    /// The whole picture, fitted to the canvas.
    pub fn whole(picture: [usize; 2], canvas: &Canvas) -> Self {
        let scale = [0, 1].map(|i| picture[i] as f32 / canvas.size[i] as f32);
        let from = |i: usize| (0.5 - canvas.margin as f32) * scale[i] - 0.5;
        let step = 2.0 / (canvas.size[1].max(2) - 1) as f32;
        Self {
            axes: [[scale[0], 0.0], [0.0, scale[1]]],
            origin: [from(0), from(1)],
            yx: [-1.0, 1.0, -1.0, 1.0],
            rows: [-1.0 - step * canvas.margin as f32, step],
        }
    }

    /// Nearly the whole picture (nets need to see it), or a part; flipped or not; turned and stretched a little. With
    /// more variety, some parts count as pictures of their own.
    pub fn random(rng: &mut Rng, picture: [usize; 2], canvas: &Canvas, config: &Config) -> Self {
        let variety = config.variety;
        let [w, h] = canvas.size.map(|side| side as f32);
        let [pw, ph] = picture.map(|side| side as f32);
        let part = !rng.chance(0.55);
        let zoom = if part { rng.range(1.1, 1.1 + 0.5 * variety) } else { rng.range(1.0, 1.1) };
        let alone = part && rng.chance(0.3 * (variety - 1.0));
        let stretch = if rng.chance(0.5) { (variety * rng.range(-0.12, 0.12)).exp() } else { 1.0 };
        let scale = zoom * config.long_side as f32 / pw.max(ph);
        let scale = [(scale * stretch).max(w / pw), (scale / stretch).max(h / ph)];
        let whole = [pw * scale[0], ph * scale[1]];
        let left = rng.unit() * (whole[0] - w).max(0.0);
        let top = rng.unit() * (whole[1] - h).max(0.0);
        let flip = if rng.chance(0.5) { -1.0 } else { 1.0 };
        let angle = if rng.chance(0.3) { variety * rng.range(-0.1, 0.1) } else { 0.0 };
        let (sin, cos) = f32::sin_cos(angle);
        let axes = [[flip * cos / scale[0], sin / scale[1]], [-flip * sin / scale[0], cos / scale[1]]];
        // The crop's middle, in source pixels; the flipped picture is mirrored as a whole.
        let middle_x = (left + w / 2.0) / scale[0];
        let middle = [if flip < 0.0 { pw - middle_x } else { middle_x } - 0.5, (top + h / 2.0) / scale[1] - 0.5];
        let back = [w, h].map(|side| canvas.margin as f32 + (side - 1.0) / 2.0);
        let origin = [0, 1].map(|i| middle[i] - back[0] * axes[0][i] - back[1] * axes[1][i]);
        let along = |at: f32, all: f32| 2.0 * at / (all - 1.0).max(1.0) - 1.0;
        let within = [
            along(top, whole[1]),
            along(top + h - 1.0, whole[1]),
            along(left, whole[0]),
            along(left + w - 1.0, whole[0]),
        ];
        let yx = if alone { [-1.0, 1.0, -1.0, 1.0] } else { within };
        let step = (yx[1] - yx[0]) / (h - 1.0).max(1.0);
        Self { axes, origin, yx, rows: [yx[0] - step * canvas.margin as f32, step] }
    }

    /// The same place of a picture of this size that is shown after so many quarter turns to the left: `self` was made
    /// for the turned picture.
    pub fn turned(mut self, size: [usize; 2], turns: usize) -> Self {
        // A picture's right end is the top of it turned to the left.
        let back = |[x, y]: [f32; 2]| [-y, x];
        for turn in (0..turns).rev() {
            let end = turned_size(size, turn)[0] as f32 - 1.0;
            self.axes = self.axes.map(back);
            let [x, y] = back(self.origin);
            self.origin = [x + end, y];
        }
        self
    }

    /// A cut-out: source place `from` comes to canvas place `to` (without margin); `axis` is the source step for a step
    /// right, `flip` −1 where it is mirrored.
    pub fn similar(from: [f32; 2], to: [f32; 2], axis: [f32; 2], flip: f32, canvas: &Canvas) -> Self {
        let axes = [axis, [-axis[1] * flip, axis[0] * flip]];
        let to = to.map(|at| at + canvas.margin as f32);
        let origin = [0, 1].map(|i| from[i] - to[0] * axes[0][i] - to[1] * axes[1][i]);
        Self { axes, origin, yx: [-1.0, 1.0, -1.0, 1.0], rows: [0.0, 0.0] }
    }

    /// Like [`Self::fill`], but 0 outside the source.
    pub fn fill_inside(&self, source: &Raster<u8>, size: [usize; 2]) -> Raster<f32> {
        let [w, h] = source.size.map(|side| side as f32 - 0.5);
        Raster::from_fn(size, |x, y| {
            let [sx, sy] = [0, 1].map(|i| self.origin[i] + x as f32 * self.axes[0][i] + y as f32 * self.axes[1][i]);
            if sx < -0.5 || sy < -0.5 || sx > w || sy > h { 0.0 } else { source.tap(sx, sy) }
        })
    }

    /// The source as it lies on the canvas; its edge goes on where it ends.
    pub fn fill<T: Texel>(&self, source: &Raster<T>, size: [usize; 2]) -> Raster<T::Out> {
        let mut px = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            let start = [0, 1].map(|i| self.origin[i] + y as f32 * self.axes[1][i]);
            px.extend(
                (0..size[0])
                    .map(|x| source.tap(start[0] + x as f32 * self.axes[0][0], start[1] + x as f32 * self.axes[0][1])),
            );
        }
        Raster { size, px }
    }

    /// The picture's row coordinate of a canvas row: 0 at its top, 1 at its bottom.
    pub fn row(&self, y: usize) -> f32 {
        ((self.rows[0] + self.rows[1] * y as f32) * 0.5 + 0.5).clamp(0.0, 1.0)
    }
}

/// Width and height after so many quarter turns.
pub fn turned_size([w, h]: [usize; 2], turns: usize) -> [usize; 2] {
    if turns.is_multiple_of(2) { [w, h] } else { [h, w] }
}

/// A change of tone: gamma and a gain for each channel.
pub struct Tone {
    /// Values 0 … 255 in quarters.
    tables: [Vec<f32>; 3],
    /// 0 is grey, 1 leaves colours as they are.
    saturation: f32,
}

impl Tone {
    /// Colours as they are.
    pub fn plain() -> Self {
        Self::new(1.0, [1.0; 3], 1.0)
    }

    /// Gamma and gains of the channels around 1, pale to strong colours, sometimes none.
    pub fn random(rng: &mut Rng, variety: f32) -> Self {
        let mut around = |reach: f32| (variety * rng.range(-reach, reach)).exp();
        let (gamma, light) = (around(0.3), around(0.15));
        let gains = std::array::from_fn(|_| light * around(0.1));
        let grey = rng.chance(0.06 * variety);
        let saturation = if grey { 0.0 } else { (1.0 + variety * rng.range(-0.5, 0.4)).max(0.0) };
        Self::new(gamma, gains, saturation)
    }

    fn new(gamma: f32, gains: [f32; 3], saturation: f32) -> Self {
        let value = |i: usize| (i as f32 / 1020.0).powf(gamma);
        Self { tables: gains.map(|gain| (0..=1020).map(|i| (gain * value(i)).min(1.0)).collect()), saturation }
    }

    /// Colours 0 … 255 to 0 … 1.
    pub fn apply(&self, raster: &Raster<[f32; 3]>) -> Raster<[f32; 3]> {
        raster.map(|&texel| self.texel(texel))
    }

    /// One colour 0 … 255 to 0 … 1.
    pub fn texel(&self, texel: [f32; 3]) -> [f32; 3] {
        let toned: [f32; 3] = std::array::from_fn(|c| self.tables[c][((texel[c] * 4.0 + 0.5) as usize).min(1020)]);
        let grey = 0.299 * toned[0] + 0.587 * toned[1] + 0.114 * toned[2];
        toned.map(|c| (grey + self.saturation * (c - grey)).clamp(0.0, 1.0))
    }
}

/// A ground or wall on the canvas: nearness of each pixel.
pub fn ground(rng: &mut Rng, place: &Place, size: [usize; 2]) -> Raster<f32> {
    let low = rng.range(0.0, 0.15);
    let rise = rng.range(0.1, 0.65);
    let bend = rng.range(1.0, 2.5);
    let tilt = rng.range(-0.06, 0.06);
    let across = |x: usize| 2.0 * x as f32 / (size[0] - 1) as f32 - 1.0;
    match rng.weighted(&[0.6, 0.15, 0.25]) {
        // Lower is nearer.
        0 => {
            let row: Vec<f32> = (0..size[1]).map(|y| low + rise * place.row(y).powf(bend)).collect();
            Raster::from_fn(size, |x, y| row[y] + tilt * across(x))
        }
        // A wall, a hedge or a fence across the view.
        1 => {
            let near = rng.range(0.0, 0.7);
            Raster::from_fn(size, |x, _| near + tilt * across(x))
        }
        // A plane that runs another way.
        _ => {
            let angle = rng.range(0.0, std::f32::consts::TAU);
            let (sin, cos) = f32::sin_cos(angle);
            Raster::from_fn(size, |x, y| {
                let down = 2.0 * place.row(y) - 1.0;
                low + rise * (0.5 + 0.35 * (cos * across(x) + sin * down)).clamp(0.0, 1.0)
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_picture_is_the_picture_turned() {
        let size = [5, 3];
        let source = Raster::from_fn(size, |x, y| (10 * x + 40 * y) as u8);
        for turns in 0..4 {
            let turned = turned_size(size, turns);
            let canvas = Canvas { size: turned, margin: 0, range_px: 1.0, focus: 0.5 };
            let shown = Place::whole(turned, &canvas).turned(size, turns).fill(&source, turned);
            let mut by_hand = source.clone();
            for _ in 0..turns {
                let [w, h] = by_hand.size;
                by_hand = Raster::from_fn([h, w], |x, y| by_hand.px[x * w + w - 1 - y]);
            }
            let wanted: Vec<f32> = by_hand.px.iter().map(|&texel| f32::from(texel)).collect();
            assert_eq!(shown.px, wanted, "{turns}");
        }
    }
}
