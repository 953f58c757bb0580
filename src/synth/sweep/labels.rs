//! Which of many disparities each pixel has, its neighbours heard.
//!
//! Semi-global matching (Hirschmüller 2008): along eight directions, a pixel's cost is its own and the least of what led to
//! it, where another disparity than the neighbour's costs more. Little more for the next one, so that surfaces may lean;
//! much for any other, less where the colour changes, so that depth breaks at edges.

use crate::job::{Cancel, Cancelled};

/// What the next disparity costs, and what any other does where no colour changes.
const NEXT: f32 = 0.003;
const OTHER: f32 = 0.015;
/// A change of colour (mean of the channels, 0 … 1) at which a break costs half as much.
const HALVING: f32 = 0.02;

/// Costs `[y, x, label]`.
pub(super) struct Volume {
    sides: [usize; 2],
    labels: usize,
    costs: Vec<f32>,
}

impl Volume {
    /// From costs by label, each `[y, x]`.
    pub(super) fn new(sides: [usize; 2], planes: &[Vec<f32>]) -> Self {
        let (labels, pixels) = (planes.len(), sides[0] * sides[1]);
        let mut costs = Vec::with_capacity(labels * pixels);
        (0..pixels).for_each(|i| costs.extend(planes.iter().map(|plane| plane[i])));
        Self { sides, labels, costs }
    }

    /// The costs of a pixel.
    pub(super) fn of(&self, pixel: usize) -> &[f32] {
        &self.costs[pixel * self.labels..][..self.labels]
    }

    /// The same with the neighbours' say; `difference` is that of the colours of two pixels, 0 … 1.
    pub(super) fn heard(
        &self,
        difference: impl Fn(usize, usize) -> f32 + Sync,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let (down, up) =
            rayon::join(|| self.swept(false, &difference, cancel), || self.swept(true, &difference, cancel));
        let (mut down, up) = (down?, up?);
        down.iter_mut().zip(up).for_each(|(d, u)| *d = (*d + u) / (2 * DIRECTIONS) as f32);
        Ok(Self { sides: self.sides, labels: self.labels, costs: down })
    }

    /// The sum over the directions that come from before each pixel, rows from the top; `back` = from the other end.
    fn swept(
        &self,
        back: bool,
        difference: &(impl Fn(usize, usize) -> f32 + Sync),
        cancel: &Cancel,
    ) -> Result<Vec<f32>, Cancelled> {
        let ([w, h], n) = (self.sides, self.labels);
        let mut sums = vec![0.0; self.costs.len()];
        let mut rows = [(); 2].map(|()| vec![0.0; DIRECTIONS * w * n]);
        let pixel_of = |x: usize, y: usize| if back { (h - 1 - y) * w + (w - 1 - x) } else { y * w + x };
        for y in 0..h {
            cancel.check()?;
            let [before, here] = &mut rows;
            for x in 0..w {
                let pixel = pixel_of(x, y);
                let (own, sum) = (self.of(pixel), &mut sums[pixel * n..][..n]);
                for (direction, (dx, dy)) in STEPS.into_iter().enumerate() {
                    let from = (x.checked_add_signed(dx).filter(|x| *x < w)).zip(y.checked_sub(dy));
                    let start = (direction * w + x) * n;
                    let Some((fx, fy)) = from else {
                        here[start..start + n].copy_from_slice(own);
                        sum.iter_mut().zip(own).for_each(|(s, o)| *s += o);
                        continue;
                    };
                    let breaks = OTHER / (1.0 + difference(pixel, pixel_of(fx, fy)) / HALVING);
                    let previous = (direction * w + fx) * n;
                    if dy == 0 {
                        let (done, rest) = here.split_at_mut(start);
                        step(own, &done[previous..previous + n], breaks, &mut rest[..n], sum);
                    } else {
                        step(own, &before[previous..previous + n], breaks, &mut here[start..start + n], sum);
                    }
                }
            }
            rows.swap(0, 1);
        }
        Ok(sums)
    }
}

/// Directions that a pixel hears in one sweep.
const DIRECTIONS: usize = 4;
/// From the left, from above, and from both sides above: where the neighbour lies, `x` and rows before.
const STEPS: [(isize, usize); DIRECTIONS] = [(-1, 0), (0, 1), (-1, 1), (1, 1)];

/// One pixel of a path: its own costs and the least way to each from the costs of the pixel before.
fn step(own: &[f32], before: &[f32], breaks: f32, path: &mut [f32], sum: &mut [f32]) {
    let least = before.iter().copied().fold(f32::MAX, f32::min);
    let (next, last) = (NEXT.min(breaks), own.len() - 1);
    for l in 0..own.len() {
        let beside = before[l.saturating_sub(1)].min(before[(l + 1).min(last)]) + next;
        path[l] = own[l] + before[l].min(beside).min(least + breaks) - least;
        sum[l] += path[l];
    }
}

/// The label of least cost, between labels by a parabola.
pub(super) fn best(costs: &[f32]) -> f32 {
    let at = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or_default();
    let inside = at > 0 && at + 1 < costs.len();
    at as f32 + if inside { valley(costs[at - 1], costs[at], costs[at + 1]) } else { 0.0 }
}

/// Where between −½ and ½ the parabola through three costs is lowest.
fn valley(before: f32, here: f32, after: f32) -> f32 {
    let bend = before - 2.0 * here + after;
    if bend > 1e-9 { ((before - after) / (2.0 * bend)).clamp(-0.5, 0.5) } else { 0.0 }
}
