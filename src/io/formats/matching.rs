//! Small dense matching, for what an importer must find out by looking: stereo pairs and the layout of views.

use rayon::prelude::*;

use crate::field::{RelativeDepth, View, bilinear};

/// A grey picture.
///
/// # Shapes
/// - `values`: `[y, x]`, 0 … 1
#[derive(Clone, Debug)]
pub(crate) struct Gray {
    pub(crate) size: [u32; 2],
    pub(crate) values: Vec<f32>,
}

/// Width at which stereo pairs are matched.
const STEREO_WIDTH: u32 = 320;
/// Shifts that are tried, as shares of the width: a spatial photo's pair may be shifted against itself.
const STEREO_RANGE: [f32; 2] = [-0.08, 0.12];
/// Half the side of the window over which costs are averaged.
const WINDOW: usize = 4;

impl Gray {
    /// A view's green-ish luma, brought to a width by averaging.
    pub(crate) fn from_view(view: &View, width: u32) -> Self {
        let luma = |px: &[u8]| (0.3 * f32::from(px[0]) + 0.6 * f32::from(px[1]) + 0.1 * f32::from(px[2])) / 255.0;
        Self { size: view.size(), values: view.rgba().chunks_exact(4).map(luma).collect() }.fit_width(width)
    }

    /// Averages boxes of pixels until the picture is at most `width` wide.
    pub(crate) fn fit_width(&self, width: u32) -> Self {
        let [w, h] = self.size;
        if w <= width {
            return self.clone();
        }
        let height = ((f64::from(h) * f64::from(width) / f64::from(w)).round() as u32).max(1);
        let edge = |n: u32, of: u32, side: u32| (u64::from(n) * u64::from(side) / u64::from(of)) as usize;
        let mut values = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            let rows = edge(y, height, h)..edge(y + 1, height, h).max(edge(y, height, h) + 1);
            for x in 0..width {
                let cols = edge(x, width, w)..edge(x + 1, width, w).max(edge(x, width, w) + 1);
                let count = (rows.len() * cols.len()) as f32;
                let sum: f32 =
                    rows.clone().map(|row| self.values[row * w as usize..][cols.clone()].iter().sum::<f32>()).sum();
                values.push(sum / count);
            }
        }
        Self { size: [width, height], values }
    }

    /// The value at a place, linear between pixels, edges go on.
    pub(crate) fn tap(&self, x: f32, y: f32) -> f32 {
        bilinear(self.size.map(|side| side as usize), x, y, |i| self.values[i])
    }
}

/// Mean over a window of `2 · half + 1` pixels a side; windows are cut at the edges.
pub(crate) fn box_mean(values: &[f32], [w, h]: [u32; 2], half: usize) -> Vec<f32> {
    let (w, h) = (w as usize, h as usize);
    let along = |line: &mut dyn FnMut(usize) -> f32, n: usize, out: &mut dyn FnMut(usize, f32)| {
        let mut sums = vec![0.0f64; n + 1];
        (0..n).for_each(|i| sums[i + 1] = sums[i] + f64::from(line(i)));
        for i in 0..n {
            let (lo, hi) = (i.saturating_sub(half), (i + half + 1).min(n));
            out(i, ((sums[hi] - sums[lo]) / (hi - lo) as f64) as f32);
        }
    };
    let mut rows = vec![0.0; w * h];
    for y in 0..h {
        along(&mut |x| values[y * w + x], w, &mut |x, mean| rows[y * w + x] = mean);
    }
    let mut out = vec![0.0; w * h];
    for x in 0..w {
        along(&mut |y| rows[y * w + x], h, &mut |y, mean| out[y * w + x] = mean);
    }
    out
}

/// Shift of every pixel of `from` in `to`: `from(x) = to(x + sign · d)`, larger `d` is nearer. None where the pictures
/// do not match at all.
pub(crate) fn stereo(from: &Gray, to: &Gray, sign: f32) -> Option<RelativeDepth> {
    let (from, to) = (from.fit_width(STEREO_WIDTH), to.fit_width(STEREO_WIDTH));
    if from.size != to.size {
        return None;
    }
    let [w, h] = from.size;
    let first = (STEREO_RANGE[0] * w as f32) as i32;
    let last = (STEREO_RANGE[1] * w as f32) as i32;
    let costs: Vec<(f32, Vec<f32>)> = (first..=last)
        .into_par_iter()
        .map(|d| {
            let d = d as f32;
            let cost = |at: usize| {
                let (x, y) = ((at as u32 % w) as f32, (at as u32 / w) as f32);
                (from.values[at] - to.tap(x + sign * d, y)).abs().min(0.1)
            };
            let raw: Vec<f32> = (0..(w * h) as usize).map(cost).collect();
            (d, box_mean(&raw, [w, h], WINDOW))
        })
        .collect();
    let best =
        |at: usize| costs.iter().map(|(d, cost)| (*d, cost[at])).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
    let found: Vec<(f32, f32)> = (0..(w * h) as usize).map(best).collect();
    let mean = found.iter().map(|(_, cost)| cost).sum::<f32>() / found.len() as f32;
    let map: Vec<f32> = found.into_iter().map(|(d, _)| d).collect();
    if mean < 0.05 { RelativeDepth::new([w, h], median(&median(&map, [w, h]), [w, h])).ok() } else { None }
}

/// The middle value of 5×5 pixels, edges go on.
fn median(values: &[f32], [w, h]: [u32; 2]) -> Vec<f32> {
    let at = |x: i64, y: i64| {
        values[y.clamp(0, i64::from(h) - 1) as usize * w as usize + x.clamp(0, i64::from(w) - 1) as usize]
    };
    (0..values.len())
        .into_par_iter()
        .map(|n| {
            let (x, y) = ((n % w as usize) as i64, (n / w as usize) as i64);
            let mut window: [f32; 25] = std::array::from_fn(|k| at(x + k as i64 % 5 - 2, y + k as i64 / 5 - 2));
            *window.select_nth_unstable_by(12, f32::total_cmp).1
        })
        .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Blotchy texture at any place: sums of a few waves.
    pub(crate) fn texture(x: f32, y: f32) -> f32 {
        let wave = |fx: f32, fy: f32, phase: f32| (x * fx + y * fy + phase).sin();
        0.5 + 0.12 * (wave(0.31, 0.17, 0.3) + wave(-0.23, 0.41, 1.7) + wave(0.53, -0.29, 2.1) + wave(0.11, 0.07, 0.9))
    }

    #[test]
    fn a_near_square_stands_out_with_the_right_sign() {
        let (w, h) = (160, 120);
        let inside = |x: i32, y: i32| (60..100).contains(&x) && (40..80).contains(&y);
        // The left eye's picture; in the right eye's one the square has moved 6 px to the left, the rest 1 px.
        let paint = |shift: [f32; 2]| Gray {
            size: [w, h],
            values: (0..w * h)
                .map(|n| {
                    let (x, y) = ((n % w) as f32, (n / w) as f32);
                    let near = inside((x + shift[0]) as i32, y as i32);
                    if near { texture(x + shift[0], y + 500.0) } else { texture(x + shift[1], y) }
                })
                .collect(),
        };
        let (left, right) = (paint([0.0, 0.0]), paint([6.0, 1.0]));
        let at = |map: &RelativeDepth, x: usize, y: usize| map.nearness()[y * w as usize + x];
        let map = stereo(&left, &right, -1.0).unwrap();
        assert_eq!((at(&map, 80, 60), at(&map, 30, 100)), (6.0, 1.0));
        let back = stereo(&right, &left, 1.0).unwrap();
        assert_eq!((at(&back, 74, 60), at(&back, 130, 100)), (6.0, 1.0));
    }
}
