//! Thin parts of a net's map: stems, strands, rails.
//!
//! Where depth moves to the photo's edges, a part between two edges this close together is lost on the way. So it is
//! taken out before, as what a square of pixels does not fit into (the white top-hat transform), and put back after.

use crate::field::morphology::opening;

/// A square of `2·AROUND + 1` pixels of the net's map does not fit into a thin part.
const AROUND: usize = 2;
/// What this smaller one does not fit into is a part about as wide as a pixel of the net's map, which is drawn with half
/// of its step: it counts twice, and a quarter more of drawn scenes' parts are found.
const HALF_DRAWN: usize = 1;
/// What stands out by this is as likely print, or a leaf's vein: it comes back with half of its step, px.
const PRINT_PX: f32 = 0.05;

/// A map `[y, x]` without its thin parts, and how far each pixel's part stands out of what lies behind it, px.
pub(super) fn taken_out(map: &[f32], size: [usize; 2]) -> (Vec<f32>, Vec<f32>) {
    let [behind, half_drawn] = [AROUND, HALF_DRAWN].map(|around| opening(map, size, around));
    let step = |((d, behind), half): ((&f32, &f32), f32)| believed(d - behind) + believed(d - half);
    let step_px = map.iter().zip(&behind).zip(half_drawn).map(step).collect();
    (behind, step_px)
}

fn believed(step_px: f32) -> f32 {
    step_px.powi(3) / (step_px.powi(2) + PRINT_PX.powi(2))
}

/// Puts the parts back before a map that is `enlarged` times as large as the one they come from, and has one of `step_px`
/// for each pixel. A part that this map draws itself stays as it is, where it stands out more.
pub(super) fn put_back(map: &mut [f32], step_px: &[f32], size: [usize; 2], enlarged: f32) {
    let behind = opening(map, size, (AROUND as f32 * enlarged).round() as usize);
    let parts = behind.iter().zip(step_px).map(|(behind, step)| behind + step);
    map.iter_mut().zip(parts).for_each(|(d, part)| *d = d.max(part));
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [40, 30];

    fn map(of: impl Fn(usize, usize) -> f32) -> Vec<f32> {
        (0..SIZE[0] * SIZE[1]).map(|i| of(i % SIZE[0], i / SIZE[0])).collect()
    }

    #[test]
    fn a_stem_is_taken_out_of_the_ground_and_put_back_and_a_block_stays() {
        let block = |x: usize, y: usize| (20..30).contains(&x) && (8..20).contains(&y);
        let with =
            |stem: f32, wide: usize| {
                map(|x, y| {
                    if block(x, y) {
                        1.0
                    } else {
                        0.01 * y as f32 + if (8..8 + wide).contains(&x) { stem } else { 0.0 }
                    }
                })
            };
        for (wide, drawn) in [(1, 2.0), (4, 1.0)] {
            let whole = with(0.5, wide);
            let (mut left, thin) = taken_out(&whole, SIZE);
            left.iter().zip(with(0.0, wide)).for_each(|(a, b)| assert!((a - b).abs() < 0.05, "{a} for {b}"));
            put_back(&mut left, &thin, SIZE, 1.0);
            let want = with(0.5 * drawn, wide);
            left.iter().zip(want).for_each(|(a, b)| assert!((a - b).abs() < 0.05, "{wide} px: {a} for {b}"));
        }
    }

    #[test]
    fn a_vein_on_a_leaf_hardly_stands_out_of_it() {
        let (mut leaf, thin) = taken_out(&map(|x, _| if x == 8 { 0.02 } else { 0.0 }), SIZE);
        put_back(&mut leaf, &thin, SIZE, 1.0);
        assert!(leaf.iter().all(|d| (0.0..0.01).contains(d)));
    }

    #[test]
    fn a_part_that_a_map_draws_itself_is_not_drawn_twice() {
        let stem = map(|x, _| if x == 8 { 0.5 } else { 0.0 });
        let (_, thin) = taken_out(&stem, SIZE);
        let drawn = map(|x, _| if x == 8 { 1.5 } else { 0.0 });
        let mut again = drawn.clone();
        put_back(&mut again, &thin, SIZE, 1.0);
        assert_eq!(again, drawn);
    }
}
