//! Thin parts of a net's map: stems, strands, rails.
//!
//! Where depth moves to the photo's edges, a part between two edges this close together is lost on the way. So it is
//! taken out before, as what a square of pixels does not fit into (the white top-hat transform), and put back after.

use super::loose::Ground;
use crate::field::morphology::{extremes, opening};
use crate::job::{Cancel, Cancelled};

/// A square of `2·AROUND + 1` pixels of the net's map does not fit into a thin part.
const AROUND: usize = 2;
/// What this smaller one does not fit into is a part about as wide as a pixel of the net's map, which is drawn with a part
/// of its step.
const NARROW: usize = 1;
/// So many times what is drawn of a narrow part is its step, up to this one: in drawn scenes their true step is much the
/// same, however little or much of it is drawn.
const OF_DRAWN: f32 = 4.0;
const NARROW_PX: f32 = 0.3;
/// What stands out by this is as likely print, or a leaf's vein: it comes back with half of its step.
const PRINT_PX: f32 = 0.05;
/// What stands out by this is as likely drawn whole: half of what a narrow part lacks is added. In drawn scenes one part in
/// six is real that stands out by 0.1 to 0.2 px, one in eleven below that.
const WHOLE_PX: f32 = 0.1;
/// Within these pixels a thin part falls to what lies behind it on all sides. Where the map falls by more than so many
/// times the part's step there, the part is the rim of a thing, and has no depth of its own.
const BESIDE: usize = 4;
const RIM: f32 = 4.0;
/// Long side of the pictures whose px those above are.
const LONG_SIDE: f32 = 540.0;

/// Px of a picture for each of those above.
fn unit_px([w, h]: [usize; 2]) -> f32 {
    w.max(h) as f32 / LONG_SIDE
}

/// A map `[y, x]` without its thin parts, and how far each pixel's part stands out of what lies behind it; both px of a
/// `guide` of this size.
pub(super) fn taken_out(map: &[f32], size: [usize; 2], guide: [usize; 2]) -> (Vec<f32>, Vec<f32>) {
    let px = unit_px(guide);
    let [behind, wide] = [AROUND, NARROW].map(|around| opening(map, size, around));
    let least = extremes(map, size, BESIDE, f32::min);
    let step_px = |i: usize| {
        let [step, narrow, fall] = [behind[i], wide[i], least[i]].map(|other| (map[i] - other) / px);
        px * not_a_rim(step, fall) * (believed(step) + likely(step, WHOLE_PX) * undrawn(narrow))
    };
    let step_px = (0..map.len()).map(step_px).collect();
    (behind, step_px)
}

/// How likely a step is one of depth, 0 … 1, where half of those of `half_px` are.
fn likely(step_px: f32, half_px: f32) -> f32 {
    step_px.powi(2) / (step_px.powi(2) + half_px.powi(2))
}

fn believed(step_px: f32) -> f32 {
    step_px * likely(step_px, PRINT_PX)
}

/// What has not been drawn of a narrow part that stands out by so much.
fn undrawn(step_px: f32) -> f32 {
    let drawn = believed(step_px);
    ((OF_DRAWN * drawn).min(NARROW_PX) - drawn).max(0.0)
}

/// The share of a part's step that is its own where the map falls by so much beside it.
fn not_a_rim(step_px: f32, fall_px: f32) -> f32 {
    if fall_px > 0.0 { (RIM * step_px / fall_px).min(1.0) } else { 0.0 }
}

/// Puts the parts back before a map that is `enlarged` times as large as the one they come from, and has one of `step_px`
/// for each pixel. They stand out of what lay there `before` edges moved, or of what is farther now: a petal's tip is no
/// nearer where the petal's edge has come to it. A part that the map draws itself stays as it is, where it stands out more,
/// and one that hangs on nothing stays out ([`Ground::let_go`]).
pub(super) fn put_back(
    map: &mut [f32],
    before: &[f32],
    mut step_px: Vec<f32>,
    size: [usize; 2],
    enlarged: f32,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let mut behind = opening(map, size, (AROUND as f32 * enlarged).round() as usize);
    behind.iter_mut().zip(before).for_each(|(behind, before)| *behind = behind.min(*before));
    Ground { size, map, behind: &behind, px: unit_px(size) }.let_go(&mut step_px, cancel)?;
    let parts = behind.iter().zip(step_px).map(|(behind, step)| behind + step);
    map.iter_mut().zip(parts).for_each(|(d, part)| *d = d.max(part));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [40, 30];
    const GUIDE: [usize; 2] = [540, 404];

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
        for (wide, drawn, put) in [(1, 0.15, 0.25), (1, 0.5, 0.5), (4, 0.5, 0.5)] {
            let whole = with(drawn, wide);
            let (mut left, thin) = taken_out(&whole, SIZE, GUIDE);
            left.iter().zip(with(0.0, wide)).for_each(|(a, b)| assert!((a - b).abs() < 0.05, "{a} for {b}"));
            let before = left.clone();
            put_back(&mut left, &before, thin, SIZE, 1.0, &Cancel::default()).unwrap();
            let want = with(put, wide);
            left.iter().zip(want).for_each(|(a, b)| assert!((a - b).abs() < 0.05, "{wide} px: {a} for {b}"));
        }
    }

    #[test]
    fn a_vein_on_a_leaf_hardly_stands_out_of_it() {
        let (mut leaf, thin) = taken_out(&map(|x, _| if x == 8 { 0.02 } else { 0.0 }), SIZE, GUIDE);
        let before = leaf.clone();
        put_back(&mut leaf, &before, thin, SIZE, 1.0, &Cancel::default()).unwrap();
        assert!(leaf.iter().all(|d| (0.0..0.01).contains(d)));
    }

    #[test]
    fn a_thing_whose_rim_is_drawn_too_near_keeps_its_own_depth() {
        let thing = |x: usize, y: usize| (10..30).contains(&x) && (8..22).contains(&y);
        let rim = |x: usize, y: usize| thing(x, y) && !((11..29).contains(&x) && (9..21).contains(&y));
        let (_, thin) =
            taken_out(&map(|x, y| f32::from(thing(x, y)) + if rim(x, y) { 0.08 } else { 0.0 }), SIZE, GUIDE);
        assert!(thin.iter().all(|step| *step < 0.04), "{thin:?}");
        let (_, thin) = taken_out(&map(|x, _| if x == 8 { 0.08 } else { 0.0 }), SIZE, GUIDE);
        assert!(thin.iter().any(|step| *step > 0.08), "the same step before a wall is a stem's: {thin:?}");
    }

    #[test]
    fn a_part_of_a_small_picture_is_as_deep_as_that_of_a_large_one() {
        let stem = |of: f32| map(move |x, _| if x == 8 { 0.15 * of } else { 0.0 });
        let (_, large) = taken_out(&stem(1.0), SIZE, GUIDE);
        let (_, small) = taken_out(&stem(0.5), SIZE, GUIDE.map(|side| side / 2));
        small.iter().zip(large).for_each(|(small, large)| assert!((small - 0.5 * large).abs() < 1e-5));
    }

    #[test]
    fn a_part_that_a_map_draws_itself_is_not_drawn_twice() {
        let stem = map(|x, _| if x == 8 { 0.5 } else { 0.0 });
        let (behind, thin) = taken_out(&stem, SIZE, GUIDE);
        let drawn = map(|x, _| if x == 8 { 1.5 } else { 0.0 });
        let mut again = drawn.clone();
        put_back(&mut again, &behind, thin, SIZE, 1.0, &Cancel::default()).unwrap();
        assert_eq!(again, drawn);
    }

    #[test]
    fn a_tip_is_no_nearer_than_its_petal_where_the_petal_has_come_to_it() {
        let petal = |x: usize, y: usize| (10..30).contains(&y) && x < 20;
        let tip = |x: usize, y: usize| (18..21).contains(&y) && (20..24).contains(&x);
        let (behind, thin) = taken_out(&map(|x, y| f32::from(petal(x, y) || tip(x, y))), SIZE, GUIDE);
        let mut moved = map(|x, y| f32::from(petal(x.saturating_sub(4), y)));
        put_back(&mut moved, &behind, thin, SIZE, 1.0, &Cancel::default()).unwrap();
        assert!(moved.iter().all(|d| *d <= 1.05), "{moved:?}");
    }
}
