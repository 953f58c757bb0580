//! Small dense matching, for what an importer must find out by looking: stereo pairs and the layout of views.

use rayon::prelude::*;

use crate::field::{Filter, Raster, RelativeDepth, View};

/// Width at which stereo pairs are matched.
const STEREO_WIDTH: u32 = 320;
/// Shifts that are tried, as shares of the width: a spatial photo's pair may be shifted against itself.
const STEREO_RANGE: [f32; 2] = [-0.08, 0.12];
/// Half the side of the window over which costs are averaged.
const WINDOW: usize = 4;

/// A view's green-ish luma, 0 … 1, brought to a width by averaging.
pub(crate) fn gray(view: &View, width: u32) -> Raster<f32> {
    let luma = |[r, g, b, _]: [u8; 4]| (0.3 * f32::from(r) + 0.6 * f32::from(g) + 0.1 * f32::from(b)) / 255.0;
    fit_width(view.map(luma), width)
}

/// A grey picture at most `width` wide, by averaging.
fn fit_width(picture: Raster<f32>, width: u32) -> Raster<f32> {
    let [w, h] = picture.size();
    let height = ((f64::from(h) * f64::from(width) / f64::from(w)).round() as u32).max(1);
    if w <= width { picture } else { picture.resized([width, height], Filter::Area) }
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
pub(crate) fn stereo(from: Raster<f32>, to: Raster<f32>, sign: f32) -> Option<RelativeDepth> {
    let (from, to) = (fit_width(from, STEREO_WIDTH), fit_width(to, STEREO_WIDTH));
    if from.size() != to.size() {
        return None;
    }
    let [w, h] = from.size();
    let first = (STEREO_RANGE[0] * w as f32) as i32;
    let last = (STEREO_RANGE[1] * w as f32) as i32;
    let costs: Vec<(f32, Vec<f32>)> = (first..=last)
        .into_par_iter()
        .map(|d| {
            let d = d as f32;
            let cost = |at: usize| {
                let (x, y) = ((at as u32 % w) as f32, (at as u32 / w) as f32);
                (from.pixels()[at] - to.tap(x + sign * d, y)).abs().min(0.1)
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
        let paint = |shift: [f32; 2]| {
            Raster::from_fn([w, h], |x, y| {
                let (x, y) = (x as f32, y as f32);
                let near = inside((x + shift[0]) as i32, y as i32);
                if near { texture(x + shift[0], y + 500.0) } else { texture(x + shift[1], y) }
            })
        };
        let (left, right) = (paint([0.0, 0.0]), paint([6.0, 1.0]));
        let at = |map: &RelativeDepth, x: usize, y: usize| map.nearness()[y * w as usize + x];
        let map = stereo(left.clone(), right.clone(), -1.0).unwrap();
        assert_eq!((at(&map, 80, 60), at(&map, 30, 100)), (6.0, 1.0));
        let back = stereo(right, left, 1.0).unwrap();
        assert_eq!((at(&back, 74, 60), at(&back, 130, 100)), (6.0, 1.0));
    }
}
