//! How badly the views agree at a disparity.

use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;

use super::shift::{MARGIN, Padded, Shift};
use crate::field::{Filter, LightField, Size, ViewIndex, ViewOffset};
use crate::job::{Cancel, Cancelled};
use crate::synth::picture::Signed;
use crate::synth::upsample::EdgeAware;

/// Share of the colours in a cost; the rest are gradients, which a view's own brightness does not move.
const COLOUR_SHARE: f32 = 0.4;
/// Differences of colour (mean of the channels, 0 … 1) and of gradients beyond these are of something else.
const MOST_COLOUR: f32 = 0.10;
const MOST_GRADIENT: f32 = 0.04;
/// Least brightness (0 … 1) that a view is brightened from.
const DARKEST: f32 = 0.005;

/// Red, green, blue, and the gradient of their mean downwards.
const PLANES: usize = 4;

/// Some views of a light field at one size, with one of them that they are compared with.
pub(super) struct Views {
    pub(super) reference: Signed,
    own: Own,
    others: Vec<Other>,
    edges: EdgeAware,
}

/// What the reference view has at each pixel: colours, and both gradients.
struct Own {
    planes: [Vec<f32>; PLANES],
    across: Vec<f32>,
}

struct Other {
    offset: ViewOffset,
    planes: [Padded; PLANES],
}

impl Views {
    /// `chosen` of a field's views beside `reference`, at a size; disparities up to `widest_px` will be looked at, and
    /// agreement flows over `reach` pixels of even colour.
    pub(super) fn new(
        field: &LightField,
        (reference, chosen): (ViewIndex, &[ViewIndex]),
        size: Size,
        widest_px: f32,
        reach: f32,
    ) -> Self {
        let (grid, resized) = (field.grid(), |at| Signed::resized(field.view(at), size, Filter::Lanczos3));
        let zero = grid.offset(reference);
        let (reference, sides) = (resized(reference), crate::field::sides(size));
        let other = |at: &ViewIndex| {
            let offset = grid.offset(*at);
            let offset = ViewOffset { du: offset.du - zero.du, dv: offset.dv - zero.dv };
            let margin = (offset.du.abs().max(offset.dv.abs()) * widest_px).ceil() as usize + MARGIN;
            let planes = planes(&balanced(resized(*at), &reference));
            Other { offset, planes: planes.map(|plane| Padded::new(&plane, sides, margin)) }
        };
        let others = chosen.par_iter().map(other).collect();
        let difference = |a: usize, b: usize| (reference.pixels()[a] - reference.pixels()[b]).abs().element_sum() / 6.0;
        let edges = EdgeAware::new(sides, reach, difference);
        let planes = planes(&reference);
        let mut across = vec![0.0; planes[0].len()];
        let mut luma = vec![0.0; sides[0]];
        for (y, across) in across.chunks_exact_mut(sides[0]).enumerate() {
            let row = |c: usize| &planes[c][y * sides[0]..][..sides[0]];
            mean_of(row(0), row(1), row(2), &mut luma);
            gradient(&luma, across);
        }
        Self { own: Own { planes, across }, reference, others, edges }
    }

    /// Steps to the farthest view.
    pub(super) fn reach_steps(&self) -> f32 {
        self.others.iter().map(|other| other.offset.du.abs().max(other.offset.dv.abs())).fold(1.0, f32::max)
    }

    /// How badly the views agree with the reference view at disparity `d`, `[y, x]`, smoothed over even colour.
    pub(super) fn cost(&self, d: f32, cancel: &Cancel) -> Result<Vec<f32>, Cancelled> {
        let [w, h] = self.reference.sides();
        // view[y, x] = reference[y + v·d, x + u·d], so the reference's pixel p is the view's p − u·d.
        let shifts: Vec<Shift> =
            self.others.iter().map(|other| Shift::new(-other.offset.du * d, -other.offset.dv * d)).collect();
        let mut rows = Rows::new(w, self.others.iter().map(|other| other.planes[0].stride()).max().unwrap_or(w));
        let mut cost = Vec::with_capacity(w * h);
        for y in 0..h {
            if y % 64 == 0 {
                cancel.check()?;
            }
            rows.clear();
            for (other, shift) in self.others.iter().zip(&shifts) {
                rows.see(other, shift, y);
                rows.compare(&self.own, other.offset, y * w..(y + 1) * w);
            }
            cost.extend(rows.least());
        }
        self.edges.smooth(cost.as_chunks_mut::<1>().0, cancel)?;
        Ok(cost)
    }
}

/// One row of a view as the reference view would see it, and what its pixels cost.
struct Rows {
    between: Vec<f32>,
    seen: [Vec<f32>; PLANES],
    luma: Vec<f32>,
    across: Vec<f32>,
    /// Costs of the views on the left, on the right, above, below; each with the number of views.
    halves: [(Vec<f32>, f32); 4],
}

impl Rows {
    fn new(w: usize, stride: usize) -> Self {
        let row = || vec![0.0; w];
        let halves = [(); 4].map(|()| (row(), 0.0));
        Self { between: vec![0.0; stride], seen: [(); PLANES].map(|()| row()), luma: row(), across: row(), halves }
    }

    fn clear(&mut self) {
        for (costs, views) in &mut self.halves {
            costs.fill(0.0);
            *views = 0.0;
        }
    }

    fn see(&mut self, other: &Other, shift: &Shift, y: usize) {
        for (plane, seen) in other.planes.iter().zip(&mut self.seen) {
            shift.row(plane, y, &mut self.between[..plane.stride()], seen);
        }
        let [r, g, b, _] = &self.seen;
        mean_of(r, g, b, &mut self.luma);
        gradient(&self.luma, &mut self.across);
    }

    /// Adds what a view costs. Its gradients count along the way to it: across it, a shift changes nothing.
    fn compare(&mut self, own: &Own, offset: ViewOffset, row: std::ops::Range<usize>) {
        let sideways = offset.du.abs() / (offset.du.abs() + offset.dv.abs()).max(1e-6);
        let (of_across, of_down) = ((1.0 - COLOUR_SHARE) * sideways, (1.0 - COLOUR_SHARE) * (1.0 - sideways));
        let [r, g, b, down] = [0, 1, 2, 3].map(|c| &own.planes[c][row.clone()]);
        let across = &own.across[row];
        let [seen_r, seen_g, seen_b, seen_down] = &self.seen;
        let costs = &mut self.luma;
        for x in 0..costs.len() {
            let colour = ((seen_r[x] - r[x]).abs() + (seen_g[x] - g[x]).abs() + (seen_b[x] - b[x]).abs()) / 3.0;
            costs[x] = COLOUR_SHARE * colour.min(MOST_COLOUR)
                + of_across * (self.across[x] - across[x]).abs().min(MOST_GRADIENT)
                + of_down * (seen_down[x] - down[x]).abs().min(MOST_GRADIENT);
        }
        let sides = [offset.du <= 0.0, offset.du >= 0.0, offset.dv <= 0.0, offset.dv >= 0.0];
        for ((half, views), _) in self.halves.iter_mut().zip(sides).filter(|(_, inside)| *inside) {
            half.iter_mut().zip(&*costs).for_each(|(half, cost)| *half += cost);
            *views += 1.0;
        }
    }

    /// Beside an edge half of the views see something else: the half that agrees best counts.
    fn least(&self) -> impl Iterator<Item = f32> {
        // One view alone agrees with many a wrong place.
        let enough = self.halves.iter().map(|(_, views)| *views).fold(0.0, f32::max).clamp(1.0, 2.0);
        let counted = self.halves.iter().filter(|(_, views)| *views >= enough);
        let halves: Vec<_> = counted.map(|(costs, views)| (&costs[..], 1.0 / views)).collect();
        (0..self.luma.len()).map(move |x| {
            let least = halves.iter().map(|(costs, share)| costs[x] * share).fold(f32::MAX, f32::min);
            if least == f32::MAX { 0.0 } else { least }
        })
    }
}

/// A view made as bright as the reference view on average: the outer views of a plenoptic camera are darker, and even
/// surfaces would be matched by their shading.
fn balanced(view: Signed, reference: &Signed) -> Signed {
    let mean = |of: &Signed| of.pixels().iter().map(|pixel| pixel.xyz() + 1.0).sum::<Vec3>() / of.pixels().len() as f32;
    let gain = mean(reference) / mean(&view).max(Vec3::splat(2.0 * DARKEST));
    view.map(|pixel| ((pixel.xyz() + 1.0) * gain - 1.0).extend(0.0))
}

/// Colours in 0 … 1 and the gradient downwards of their mean.
fn planes(picture: &Signed) -> [Vec<f32>; PLANES] {
    let [w, h] = picture.sides();
    let colour = |c: usize| picture.pixels().iter().map(|pixel| 0.5 * (pixel[c] + 1.0)).collect::<Vec<_>>();
    let [r, g, b] = [colour(0), colour(1), colour(2)];
    let luma = |x: usize, y: usize| (r[y * w + x] + g[y * w + x] + b[y * w + x]) / 3.0;
    let down = |i: usize| 0.5 * (luma(i % w, (i / w + 1).min(h - 1)) - luma(i % w, (i / w).saturating_sub(1)));
    let down = (0..w * h).map(down).collect();
    [r, g, b, down]
}

fn mean_of(r: &[f32], g: &[f32], b: &[f32], mean: &mut [f32]) {
    for x in 0..mean.len() {
        mean[x] = (r[x] + g[x] + b[x]) / 3.0;
    }
}

/// Central differences along a row.
fn gradient(row: &[f32], out: &mut [f32]) {
    let last = row.len() - 1;
    for x in 1..last {
        out[x] = 0.5 * (row[x + 1] - row[x - 1]);
    }
    out[0] = 0.5 * (row[last.min(1)] - row[0]);
    out[last] = 0.5 * (row[last] - row[last.saturating_sub(1)]);
}
