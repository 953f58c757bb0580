//! How far it is from here to everywhere, where edges are long ways: shortest paths over the pixels (Dijkstra 1959).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The eight neighbours, and how far away they are.
const NEIGHBOURS: [(i32, i32, f32); 8] = [
    (-1, 0, 1.0),
    (1, 0, 1.0),
    (0, -1, 1.0),
    (0, 1, 1.0),
    (-1, -1, std::f32::consts::SQRT_2),
    (1, -1, std::f32::consts::SQRT_2),
    (-1, 1, std::f32::consts::SQRT_2),
    (1, 1, std::f32::consts::SQRT_2),
];

/// The neighbours of a pixel, and how far away they are in pixels.
pub(super) fn neighbours([w, h]: [usize; 2], i: usize) -> impl Iterator<Item = (usize, f32)> {
    let (x, y) = ((i % w) as i32, (i / w) as i32);
    NEIGHBOURS.into_iter().filter_map(move |(dx, dy, far)| {
        let (x, y) = (x + dx, y + dy);
        let is_inside = x >= 0 && y >= 0 && x < w as i32 && y < h as i32;
        is_inside.then(|| (y as usize * w + x as usize, far))
    })
}

/// Walks on from `seeds`, whose ways are 0, as far as `limit`, and keeps in `ways` what is shorter than what stands
/// there. Says which pixels were reached anew.
///
/// `cost(from, to, px)` is that of a step, 0 or more.
pub(super) fn walk(
    sides: [usize; 2],
    ways: &mut [f32],
    seeds: impl IntoIterator<Item = usize>,
    limit: f32,
    cost: impl Fn(usize, usize, f32) -> f32,
) -> Vec<usize> {
    // The bits of numbers that are not negative have their order.
    let mut open = BinaryHeap::new();
    let mut reached = Vec::new();
    for seed in seeds {
        if ways[seed] > 0.0 {
            ways[seed] = 0.0;
            open.push(Reverse((0u32, seed as u32)));
        }
    }
    while let Some(Reverse((way, at))) = open.pop() {
        let (way, at) = (f32::from_bits(way), at as usize);
        if way > ways[at] {
            continue;
        }
        reached.push(at);
        for (next, px) in neighbours(sides, at) {
            let longer = way + cost(at, next, px);
            if longer < ways[next] && longer <= limit {
                ways[next] = longer;
                open.push(Reverse((longer.to_bits(), next as u32)));
            }
        }
    }
    reached
}

/// The pixels of a line between two places, in pixels.
pub(super) fn line([w, h]: [usize; 2], from: [f32; 2], to: [f32; 2]) -> Vec<usize> {
    let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).ceil().max(1.0) as usize;
    let at = |step: usize| {
        let t = step as f32 / steps as f32;
        let [x, y] = [0, 1].map(|axis| (from[axis] + (to[axis] - from[axis]) * t).round());
        let is_inside = x >= 0.0 && y >= 0.0 && x < w as f32 && y < h as f32;
        is_inside.then(|| y as usize * w + x as usize)
    };
    (0..=steps).filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_short_on_even_ground_and_a_wall_is_gone_round() {
        let sides = [21, 21];
        let mut ways = vec![f32::INFINITY; 441];
        let _reached = walk(sides, &mut ways, [0], 100.0, |_, _, px| px);
        assert!((ways[20] - 20.0).abs() < 1e-4 && (ways[440] - 20.0 * std::f32::consts::SQRT_2).abs() < 1e-3);
        // A wall down the middle with a gap at the bottom.
        let is_wall = |i: usize| i % 21 == 10 && i / 21 < 20;
        let mut ways = vec![f32::INFINITY; 441];
        let _reached = walk(sides, &mut ways, [0], 100.0, |_, to, px| if is_wall(to) { 1000.0 } else { px });
        assert!(ways[20] > 35.0 && ways[10] == f32::INFINITY, "{} {}", ways[20], ways[10]);
    }

    #[test]
    fn seeds_that_come_later_give_what_all_at_once_give() {
        let cost = |_: usize, to: usize, px: f32| px * (1.0 + (to % 7) as f32);
        let all = |groups: &[&[usize]]| {
            let mut ways = vec![f32::INFINITY; 900];
            for seeds in groups {
                let _reached = walk([30, 30], &mut ways, seeds.iter().copied(), 40.0, cost);
            }
            ways
        };
        assert_eq!(all(&[&[5, 400, 777]]), all(&[&[400], &[777], &[5]]));
    }
}
