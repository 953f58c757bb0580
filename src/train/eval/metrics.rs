//! Differences between pictures and between depth maps. Pictures are sRGB 0 … 1.

use crate::scenes::raster::{Raster, Rgb};

pub use plenoscope::field::{correlation, spearman};

/// Mean absolute difference over pixels and channels; in −1 … 1 it is twice that.
pub fn l1(a: &Rgb, b: &Rgb) -> f32 {
    l1_where(a, b, |_| true).unwrap_or(0.0)
}

/// The same over the pixels that are wanted; none where there are none.
pub fn l1_where(a: &Rgb, b: &Rgb, wanted: impl Fn(usize) -> bool) -> Option<f32> {
    let (mut sum, mut count) = (0.0f64, 0u64);
    for (i, (p, q)) in a.px.iter().zip(&b.px).enumerate().filter(|(i, _)| wanted(*i)) {
        debug_assert!(i < a.px.len());
        sum += f64::from((0..3).map(|c| (p[c] - q[c]).abs()).sum::<f32>());
        count += 3;
    }
    (count > 0).then(|| (sum / count as f64) as f32)
}

/// Peak signal-to-noise ratio in dB; 100 for equal pictures.
pub fn psnr(a: &Rgb, b: &Rgb) -> f32 {
    let square = |(p, q): (&[f32; 3], &[f32; 3])| (0..3).map(|c| f64::from(p[c] - q[c]).powi(2)).sum::<f64>();
    let mse = a.px.iter().zip(&b.px).map(square).sum::<f64>() / (3 * a.px.len()) as f64;
    if mse <= 1e-10 { 100.0 } else { (-10.0 * mse.log10()) as f32 }
}

/// Structural similarity of the luma (Wang et al. 2004): gaussian window of 11 × 11, σ 1.5, K 0.01 and 0.03.
pub fn ssim(a: &Rgb, b: &Rgb) -> f32 {
    // Around the middle grey, so that variances do not drown in the rounding of squares.
    let luma = |texel: &[f32; 3]| 0.299 * texel[0] + 0.587 * texel[1] + 0.114 * texel[2] - 0.5;
    let moments = a.px.iter().zip(&b.px).map(|(p, q)| {
        let (x, y) = (luma(p), luma(q));
        [x, y, x * x, y * y, x * y]
    });
    let moments = gaussian_11(&Raster { size: a.size, px: moments.collect() });
    let (c1, c2) = (0.01f32.powi(2), 0.03f32.powi(2));
    let value = |m: &[f32; 5]| {
        let [x, y, xx, yy, xy] = *m;
        let (var_x, var_y, cov) = (xx - x * x, yy - y * y, xy - x * y);
        let (x, y) = (x + 0.5, y + 0.5);
        let similar = (2.0 * x * y + c1) * (2.0 * cov + c2);
        f64::from(similar / ((x * x + y * y + c1) * (var_x + var_y + c2)))
    };
    (moments.px.iter().map(value).sum::<f64>() / moments.px.len() as f64) as f32
}

/// Gaussian window, the edge going on outside.
fn gaussian_11<const N: usize>(raster: &Raster<[f32; N]>) -> Raster<[f32; N]> {
    let mut weights: Vec<f32> = (-5i32..=5).map(|i| (-(i * i) as f32 / (2.0 * 1.5 * 1.5)).exp()).collect();
    let sum: f32 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    let [w, h] = raster.size;
    let line = |source: &Raster<[f32; N]>, across: bool| {
        Raster::from_fn(raster.size, |x, y| {
            let mut out = [0.0; N];
            for (weight, k) in weights.iter().zip(-5isize..=5) {
                let at = |i: usize, len: usize| (i as isize + k).clamp(0, len as isize - 1) as usize;
                let texel = if across { source.at(at(x, w), y) } else { source.at(x, at(y, h)) };
                (0..N).for_each(|c| out[c] += weight * texel[c]);
            }
            out
        })
    };
    line(&line(raster, true), false)
}

/// Correlation after each row's mean is taken out of both: what "lower is nearer" cannot explain.
pub fn within_rows(a: &[f32], b: &[f32], width: usize) -> f32 {
    let centred = |values: &[f32]| -> Vec<f32> {
        let rows = values.chunks_exact(width);
        rows.flat_map(|row| {
            let mean = row.iter().sum::<f32>() / width as f32;
            row.iter().map(move |v| v - mean)
        })
        .collect()
    };
    let (a, b) = (centred(a), centred(b));
    correlation(a.iter().copied().zip(b.iter().copied()))
}

/// The middle value; none of no values.
pub fn median(mut values: Vec<f32>) -> Option<f32> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// The values below which these shares of all lie, shares ascending; the values' order changes. There must be some.
pub fn percentiles<const N: usize>(values: &mut [f32], shares: [f32; N]) -> [f32; N] {
    let last = (values.len() - 1) as f32;
    let mut known = 0;
    shares.map(|share| {
        let at = (last * share) as usize;
        let rest = &mut values[known..];
        let (_, value, _) = rest.select_nth_unstable_by(at - known, f32::total_cmp);
        known = at;
        *value
    })
}

/// Mean of what there is; none of nothing.
pub fn mean(values: impl Iterator<Item = f32>) -> Option<f32> {
    let (sum, count) = values.fold((0.0f64, 0u32), |(sum, count), v| (sum + f64::from(v), count + 1));
    (count > 0).then(|| (sum / f64::from(count)) as f32)
}
