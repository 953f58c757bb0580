//! Which of many labels each pixel has, its neighbours heard: semi-global matching (Hirschmüller 2008).
//!
//! Along eight directions a pixel's cost is its own and the least of what led to it, where another label than the
//! neighbour's costs more. Little more for the next one, so that surfaces may lean; much for any other, less where the
//! colour changes, so that depth breaks at edges. Labels are disparities or inverse depths; who asks knows.

use crate::job::{Cancel, Cancelled};

/// What a label costs: as fine as 32-bit floats, or in half the memory and time as 16-bit integers.
pub trait Cost: Copy + Default + PartialOrd + Send + Sync {
    /// More than any sum.
    const NEVER: Self;
    /// The sum, at most [`Self::NEVER`].
    fn plus(self, other: Self) -> Self;
    /// The difference.
    fn minus(self, other: Self) -> Self;
    /// The smaller one.
    fn least(self, other: Self) -> Self;
}

impl Cost for f32 {
    const NEVER: Self = f32::MAX;
    fn plus(self, other: Self) -> Self {
        self + other
    }
    fn minus(self, other: Self) -> Self {
        self - other
    }
    fn least(self, other: Self) -> Self {
        self.min(other)
    }
}

impl Cost for i16 {
    const NEVER: Self = i16::MAX / 2;
    fn plus(self, other: Self) -> Self {
        self.saturating_add(other)
    }
    fn minus(self, other: Self) -> Self {
        self - other
    }
    fn least(self, other: Self) -> Self {
        self.min(other)
    }
}

/// Costs `[y, x, label]`.
pub struct Volume<C> {
    /// Width and height.
    pub sides: [usize; 2],
    /// Labels a pixel.
    pub labels: usize,
    /// The costs.
    pub costs: Vec<C>,
}

/// What a change of label costs from one pixel to the next.
pub struct Changes<C, F> {
    /// The next label.
    pub next: C,
    /// Any other, between two pixels.
    pub other: F,
}

impl<C: Cost> Volume<C> {
    /// From costs by label, each `[y, x]`.
    #[must_use]
    pub fn of_planes(sides: [usize; 2], planes: &[Vec<C>]) -> Self {
        let (labels, pixels) = (planes.len(), sides[0] * sides[1]);
        let mut costs = Vec::with_capacity(labels * pixels);
        (0..pixels).for_each(|i| costs.extend(planes.iter().map(|plane| plane[i])));
        Self { sides, labels, costs }
    }

    /// The costs of a pixel.
    #[must_use]
    pub fn of(&self, pixel: usize) -> &[C] {
        &self.costs[pixel * self.labels..][..self.labels]
    }

    /// The sum over [`DIRECTIONS`] directions of the least ways to each label of each pixel.
    ///
    /// # Errors
    /// Cancelled.
    pub fn heard(
        &self,
        changes: &Changes<C, impl Fn(usize, usize) -> C + Sync>,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let (down, up) = rayon::join(|| self.swept(false, changes, cancel), || self.swept(true, changes, cancel));
        let (mut costs, up) = (down?, up?);
        costs.iter_mut().zip(up).for_each(|(d, u)| *d = d.plus(u));
        Ok(Self { sides: self.sides, labels: self.labels, costs })
    }

    /// The sum over the directions that come from before each pixel, rows from the top; `back` = from the other end.
    fn swept(
        &self,
        back: bool,
        changes: &Changes<C, impl Fn(usize, usize) -> C>,
        cancel: &Cancel,
    ) -> Result<Vec<C>, Cancelled> {
        let ([w, h], n) = (self.sides, self.labels);
        // A path's costs have a border on both sides, so that every label has two neighbours.
        let stride = n + 2;
        let mut sums = vec![C::default(); self.costs.len()];
        let mut rows = [(); 2].map(|()| vec![C::NEVER; STEPS.len() * w * stride]);
        let pixel_of = |x: usize, y: usize| if back { (h - 1 - y) * w + (w - 1 - x) } else { y * w + x };
        for y in 0..h {
            cancel.check()?;
            let [before, here] = &mut rows;
            for x in 0..w {
                let pixel = pixel_of(x, y);
                let (own, sum) = (self.of(pixel), &mut sums[pixel * n..][..n]);
                for (direction, (dx, dy)) in STEPS.into_iter().enumerate() {
                    let from = (x.checked_add_signed(dx).filter(|x| *x < w)).zip(y.checked_sub(dy));
                    let (done, rest) = here.split_at_mut((direction * w + x) * stride);
                    let to = &mut rest[..stride];
                    let Some((fx, fy)) = from else {
                        to[1..=n].copy_from_slice(own);
                        add(sum, own);
                        continue;
                    };
                    let previous = (direction * w + fx) * stride;
                    let led = if dy == 0 { &done[previous..][..stride] } else { &before[previous..][..stride] };
                    let other = (changes.other)(pixel, pixel_of(fx, fy));
                    step(own, led, [changes.next.least(other), other], to);
                    add(sum, &to[1..=n]);
                }
            }
            rows.swap(0, 1);
        }
        Ok(sums)
    }
}

/// From the left, from above, and from both sides above: where the neighbour lies, `x` and rows before.
const STEPS: [(isize, usize); 4] = [(-1, 0), (0, 1), (-1, 1), (1, 1)];
/// Directions that a pixel hears: these and their opposites.
pub const DIRECTIONS: usize = 2 * STEPS.len();

/// One pixel of a path: its own costs and the least way to each from the costs of the pixel before.
#[inline]
fn step<C: Cost>(own: &[C], before: &[C], [next, other]: [C; 2], to: &mut [C]) {
    let n = own.len();
    let least = before[1..=n].iter().copied().fold(C::NEVER, C::least);
    let jump = least.plus(other);
    for i in 0..n {
        let beside = before[i].least(before[i + 2]).plus(next);
        to[i + 1] = own[i].plus(before[i + 1].least(beside).least(jump)).minus(least);
    }
}

#[inline]
fn add<C: Cost>(sum: &mut [C], path: &[C]) {
    sum.iter_mut().zip(path).for_each(|(sum, path)| *sum = sum.plus(*path));
}

/// The first label of least cost, and where beside it, −½ … ½, the parabola through its neighbours is lowest.
#[must_use]
pub fn lowest<C: Cost + Into<f32>>(costs: &[C]) -> (usize, f32) {
    let at = (1..costs.len()).fold(0, |least, i| if costs[i] < costs[least] { i } else { least });
    if at == 0 || at + 1 >= costs.len() {
        return (at, 0.0);
    }
    let [before, here, after]: [f32; 3] = [at - 1, at, at + 1].map(|i| costs[i].into());
    let bend = before - 2.0 * here + after;
    (at, if bend > 1e-9 { ((before - after) / (2.0 * bend)).clamp(-0.5, 0.5) } else { 0.0 })
}
