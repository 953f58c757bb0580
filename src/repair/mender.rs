//! A map that is being mended, with the photo's colours beside it.

use std::borrow::Borrow;
use std::sync::Arc;

use super::guide::{Guide, apart};
use super::mask::Mask;
use super::reach::walk;
use super::{Place, Region as Asked, Repair, lasso, operation};
use crate::field::morphology::square;
use crate::field::{DisparityMap, FieldError, Raster};
use crate::job::{Cancelled, Job, Stage};

/// A difference of colours from one pixel to the next below this is noise and texture.
const NOISE: f32 = 0.015;
/// What a colour difference of 1 is worth, in longer sides.
const COLOUR: f32 = 1.6;
/// What a step through the map's whole range is worth, in longer sides.
const STEP: f32 = 1.0;
/// A slope of so many ranges a longer side is no step.
const SLOPE: f32 = 3.0;
/// Colours that differ from the clicked one by less than this are its own, and how much longer others make the way.
const ALIKE: f32 = 0.08;
const STRANGE: f32 = 30.0;
/// Half the square whose mean is the clicked colour, as a share of the longer side.
const SEED: f32 = 3.0 / 540.0;
/// Part of the map's values that may lie outside of its range, at either end.
const TAIL: f32 = 0.02;
/// No range is smaller than this, as a share of the width: a flat map has one too.
const LEAST_RANGE: f32 = 0.25 / 540.0;

/// A rectangle of pixels: its first column and row, and its columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// First column and row.
    pub at: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
}

impl Rect {
    /// The smallest around some pixels, `y · width + x`.
    pub(super) fn around(pixels: &[usize], width: usize) -> Option<Self> {
        let places = || pixels.iter().map(|i| [i % width, i / width]);
        let at = places().reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])])?;
        let end = places().reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])?;
        Some(Self { at, size: [end[0] - at[0] + 1, end[1] - at[1] + 1] })
    }
}

/// Applies repairs to a map of a photo, one after the other.
#[derive(Clone, Debug)]
pub struct Mender {
    guide: Arc<Guide>,
    map: Raster<f32>,
    range_px: f32,
}

/// How far it is from a clicked place to every pixel: regions of all sizes.
#[derive(Clone, Debug)]
pub struct Region {
    sides: [usize; 2],
    ways: Vec<f32>,
}

impl Region {
    /// The thing of a size, as a share of the longer side.
    pub fn mask(&self, mender: &Mender, size: f32) -> Mask {
        Mask::new(self.sides, |i| self.ways[i] <= size).without_specks().out_to_edge(&mender.guide)
    }
}

/// A map with all repairs done to it; those that cannot be used are left out.
///
/// # Errors
/// Cancelled, or a map that is no map any more.
pub fn mended(
    map: &DisparityMap,
    guide: Guide,
    repairs: &[impl Borrow<Repair>],
    job: &Job,
) -> Result<Result<DisparityMap, FieldError>, Cancelled> {
    let mut mender = Mender::new(map, guide);
    for (done, repair) in repairs.iter().enumerate() {
        job.advance(Stage::Mend, done as u32, repairs.len() as u32)?;
        mender.apply(repair.borrow(), job)?;
    }
    Ok(mender.map())
}

impl Mender {
    /// Of a map and the photo's colours at its size.
    pub fn new(map: &DisparityMap, guide: Guide) -> Self {
        let size = map.size();
        let values = map.disparity_px();
        let map = Raster::from_fn(size, |x, y| values[y * size[0] as usize + x]);
        Self { guide: Arc::new(guide), range_px: range(values).max(LEAST_RANGE * size[0] as f32), map }
    }

    /// The map as it is now.
    ///
    /// # Errors
    /// Values that are no numbers; no repair makes such.
    pub fn map(&self) -> Result<DisparityMap, FieldError> {
        DisparityMap::new(self.map.size(), self.map.pixels().to_vec())
    }

    /// The map's values as they are now, `[y, x]`.
    pub fn disparity_px(&self) -> &[f32] {
        self.map.pixels()
    }

    /// Columns and rows.
    pub fn sides(&self) -> [usize; 2] {
        self.map.sides()
    }

    /// Does one repair; one that cannot be used does nothing. A long stroke can be stopped on its way.
    pub(super) fn apply(&mut self, repair: &Repair, job: &Job) -> Result<(), Cancelled> {
        match repair {
            repair if !repair.is_usable() => {}
            Repair::Region { of, what } => {
                let mask = self.region(of);
                let clicked = if let Asked::Click { at, .. } = of { Some(self.pixel(*at)) } else { None };
                operation::perform(self, &mask, clicked, *what);
            }
            Repair::Stroke(stroke) => {
                let mut draft = self.begin(stroke.brush, stroke.size, stroke.strength);
                for place in &stroke.path {
                    job.check()?;
                    let _changed = self.extend(&mut draft, *place);
                }
            }
        }
        Ok(())
    }

    /// The pixels of a thing.
    pub fn region(&self, region: &Asked) -> Mask {
        match region {
            Asked::Click { at, size } => self.reach(*at, *size).mask(self, *size),
            Asked::Lasso { outline, snap } => {
                lasso::snapped(outline, self.sides(), snap * self.long_px(), |a, b, px| self.step(a, b, px))
            }
        }
    }

    /// How far it is from a place to all others that are not farther than `most`, a share of the longer side.
    pub fn reach(&self, at: Place, most: f32) -> Region {
        let start = self.pixel(at);
        let clicked = self.around(start);
        let strange = |i: usize| STRANGE * (apart(self.guide.colour(i), clicked) - ALIKE).max(0.0);
        let cost = |a: usize, b: usize, px: f32| self.step(a, b, px) + px / self.long_px() * strange(b);
        let mut ways = vec![f32::INFINITY; self.map.pixels().len()];
        let _reached = walk(self.sides(), &mut ways, [start], most, cost);
        Region { sides: self.sides(), ways }
    }

    /// What a step costs: its length, the colours' edge and the depth's, in longer sides.
    fn step(&self, a: usize, b: usize, px: f32) -> f32 {
        px / self.long_px() + COLOUR * self.colour_edge(a, b, px) + STEP * self.depth_edge(a, b, px)
    }

    pub(super) fn colour_edge(&self, a: usize, b: usize, px: f32) -> f32 {
        (self.guide.difference(a, b) - NOISE * px).max(0.0)
    }

    /// A step of the map as a part of its range.
    pub(super) fn depth_edge(&self, a: usize, b: usize, px: f32) -> f32 {
        let map = self.map.pixels();
        ((map[a] - map[b]).abs() / self.range_px - SLOPE * px / self.long_px()).max(0.0)
    }

    /// The colour around a pixel.
    fn around(&self, i: usize) -> [f32; 3] {
        let reach = ((SEED * self.long_px()).round() as usize).max(1);
        // A click beside an edge means its own side.
        let own = self.guide.colour(i);
        let alike = square(self.sides(), i, reach).filter(|j| apart(self.guide.colour(*j), own) < ALIKE);
        self.guide.mean(alike).unwrap_or(own)
    }

    /// The pixel at a place; beside the photo that of its edge.
    pub(super) fn pixel(&self, at: Place) -> usize {
        let [x, y] = [0, 1].map(|axis| {
            let side = self.sides()[axis];
            ((at[axis].clamp(0.0, 1.0) * side as f32) as usize).min(side - 1)
        });
        y * self.sides()[0] + x
    }

    pub(super) fn guide(&self) -> &Guide {
        &self.guide
    }

    pub(super) fn values_mut(&mut self) -> &mut [f32] {
        self.map.pixels_mut()
    }

    /// The longer side in pixels.
    pub(super) fn long_px(&self) -> f32 {
        let [w, h] = self.sides();
        w.max(h) as f32
    }

    /// From far to near, before anything was mended.
    pub(super) fn range_px(&self) -> f32 {
        self.range_px
    }

    /// Pixels per view step of a share of the width.
    pub(super) fn px(&self, share: f32) -> f32 {
        share * self.sides()[0] as f32
    }
}

fn range(values: &[f32]) -> f32 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    let at = |share: f32| sorted[(share * (sorted.len() - 1) as f32) as usize];
    at(1.0 - TAIL) - at(TAIL)
}
