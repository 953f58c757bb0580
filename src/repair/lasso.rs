//! The inside of an outline that a hand drew, and the photo's edge near it.

use super::Place;
use super::mask::Mask;
use super::reach::{line, walk};

/// What lies within an outline (even-odd); pixel centres count.
pub(super) fn filled(outline: &[Place], sides: [usize; 2]) -> Mask {
    let [w, h] = sides;
    let corners: Vec<[f32; 2]> = outline.iter().map(|[x, y]| [x * w as f32 - 0.5, y * h as f32 - 0.5]).collect();
    let mut inside = vec![false; w * h];
    for y in 0..h {
        let mut cuts = crossings(&corners, y as f32);
        cuts.sort_by(f32::total_cmp);
        for cut in cuts.chunks_exact(2) {
            let (from, to) = (cut[0].ceil().max(0.0) as usize, (cut[1].floor() + 1.0).clamp(0.0, w as f32) as usize);
            inside[y * w..(y + 1) * w].iter_mut().take(to).skip(from).for_each(|pixel| *pixel = true);
        }
    }
    Mask::new(sides, |i| inside[i])
}

fn crossings(corners: &[[f32; 2]], y: f32) -> Vec<f32> {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let crosses = edges.filter(|(a, b)| (a[1] <= y) != (b[1] <= y));
    crosses.map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).collect()
}

/// Moves the outline to an edge within `band_px` of it: from the sure inside and the sure outside one walks towards each
/// other, and meets where the way is longest. Without a sure inside the outline stays.
pub(super) fn snapped(
    outline: &[Place],
    sides: [usize; 2],
    band_px: f32,
    cost: impl Fn(usize, usize, f32) -> f32,
) -> Mask {
    let drawn = filled(outline, sides);
    let corners: Vec<[f32; 2]> =
        outline.iter().map(|place| [0, 1].map(|axis| place[axis] * sides[axis] as f32 - 0.5)).collect();
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let mut away = vec![f32::INFINITY; sides[0] * sides[1]];
    let _band = walk(sides, &mut away, edges.flat_map(|(a, b)| line(sides, *a, *b)), band_px, |_, _, px| px);
    let is_sure = |i: usize| away[i] == f32::INFINITY;
    let core = |is_inside: bool| {
        let sure = (0..away.len()).filter(|i| is_sure(*i) && drawn.has(*i) == is_inside);
        sure.collect::<Vec<usize>>()
    };
    if core(true).is_empty() {
        return drawn;
    }
    let ways = |is_inside: bool| {
        let mut ways = vec![f32::INFINITY; away.len()];
        let _reached = walk(sides, &mut ways, core(is_inside), f32::MAX, |a, b, px| match is_sure(b) {
            true => f32::INFINITY,
            false => cost(a, b, px),
        });
        ways
    };
    let (inside, outside) = (ways(true), ways(false));
    Mask::new(sides, |i| inside[i] < outside[i])
}
