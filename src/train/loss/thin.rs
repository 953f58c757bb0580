//! Thin parts: a stem, a strand or a rail is so few pixels that a net which averages them away loses nothing by the other losses.

use super::{Maps, costs};

/// Most pixels across a part.
const WIDEST_PX: usize = 3;
/// A part stands before both its sides by so many times what makes a pair of the ordinal loss.
const STEP: f32 = 1.5;
/// No more of a step than so many times that is asked for.
const MOST: f32 = 4.0;

/// Sum of max(0, margin − (D − D₁)) over the pixels of thin parts, against what lies behind on both sides along the row or the
/// column, as a mean over all known pixels: a thin part's pixel weighs as much as any other does at this weight. The
/// margin is the true step. `apart` is in px of each sample; 0 leaves a sample out.
pub fn thin_parts(maps: &Maps, depth: &[f32], truth: &[f32], apart: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    costs(maps, [depth, truth], apart, weight, gradient, |[d, t], apart| {
        pairs(maps, t, STEP * apart).filter_map(move |(i, side)| {
            let lack = (t[i] - t[side]).min(MOST * apart) - (d[i] - d[side]);
            (lack > 0.0).then_some((lack, [side, i]))
        })
    })
}

/// Pixels of thin parts of a map of true ray depths, each with what lies on either side, beyond the part's soft edge.
fn pairs(maps: &Maps, truth: &[f32], step: f32) -> impl Iterator<Item = (usize, usize)> {
    maps.lines().flat_map(move |line| {
        (2..line.length.saturating_sub(WIDEST_PX + 2)).flat_map(move |k| {
            let wide = part(&|k| truth[line.at(k)], k, step).unwrap_or(0);
            let sides = [k - 2, k + wide.max(1) + 1].map(|k| line.at(k));
            (k..k + wide).flat_map(move |k| sides.map(|side| (line.at(k), side)))
        })
    })
}

/// The width of a thin part that begins at `k` of a line; none where none begins. What is not known is no side.
fn part(at: &dyn Fn(usize) -> f32, k: usize, step: f32) -> Option<usize> {
    let begins = at(k) - at(k - 1) > step;
    if !begins {
        return None;
    }
    let wide = (1..=WIDEST_PX).find(|&wide| at(k + wide - 1) - at(k + wide) > step)?;
    let stands_before = |side: usize| (k..k + wide).all(|k| at(k) - at(side) > step);
    [k - 2, k - 1, k + wide, k + wide + 1].into_iter().all(stands_before).then_some(wide)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nets::REFERENCE;

    /// A bar 2 px wide and a box 5 px wide before a wall.
    fn scene() -> (Maps, Vec<f32>) {
        let maps = Maps { samples: 1, views: vec![REFERENCE], height: 8, width: 24 };
        let near = |x: usize| (5..7).contains(&x) || (13..18).contains(&x);
        (maps, (0..8 * 24).map(|i| if near(i % 24) { 0.6 } else { 0.01 * (i / 24) as f32 }).collect())
    }

    #[test]
    fn a_bar_that_is_missed_costs_and_a_box_does_not() {
        let (maps, truth) = scene();
        let loss = |depth: &[f32]| {
            let mut gradient = vec![0.0; truth.len()];
            (thin_parts(&maps, depth, &truth, &[0.1], 1.0, &mut gradient), gradient)
        };
        assert_eq!(loss(&truth).0, 0.0);
        let (missed, gradient) = loss(&vec![0.0; truth.len()]);
        assert!(missed > 0.0);
        let row = |y: usize| &gradient[y * 24..][..24];
        assert!(row(3)[5] < 0.0 && row(3)[6] < 0.0 && row(3)[3] > 0.0 && row(3)[8] > 0.0, "{:?}", row(3));
        assert!(row(3)[10..].iter().all(|g| *g == 0.0), "{:?}", row(3));
        let without = thin_parts(&maps, &vec![0.0; truth.len()], &truth, &[0.0], 1.0, &mut vec![0.0; truth.len()]);
        assert_eq!(without, 0.0, "a sample that is left out");
    }

    #[test]
    fn what_is_not_known_is_no_thin_part() {
        let (maps, mut truth) = scene();
        truth.iter_mut().enumerate().filter(|(i, _)| i % 24 == 7).for_each(|(_, t)| *t = f32::NAN);
        let depth = vec![0.0; truth.len()];
        assert_eq!(thin_parts(&maps, &depth, &truth, &[0.1], 1.0, &mut vec![0.0; depth.len()]), 0.0);
    }
}
