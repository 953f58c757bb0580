//! Ray depth at the light field's size, with the photo as guide, so that edges sit on edges.
//!
//! A larger map is reduced without averages. One nearly as large as its guide knows better than the photo's colours:
//! sharp it stays, and where it is soft its ramps become steps (`steps`). A small one needs the photo, as does what a net
//! says of a picture larger than those that it knows; thin parts of that are taken out before and put back after (`thin`):
//!
//! 1. Enlarge the map. Where it changes quickly it is uncertain: its edge lies somewhere in there.
//! 2. Let certain values flow into uncertain ones, stopped by the photo's edges: normalised convolution by the
//!    recursive domain transform (Gastal and Oliveira 2011).
//! 3. Sharpen what is still steep: such a pixel takes the near or the far side, never a depth in between.
//! 4. Tips that the small map missed go to the near side where the photo joins them with it (`tips`).
//! 5. What is left as islands smaller than a pixel of the small map is texture of the photo, not depth: it goes to a side.

use rayon::prelude::*;

use super::lift::STEP_PX;
use super::{SynthError, speckles, steps, thin, tips};
use crate::field::{DisparityMap, Filter, Size, View, resample, sides};
use crate::job::{Cancel, Cancelled, Job};

/// Enlargement from which on a map is small: its edges are to be found in the photo, and no thin parts in it.
const SMALL: f32 = 2.0;
/// How far a certain value flows over even colour, as a share of the long side.
const FLOW_SHARE: f32 = 0.05;
/// A map whose steps rise by this part of them from one pixel to the next is as sharp as it can be drawn.
const SHARP: f32 = 0.5;
/// A difference of colour (mean of the channels, 0 … 1) that halts the flow.
const COLOUR_SIGMA: f32 = 0.04;
/// Colour differences below this are noise and texture.
const COLOUR_NOISE: f32 = 0.015;
/// A change over one pixel of the small map, in px at the target's size, at which half the certainty is gone.
const UNCERTAIN_PX: f32 = 0.04;
/// The same as a multiple of the map's median slope, where that is more.
const STEEPER_THAN_USUAL: f32 = 2.0;
/// No pixel is wholly uncertain: its own value stays where nothing better flows in.
const LEAST: f32 = 1e-4;
/// Passes of the domain transform, each finer.
const PASSES: u32 = 3;
/// Rounds of sharpening: a steep ramp of twice as many pixels becomes a step.
const SHARPEN_ROUNDS: usize = 6;
/// Longest way from a pixel of a ramp to its end: pixels of the guide, and more of them for each pixel of the map.
const RAMP_PX: f32 = 6.0;
const RAMP_OF_MAP: f32 = 3.0;

/// Brings a map to the size of its guide; values are multiplied by the ratio of widths.
///
/// # Errors
/// Cancelled; values beyond all measure.
pub fn to_guide(map: &DisparityMap, guide: &View, job: &Job) -> Result<DisparityMap, SynthError> {
    let small = Small::of(map, guide);
    let disparity_px = if small.enlarged >= SMALL { small.moved(&small.laid(), job)? } else { small.kept(job)? };
    Ok(DisparityMap::new(guide.size(), disparity_px)?)
}

/// The same of a map by a net that does not know where edges are, however large it is; thin parts of a large one stay.
///
/// # Errors
/// Those of [`to_guide`].
pub(super) fn net_to_guide(map: &DisparityMap, guide: &View, job: &Job) -> Result<DisparityMap, SynthError> {
    let small = Small::of(map, guide);
    let disparity_px =
        if small.enlarged >= SMALL { small.moved(&small.laid(), job)? } else { small.moved_behind_thin(job)? };
    Ok(DisparityMap::new(guide.size(), disparity_px)?)
}

/// A map no larger than its guide.
struct Small<'a> {
    /// `[y, x]`, px at the guide's width.
    map: Vec<f32>,
    size: Size,
    guide: &'a View,
    /// How many pixels of the guide lie along one of the map.
    enlarged: f32,
}

impl<'a> Small<'a> {
    fn of(map: &DisparityMap, guide: &'a View) -> Self {
        let ratio = map.scale_to(guide.size());
        let scaled: Vec<f32> = map.disparity_px().iter().map(|d| d * ratio).collect();
        let (map, size) = reduced(scaled, map.size(), guide.size());
        Self { map, size, guide, enlarged: guide.size()[0] as f32 / size[0] as f32 }
    }

    /// Values of the map's size at the guide's.
    fn at_guide(&self, values: &[f32]) -> Vec<f32> {
        resample::<1>(values, self.size, self.guide.size(), Filter::Linear)
    }

    /// The map at the guide's size, its edges soft.
    fn laid(&self) -> Vec<f32> {
        self.at_guide(&self.map)
    }

    /// What is [laid](Self::laid), its edges moved to the photo's.
    fn moved(&self, laid: &[f32], job: &Job) -> Result<Vec<f32>, Cancelled> {
        let certain = self.at_guide(&certainty(&self.map, sides(self.size)));
        let moved = spread(laid, &certain, self.guide, job)?;
        self.without_speckles(moved, job)
    }

    /// The same, but for thin parts, which stay where they are.
    fn moved_behind_thin(mut self, job: &Job) -> Result<Vec<f32>, Cancelled> {
        let size = sides(self.guide.size());
        let (behind, step_px) = thin::taken_out(&self.map, sides(self.size), size);
        self.map = behind;
        let before = self.laid();
        let mut moved = self.moved(&before, job)?;
        thin::put_back(&mut moved, &before, self.at_guide(&step_px), size, self.enlarged, job.cancel)?;
        Ok(moved)
    }

    /// The map at the guide's size, its edges where they are; soft ones become steps.
    fn kept(&self, job: &Job) -> Result<Vec<f32>, Cancelled> {
        let mut kept = self.laid();
        let reach = (RAMP_PX + RAMP_OF_MAP * self.enlarged) as usize;
        if steps::sharpness(&self.map, sides(self.size), reach) < SHARP {
            steps::settle(&mut kept, self.guide, reach, job.cancel)?;
        }
        self.without_speckles(kept, job)
    }

    fn without_speckles(&self, mut map: Vec<f32>, job: &Job) -> Result<Vec<f32>, Cancelled> {
        let least = (self.enlarged * self.enlarged) as usize;
        let difference = |a: usize, b: usize| colour_difference(self.guide, a, b);
        speckles::remove(&mut map, sides(self.guide.size()), least, difference, job.cancel)?;
        Ok(map)
    }
}

/// A map that is larger than its guide at the guide's size. Each pixel takes one of the values under it, no average: a
/// stem that covers a third of the pixel is kept.
fn reduced(map: Vec<f32>, source: Size, guide: Size) -> (Vec<f32>, Size) {
    let target = [0, 1].map(|axis| guide[axis].min(source[axis]));
    if target == source {
        return (map, source);
    }
    let [w, _] = sides(source);
    // Pixels whose centres lie in the target's pixel.
    let under = |i: usize, axis: usize| {
        let (from, to) = (source[axis] as usize, target[axis] as usize);
        let first = |i: usize| (2 * i * from).saturating_sub(to).div_ceil(2 * to).min(from - 1);
        first(i)..first(i + 1).max(first(i) + 1)
    };
    let value = |i: usize| {
        let (x, y) = (i % target[0] as usize, i / target[0] as usize);
        let mut values: Vec<f32> = under(y, 1).flat_map(|y| &map[y * w..][under(x, 0)]).copied().collect();
        let kept = (values.len() * 2 / 3).min(values.len() - 1);
        *values.select_nth_unstable_by(kept, f32::total_cmp).1
    };
    ((0..sides(target).iter().product()).into_par_iter().map(value).collect(), target)
}

/// Lets certain values flow into uncertain ones up to the guide's edges, then sharpens the steps that remain.
fn spread(values: &[f32], certain: &[f32], guide: &View, job: &Job) -> Result<Vec<f32>, Cancelled> {
    let size = sides(guide.size());
    let mut flow: Vec<[f32; 2]> = values.iter().zip(certain).map(|(d, c)| [d * c, *c]).collect();
    let difference = |a: usize, b: usize| colour_difference(guide, a, b);
    let reach = FLOW_SHARE * size[0].max(size[1]) as f32;
    EdgeAware::new(size, reach, difference).smooth(&mut flow, job.cancel)?;
    let mut map: Vec<f32> = flow.iter().map(|[d, c]| d / c).collect();
    sharpen(&mut map, size, job.cancel)?;
    tips::grow(&mut map, guide, job.cancel)?;
    Ok(map)
}

/// Difference of the colours of two pixels, mean of the channels, 0 … 1.
fn colour_difference(guide: &View, a: usize, b: usize) -> f32 {
    let of = |c: usize| f32::from(guide.rgba()[a * 4 + c].abs_diff(guide.rgba()[b * 4 + c]));
    (of(0) + of(1) + of(2)) / (3.0 * 255.0)
}

/// Certainty of each pixel of a map, 0 … 1: low where it changes quickly, compared with the map as a whole, so that
/// a steep floor is not taken for an edge.
fn certainty(map: &[f32], [w, h]: [usize; 2]) -> Vec<f32> {
    let at = |x: usize, y: usize| map[y * w + x];
    let places = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let slope = |(x, y): (usize, usize)| {
        let (l, r) = (x.saturating_sub(1), (x + 1).min(w - 1));
        let (t, b) = (y.saturating_sub(1), (y + 1).min(h - 1));
        ((at(r, y) - at(l, y)).powi(2) + (at(x, b) - at(x, t)).powi(2)).sqrt() / 2.0
    };
    let slopes: Vec<f32> = places.map(slope).collect();
    let half_px = UNCERTAIN_PX.max(STEEPER_THAN_USUAL * median(slopes.clone()));
    slopes.iter().map(|slope| (1.0 / (1.0 + (slope / half_px).powi(2))).powi(2).max(LEAST)).collect()
}

fn median(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Smoothing over a picture's even regions, halted by its edges: the recursive domain transform (Gastal and Oliveira
/// 2011).
pub(crate) struct EdgeAware {
    width: usize,
    /// How much of the pixel on the left flows into a pixel in the first pass.
    across: Vec<f32>,
    /// The same of the pixel above.
    down: Vec<f32>,
}

impl EdgeAware {
    /// For pictures of this size, values reaching as far as `reach` pixels over even colour; `difference` is that of the
    /// colours of two neighbours, mean of the channels, 0 … 1.
    pub(crate) fn new([w, h]: [usize; 2], reach: f32, difference: impl Fn(usize, usize) -> f32 + Sync) -> Self {
        let first_sigma = reach * 3f32.sqrt() * 2f32.powi(PASSES as i32 - 1) / (4f32.powi(PASSES as i32) - 1.0).sqrt();
        let rate = -(2f32.sqrt()) / first_sigma;
        // The distance between two neighbours is 1 on even colour, more over an edge.
        let weight = |a, b| (rate * (1.0 + reach / COLOUR_SIGMA * (difference(a, b) - COLOUR_NOISE).max(0.0))).exp();
        let mut weights = Self { width: w, across: vec![0.0; w * h], down: vec![0.0; w * h] };
        weights.across.par_chunks_mut(w).zip(weights.down.par_chunks_mut(w)).enumerate().for_each(
            |(y, (row, down))| {
                for x in 0..w {
                    let i = y * w + x;
                    row[x] = if x > 0 { weight(i, i - 1) } else { 0.0 };
                    down[x] = if y > 0 { weight(i, i - w) } else { 0.0 };
                }
            },
        );
        weights
    }

    /// Smooths values, `[y, x]`.
    pub(crate) fn smooth<const N: usize>(&self, values: &mut [[f32; N]], cancel: &Cancel) -> Result<(), Cancelled> {
        for pass in 0..PASSES {
            cancel.check()?;
            // Each pass has half the σ of the one before: its weights are their squares.
            let finer = |weight: f32| (0..pass).fold(weight, |weight, _| weight * weight);
            flow_across(values, &self.across, self.width, finer);
            cancel.check()?;
            flow_down(values, &self.down, self.width, finer);
        }
        Ok(())
    }
}

fn blend<const N: usize>(pixel: &mut [f32; N], from: [f32; N], weight: f32) {
    (0..N).for_each(|c| pixel[c] += weight * (from[c] - pixel[c]));
}

/// Left to right and back, row by row. `weights[i]` ties pixel i to the one on its left.
fn flow_across<const N: usize>(
    values: &mut [[f32; N]],
    weights: &[f32],
    width: usize,
    finer: impl Fn(f32) -> f32 + Sync,
) {
    values.par_chunks_mut(width).zip(weights.par_chunks(width)).for_each(|(row, weights)| {
        for x in 1..width {
            let from = row[x - 1];
            blend(&mut row[x], from, finer(weights[x]));
        }
        for x in (1..width).rev() {
            let from = row[x];
            blend(&mut row[x - 1], from, finer(weights[x]));
        }
    });
}

/// Top to bottom and back. `weights[i]` ties pixel i to the one above.
fn flow_down<const N: usize>(values: &mut [[f32; N]], weights: &[f32], width: usize, finer: impl Fn(f32) -> f32) {
    let height = values.len() / width;
    for y in 1..height {
        let (above, row) = values[(y - 1) * width..(y + 1) * width].split_at_mut(width);
        let weights = &weights[y * width..(y + 1) * width];
        row.iter_mut().zip(above).zip(weights).for_each(|((pixel, from), weight)| blend(pixel, *from, finer(*weight)));
    }
    for y in (1..height).rev() {
        let (above, row) = values[(y - 1) * width..(y + 1) * width].split_at_mut(width);
        let weights = &weights[y * width..(y + 1) * width];
        above.iter_mut().zip(row).zip(weights).for_each(|((pixel, from), weight)| blend(pixel, *from, finer(*weight)));
    }
}

/// Turns steep ramps into steps: each steep pixel takes the extreme of its neighbourhood that is nearer to its value.
fn sharpen(map: &mut [f32], [w, h]: [usize; 2], cancel: &Cancel) -> Result<(), Cancelled> {
    for _ in 0..SHARPEN_ROUNDS {
        cancel.check()?;
        let before = map.to_vec();
        map.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
            let rows = [y.saturating_sub(1), y, (y + 1).min(h - 1)].map(|y| &before[y * w..(y + 1) * w]);
            for (x, value) in row.iter_mut().enumerate() {
                let (l, r) = (x.saturating_sub(1), (x + 1).min(w - 1));
                let near = rows.iter().map(|row| row[l].max(row[x]).max(row[r])).fold(f32::MIN, f32::max);
                let far = rows.iter().map(|row| row[l].min(row[x]).min(row[r])).fold(f32::MAX, f32::min);
                if near - far > STEP_PX {
                    *value = if near - *value < *value - far { near } else { far };
                }
            }
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Raster;

    fn guided(map: &DisparityMap, guide: &View) -> DisparityMap {
        to_guide(map, guide, &Job { cancel: &Cancel::default(), sink: &() }).unwrap()
    }

    /// A bright disc before a dark ground, 120×90, and its ray depth blurred to 40×30.
    fn disc() -> (View, DisparityMap, Vec<bool>) {
        let inside = |x: f32, y: f32| (x - 60.0).hypot(y - 45.0) < 25.0;
        let mask: Vec<bool> = (0..120 * 90).map(|i| inside((i % 120) as f32, (i / 120) as f32)).collect();
        let rgba = mask.iter().flat_map(|m| if *m { [210, 190, 60, 255] } else { [40, 70, 50, 255] }).collect();
        let sharp = Raster::from_fn([120, 90], |x, y| if mask[y * 120 + x] { 0.5 } else { -0.3 });
        let soft = sharp.resized([10, 8], Filter::Linear).resized([40, 30], Filter::Linear);
        (View::new([120, 90], rgba).unwrap(), DisparityMap::new([40, 30], soft.into_pixels()).unwrap(), mask)
    }

    #[test]
    fn a_soft_edge_moves_to_the_photos_edge_and_becomes_a_step() {
        let (guide, map, mask) = disc();
        let out = guided(&map, &guide);
        let [lo, hi] = out.range_px();
        let wrong = out.disparity_px().iter().zip(&mask).filter(|(d, m)| (**d > (lo + hi) / 2.0) != **m).count();
        assert!(wrong <= 30, "{wrong} of 10,800 pixels are on the wrong side");
        let between = out.disparity_px().iter().filter(|d| (**d - lo).min(hi - **d) > 0.3 * (hi - lo)).count();
        assert!(between <= 30, "{between} pixels have a depth in between");
    }

    #[test]
    fn a_nets_edge_moves_too_where_its_map_is_little_smaller() {
        let (guide, map, mask) = disc();
        let large = resample::<1>(map.disparity_px(), [40, 30], [80, 60], Filter::Linear);
        let large = DisparityMap::new([80, 60], large).unwrap();
        let wrong = |out: &DisparityMap| {
            let [lo, hi] = out.range_px();
            out.disparity_px().iter().zip(&mask).filter(|(d, m)| (**d > (lo + hi) / 2.0) != **m).count()
        };
        let moved = net_to_guide(&large, &guide, &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
        assert!(wrong(&moved) <= 30, "{} of 10,800 pixels are on the wrong side", wrong(&moved));
        assert_ne!(moved, guided(&large, &guide), "a camera's own map knows where its edges are");
    }

    #[test]
    fn a_slant_without_edges_stays_a_slant() {
        let guide = View::new([120, 90], vec![128; 120 * 90 * 4]).unwrap();
        let slant = |i: usize| (i % 40) as f32 * 0.02;
        let map = DisparityMap::new([40, 30], (0..1200).map(slant).collect()).unwrap();
        let out = guided(&map, &guide);
        for x in 20..100 {
            let want = ((x as f32 + 0.5) / 3.0 - 0.5) * 0.06;
            assert!((out.at(x, 45) - want).abs() < 0.05, "x {x}: {} where {want} was", out.at(x, 45));
        }
    }

    #[test]
    fn a_constant_is_scaled_by_the_ratio_of_widths_and_nothing_else() {
        let (guide, ..) = disc();
        for size in [[40, 30], [120, 90], [240, 180], [1, 1]] {
            let out = guided(&DisparityMap::constant(size, 0.6), &guide);
            let want = 0.6 * 120.0 / size[0] as f32;
            assert!(out.disparity_px().iter().all(|d| (d - want).abs() < 1e-3 * want), "{size:?}");
        }
    }
}
