//! Print: a line or a letter on a flat thing, which a net takes for a thin part before it.

use super::{Cost, Line, Maps, costs};

/// A pixel stands out of what lies this many pixels away on both sides, along its row or column.
const BESIDE: usize = 3;
/// A true thin part may lie so many pixels beside the one that is said.
const NEAR: usize = 2;

/// Sum over rows and columns of max(0, r(D) − r(D*) − slack) as a mean over all known pixels, where r, at least 0, is how
/// far a pixel stands out of both its sides; for the truth the largest one near by. `slack` is in px of each sample; 0
/// leaves a sample out.
pub fn print(maps: &Maps, depth: &[f32], truth: &[f32], slack: &[f32], weight: f32, gradient: &mut [f32]) -> f32 {
    costs(maps, [depth, truth], slack, weight, gradient, |of, slack| {
        maps.lines().flat_map(move |line| false_parts(line, of, slack))
    })
}

/// Pixels of a line that stand out too far: by how much, which one, and out of which.
fn false_parts(line: Line, [depth, truth]: [&[f32]; 2], slack: f32) -> impl Iterator<Item = Cost> {
    let far = BESIDE + NEAR;
    (far..line.length.saturating_sub(far)).filter_map(move |k| {
        let sides = [k - BESIDE, k + BESIDE].map(|k| line.at(k));
        let side = if depth[sides[0]] > depth[sides[1]] { sides[0] } else { sides[1] };
        let said = depth[line.at(k)] - depth[side] - slack;
        // Few pixels stand out: the truth is asked only where one does.
        let excess = if said > 0.0 { said - stands_out(line, truth, k) } else { 0.0 };
        (excess > 0.0).then_some((excess, [line.at(k), side]))
    })
}

/// How far the truth stands out near a pixel; beyond all measure where it is not known.
fn stands_out(line: Line, truth: &[f32], k: usize) -> f32 {
    let rise = |k: usize| [k - BESIDE, k + BESIDE].map(|side| truth[line.at(k)] - truth[line.at(side)]);
    let most = |most: f32, [a, b]: [f32; 2]| if a.is_nan() || b.is_nan() { f32::INFINITY } else { most.max(a.min(b)) };
    (k - NEAR..=k + NEAR).map(rise).fold(0.0, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nets::REFERENCE;

    const SIZE: [usize; 2] = [24, 12];

    /// A slope with a bar 2 px wide before it, which begins in this column.
    fn bar(column: usize) -> Vec<f32> {
        let of = |x: usize, y: usize| 0.01 * y as f32 + if (column..column + 2).contains(&x) { 0.5 } else { 0.0 };
        (0..SIZE[0] * SIZE[1]).map(|i| of(i % SIZE[0], i / SIZE[0])).collect()
    }

    fn flat() -> Vec<f32> {
        bar(SIZE[0])
    }

    fn loss(depth: &[f32], truth: &[f32], slack: f32) -> (f32, Vec<f32>) {
        let maps = Maps { samples: 1, views: vec![REFERENCE], height: SIZE[1], width: SIZE[0] };
        let mut gradient = vec![0.0; depth.len()];
        (print(&maps, depth, truth, &[slack], 1.0, &mut gradient), gradient)
    }

    #[test]
    fn a_bar_that_is_not_there_costs_and_is_pushed_back() {
        let (cost, gradient) = loss(&bar(10), &flat(), 0.05);
        let row = &gradient[5 * SIZE[0]..][..SIZE[0]];
        assert!(cost > 0.0 && row[10] > 0.0 && row[11] > 0.0 && row[7] + row[13] < 0.0, "{row:?}");
        assert!(row[..6].iter().chain(&row[16..]).all(|g| *g == 0.0), "{row:?}");
        assert_eq!(loss(&bar(10), &flat(), 0.6).0, 0.0, "less than the slack");
        assert_eq!(loss(&bar(10), &flat(), 0.0).0, 0.0, "a sample that is left out");
    }

    #[test]
    fn a_bar_that_is_there_or_lies_near_or_is_not_known_costs_nothing() {
        let said = bar(10);
        assert_eq!(loss(&said, &said, 0.05).0, 0.0);
        assert_eq!(loss(&said, &bar(12), 0.05).0, 0.0);
        assert!(loss(&said, &bar(15), 0.05).0 > 0.0, "another one");
        let mut truth = flat();
        truth.iter_mut().enumerate().filter(|(i, _)| i % SIZE[0] == 9).for_each(|(_, t)| *t = f32::NAN);
        assert_eq!(loss(&said, &truth, 0.05).0, 0.0);
    }

    #[test]
    fn a_step_is_no_part() {
        let step: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| f32::from(u8::from(i % SIZE[0] > 12))).collect();
        assert_eq!(loss(&step, &flat(), 0.05).0, 0.0);
    }
}
