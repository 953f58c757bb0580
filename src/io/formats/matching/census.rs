//! How badly every pixel of one eye's picture matches the other's at every shift.

use rayon::prelude::*;

use crate::field::Raster;
use crate::semiglobal::Volume;

/// Half the sides of the window of a census transform: 9×7 pixels, all but the middle one.
const WINDOW: [i32; 2] = [4, 3];
/// Cost of a match outside the other picture: neither good nor bad.
const OUTSIDE: i16 = 24;

/// Costs `[y, x, shift]` of two pictures of one size, where a pixel at `x` is at `place(x, shift)` in the other one.
pub(super) fn costs(
    [from, to]: [&Raster<f32>; 2],
    shifts: usize,
    place: impl Fn(usize, usize) -> Option<usize> + Sync,
) -> Volume<i16> {
    let [own, other] = [from, to].map(census);
    let width = from.sides()[0];
    let mut costs = vec![OUTSIDE; own.len() * shifts];
    costs.par_chunks_mut(width * shifts).enumerate().for_each(|(y, row)| {
        let (own, other) = (&own[y * width..][..width], &other[y * width..][..width]);
        for (x, (own, costs)) in own.iter().zip(row.chunks_exact_mut(shifts)).enumerate() {
            for (shift, cost) in costs.iter_mut().enumerate() {
                if let Some(there) = place(x, shift) {
                    *cost = (own ^ other[there]).count_ones() as i16;
                }
            }
        }
    });
    Volume { sides: from.sides(), labels: shifts, costs }
}

/// Which of the pixels around each are darker than it, one bit each.
fn census(picture: &Raster<f32>) -> Vec<u64> {
    let [width, height] = picture.size().map(|side| side as i32);
    let of = |x: usize, y: usize| {
        let own = picture.at(x, y);
        let mut bits = 0;
        for dy in -WINDOW[1]..=WINDOW[1] {
            let row = (y as i32 + dy).clamp(0, height - 1) as usize;
            for dx in (-WINDOW[0]..=WINDOW[0]).filter(|dx| [*dx, dy] != [0, 0]) {
                let column = (x as i32 + dx).clamp(0, width - 1) as usize;
                bits = bits << 1 | u64::from(picture.at(column, row) < own);
            }
        }
        bits
    };
    Raster::par_from_fn(picture.size(), of).into_pixels()
}
