//! What a picture shows where Gaussians leave gaps: between surfaces that came apart, and at a view's own rim.
//!
//! A gap takes the mean of what lies around it, where most of that is covered. What is open on a whole side, as around an
//! object that stands alone, stays black and as far as the farthest.

use rayon::prelude::*;

use super::raster::Shown;

/// How far is looked, in pixels.
const REACH: usize = 8;
/// Covered parts of the surroundings from which a gap is filled: not at all, and wholly.
const CLOSED: [f32; 2] = [0.55, 0.75];
/// A ray that is covered less than this ends at the farthest, where its gap is not filled.
const SOLID: f32 = 0.5;

/// Closes gaps; `far` is the inverse distance of what is farthest.
pub(super) fn close_gaps(shown: &mut Shown, width: usize, far: f32) {
    if shown.cover.iter().all(|cover| *cover > 0.98) {
        return;
    }
    let around = means(shown, width);
    let pixels = shown.rgb.par_iter_mut().zip(&shown.cover).zip(&mut shown.nearness).zip(&around);
    pixels.for_each(|(((rgb, cover), nearness), [r, g, b, n, covered])| {
        let open = 1.0 - cover;
        let share = crate::field::ramp(CLOSED[0], CLOSED[1], *covered);
        if open > 0.0 && share > 0.0 {
            let light = share * open / covered;
            rgb.iter_mut().zip([r, g, b]).for_each(|(own, mean)| *own += mean * light);
            *nearness = *nearness * cover + open * n / covered;
        } else if *cover < SOLID {
            *nearness = far;
        }
    });
}

/// Means of red, green, blue, nearness and cover in a square around each pixel, each times its cover.
fn means(shown: &Shown, width: usize) -> Vec<[f32; 5]> {
    let own = shown.rgb.iter().zip(&shown.nearness).zip(&shown.cover);
    let own: Vec<[f32; 5]> = own.map(|(([r, g, b], n), cover)| [*r, *g, *b, n * cover, *cover]).collect();
    let height = own.len() / width;
    let mut across = vec![[0.0; 5]; own.len()];
    let rows = across.par_chunks_mut(width).zip(own.par_chunks(width));
    rows.for_each(|(out, row)| run(width, |x| row[x], |x, mean| out[x] = mean));
    // Down the columns: a row of sums that takes one row in and gives one back.
    let mut sums = vec![[0.0f32; 5]; width];
    let mut down = own;
    let add = |sums: &mut [[f32; 5]], row: &[[f32; 5]], sign: f32| {
        sums.iter_mut().zip(row).for_each(|(sum, value)| (0..5).for_each(|i| sum[i] += sign * value[i]));
    };
    let row = |y: usize| &across[y * width..(y + 1) * width];
    (0..REACH.min(height)).for_each(|y| add(&mut sums, row(y), 1.0));
    for y in 0..height {
        if y + REACH < height {
            add(&mut sums, row(y + REACH), 1.0);
        }
        if y > REACH {
            add(&mut sums, row(y - REACH - 1), -1.0);
        }
        let count = (y.saturating_sub(REACH)..(y + REACH + 1).min(height)).len() as f32;
        let out = &mut down[y * width..(y + 1) * width];
        out.iter_mut().zip(&sums).for_each(|(out, sum)| *out = sum.map(|value| value / count));
    }
    down
}

/// The mean around each place of a row.
fn run(length: usize, value: impl Fn(usize) -> [f32; 5], mut put: impl FnMut(usize, [f32; 5])) {
    let mut sum = [0.0f32; 5];
    let add = |sum: &mut [f32; 5], at: usize, sign: f32| {
        sum.iter_mut().zip(value(at)).for_each(|(sum, value)| *sum += sign * value);
    };
    (0..REACH.min(length)).for_each(|x| add(&mut sum, x, 1.0));
    for x in 0..length {
        if x + REACH < length {
            add(&mut sum, x + REACH, 1.0);
        }
        if x > REACH {
            add(&mut sum, x - REACH - 1, -1.0);
        }
        let count = (x.saturating_sub(REACH)..(x + REACH + 1).min(length)).len() as f32;
        put(x, sum.map(|sum| sum / count));
    }
}
