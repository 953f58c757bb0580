//! Small dense matching, for what an importer must find out by looking: stereo pairs and the layout of views.

mod census;
mod stereo;
#[cfg(test)]
pub(crate) mod tests;

use crate::field::{Filter, Raster, View};

pub(crate) use stereo::stereo;

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
