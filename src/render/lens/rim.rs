//! How much of the lens sees a pixel's own surface beside an edge, where that surface is nearly sharp.
//!
//! Maps dip by a few per cent before an edge. Light that is blurred a little there is spread over its neighbours, and those,
//! in focus, give none back: it would leave open what no edge takes from it. So what may stay open is counted.

use super::rays::NEARLY_SHARP_PX;
use super::tile::Region;
use crate::field::{ramp, sides};

/// Pixels around a tile that the light of such a surface comes from.
const MARGIN: i32 = 3;
/// What stays open though no edge takes it: kernels are discs of another grain than what is counted here.
const SLACK: f32 = 0.03;

/// A neighbour's near side is another surface where it is farther by so much blur, and the same up to so much.
const FARTHER_PX: [f32; 2] = [5.5, 2.5];

/// The near side of a pixel.
#[derive(Clone, Copy)]
struct Near {
    /// How much of the pixel it covers.
    cover: f32,
    /// How much it is blurred; as much as any where nothing is noted.
    blur: f32,
}

/// A tile's near sides.
#[derive(Default)]
pub(super) struct Rims {
    at: [i32; 2],
    size: [usize; 2],
    /// `[y, x]` of the tile and the margin around it.
    near: Vec<Near>,
    /// Pixels of the near side beside an edge, with their blur.
    beside: Vec<([i32; 2], f32)>,
}

impl Rims {
    /// Begins another tile.
    pub(super) fn begin(&mut self, region: Region) {
        self.at = region.at.map(|at| at as i32 - MARGIN);
        self.size = sides(region.size).map(|side| side + 2 * MARGIN as usize);
        self.beside.clear();
        self.near.clear();
        self.near.resize(self.size[0] * self.size[1], Near { cover: 1.0, blur: f32::INFINITY });
    }

    fn index(&self, [x, y]: [i32; 2]) -> Option<usize> {
        let [x, y] = [x - self.at[0], y - self.at[1]].map(|at| at as usize);
        // Negative places are large ones here.
        (x < self.size[0] && y < self.size[1]).then(|| y * self.size[0] + x)
    }

    /// Notes how much of a pixel the near side covers, and how much it is blurred, which is asked for in the tile alone.
    pub(super) fn cover(&mut self, place: [i32; 2], cover: f32, blur: impl FnOnce() -> f32) {
        if let Some(at) = self.index(place) {
            self.near[at] = Near { cover, blur: blur() };
        }
    }

    /// Notes a pixel of the near side that not all of the lens may see.
    pub(super) fn wait(&mut self, place: [i32; 2], blur: f32) {
        let within = |axis: usize| {
            let at = place[axis] - self.at[axis];
            at >= MARGIN && at < self.size[axis] as i32 - MARGIN
        };
        if blur.abs() < NEARLY_SHARP_PX && within(0) && within(1) {
            self.beside.push((place, blur));
        }
    }

    /// Pixels of which the whole tile is known now, each with its blur and the most that may be left of its opening.
    pub(super) fn open(&self) -> impl Iterator<Item = ([i32; 2], f32, f32)> {
        self.beside.iter().map(|&(place, blur)| (place, blur, self.beyond(place, blur) + SLACK))
    }

    /// The part of a disc around a pixel that is not its own surface; never less than of the pixel itself, as its neighbours
    /// may be blurred less.
    fn beyond(&self, place: [i32; 2], blur: f32) -> f32 {
        let (radius, mut all, mut beyond) = (blur.abs() / 2.0, 0.0, 0.0);
        let reach = (radius + 0.5).ceil() as i32 - 1;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let weight = (radius + 0.5 - ((dx * dx + dy * dy) as f32).sqrt()).clamp(0.0, 1.0);
                let Some(at) = self.index([place[0] + dx, place[1] + dy]) else { continue };
                let near = self.near[at];
                all += weight;
                beyond += weight * (1.0 - near.cover * ramp(FARTHER_PX[0], FARTHER_PX[1], blur - near.blur));
            }
        }
        let own = self.index(place).map_or(1.0, |at| self.near[at].cover);
        (beyond / f32::max(all, 1e-6)).max(1.0 - own)
    }
}
