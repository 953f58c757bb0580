//! Costs of a sweep made to agree with their neighbours: semi-global matching (Hirschmüller 2008).
//!
//! From eight directions a change of plane costs something, a large one more; less where the photo has an edge.

use crate::job::{Cancel, Cancelled};

/// What a change by one plane costs, and a larger one on even colour. Costs of a plane reach 1000.
const SMALL: i16 = 24;
const LARGE: [i16; 2] = [60, 420];
/// Difference of brightness, 0 … 1, at which a large change costs half as much.
const EDGE: f32 = 0.03;
/// More than any sum.
const NEVER: i16 = i16::MAX / 2;

/// Costs of every plane at every pixel, `[y, x, plane]`, 0 … 1000.
pub struct Volume {
    /// Width and height.
    pub sides: [usize; 2],
    /// Planes.
    pub planes: usize,
    /// The costs.
    pub costs: Vec<i16>,
}

impl Volume {
    /// Sums over eight directions, of the volume's shape; `luma` is the photo's brightness.
    ///
    /// # Errors
    /// Cancelled.
    pub fn agreed(&self, luma: &[f32], cancel: &Cancel) -> Result<Vec<i16>, Cancelled> {
        let (down, up) = rayon::join(|| self.half(luma, false, cancel), || self.half(luma, true, cancel));
        let (mut down, up) = (down?, up?);
        down.iter_mut().zip(up).for_each(|(a, b)| *a = a.saturating_add(b));
        Ok(down)
    }

    /// The four directions that come from the rows above and from the left, or from below and the right.
    fn half(&self, luma: &[f32], turned: bool, cancel: &Cancel) -> Result<Vec<i16>, Cancelled> {
        let ([w, h], n) = (self.sides, self.planes);
        let stride = n + 2;
        let place = |x: usize, y: usize| if turned { (h - 1 - y) * w + (w - 1 - x) } else { y * w + x };
        let large = |a: usize, b: usize| {
            let step = (luma[a] - luma[b]).abs() / EDGE;
            (f32::from(LARGE[1]) / (1.0 + step)).max(f32::from(LARGE[0])) as i16
        };
        let mut sums = vec![0i16; self.costs.len()];
        // Of the row before: for the three directions that come from it.
        let mut before = vec![[vec![0i16; w * stride], vec![0i16; w * stride], vec![0i16; w * stride]]; 2];
        let mut left = [vec![0i16; stride], vec![0i16; stride]];
        for y in 0..h {
            cancel.check()?;
            let (old, new) = before.split_at_mut(1);
            let (old, new) = if y % 2 == 0 { (&old[0], &mut new[0]) } else { (&new[0], &mut old[0]) };
            for x in 0..w {
                let at = place(x, y);
                let costs = &self.costs[at * n..(at + 1) * n];
                let sum = &mut sums[at * n..(at + 1) * n];
                let (was, now) = left.split_at_mut(1);
                let (was, now) = if x % 2 == 0 { (&was[0], &mut now[0]) } else { (&now[0], &mut was[0]) };
                let from = (x > 0).then(|| (&was[..], large(at, place(x.max(1) - 1, y))));
                path(costs, from, now, sum);
                for (direction, dx) in [-1i32, 0, 1].into_iter().enumerate() {
                    let px = x as i32 + dx;
                    let inside = y > 0 && px >= 0 && px < w as i32;
                    let from = inside.then(|| {
                        let px = px as usize;
                        (&old[direction][px * stride..(px + 1) * stride], large(at, place(px, y - 1)))
                    });
                    path(costs, from, &mut new[direction][x * stride..(x + 1) * stride], sum);
                }
            }
        }
        Ok(sums)
    }
}

/// One step along a path. A path's costs have a border on both sides.
#[inline]
fn path(costs: &[i16], from: Option<(&[i16], i16)>, to: &mut [i16], sum: &mut [i16]) {
    let n = costs.len();
    match from {
        None => to[1..=n].copy_from_slice(costs),
        Some((from, large)) => {
            let least = from[1..=n].iter().copied().fold(NEVER, i16::min);
            let jump = least.saturating_add(large);
            for i in 0..n {
                let beside = from[i].min(from[i + 2]).saturating_add(SMALL);
                to[i + 1] = costs[i] + from[i + 1].min(beside).min(jump) - least;
            }
        }
    }
    (to[0], to[n + 1]) = (NEVER, NEVER);
    sum.iter_mut().zip(&to[1..=n]).for_each(|(sum, path)| *sum = sum.saturating_add(*path));
}
