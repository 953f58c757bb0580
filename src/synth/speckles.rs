//! Speckle filter: islands of disparity too small to be known are given to what surrounds them.

use super::lift::STEP_PX;
use crate::job::{Cancel, Cancelled};

/// Neighbours that differ by more than this lie on different surfaces, px per view step.
const APART_PX: f32 = STEP_PX / 2.0;

/// Takes islands of fewer than `least` pixels out of a map `[y, x]`. Each of their pixels gets the disparity of the
/// neighbour outside whose colour is most like its own, `difference` being that of the colours of two pixels.
pub(super) fn remove(
    map: &mut [f32],
    [w, h]: [usize; 2],
    least: usize,
    difference: impl Fn(usize, usize) -> f32,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    if least < 2 {
        return Ok(());
    }
    let mut left = islands(map, [w, h], least, cancel)?;
    let mut unknown = vec![false; map.len()];
    left.iter().for_each(|&i| unknown[i] = true);
    while !left.is_empty() {
        cancel.check()?;
        let alike = |i: usize| {
            let known = around([w, h], i).filter(|&n| !unknown[n]);
            known.min_by(|&a, &b| difference(i, a).total_cmp(&difference(i, b)))
        };
        let found: Vec<(usize, f32)> = left.iter().filter_map(|&i| Some((i, map[alike(i)?]))).collect();
        if found.is_empty() {
            break;
        }
        for (i, disparity) in found {
            (map[i], unknown[i]) = (disparity, false);
        }
        left.retain(|&i| unknown[i]);
    }
    Ok(())
}

/// The pixels of all surfaces of fewer than `least` pixels.
fn islands(map: &[f32], size: [usize; 2], least: usize, cancel: &Cancel) -> Result<Vec<usize>, Cancelled> {
    let mut islands = Vec::new();
    let alike = |a: usize, b: usize| (map[a] - map[b]).abs() <= APART_PX;
    surfaces(size, alike, cancel, |surface| {
        if surface.len() < least {
            islands.extend_from_slice(surface);
        }
    })?;
    Ok(islands)
}

/// Hands on the pixels of each surface of a picture: neighbours that are `joined` lie on the same.
pub(super) fn surfaces(
    size: [usize; 2],
    joined: impl Fn(usize, usize) -> bool,
    cancel: &Cancel,
    mut hand_on: impl FnMut(&[usize]),
) -> Result<(), Cancelled> {
    let mut seen = vec![false; size[0] * size[1]];
    let mut surface = Vec::new();
    for start in 0..seen.len() {
        if start % size[0] == 0 {
            cancel.check()?;
        }
        if seen[start] {
            continue;
        }
        seen[start] = true;
        surface.push(start);
        let mut next = 0;
        while let Some(&i) = surface.get(next) {
            for n in around(size, i) {
                if !seen[n] && joined(n, i) {
                    seen[n] = true;
                    surface.push(n);
                }
            }
            next += 1;
        }
        hand_on(&surface);
        surface.clear();
    }
    Ok(())
}

/// The up to four neighbours of a pixel.
fn around([w, h]: [usize; 2], i: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (i % w, i / w);
    let all = [(x > 0, -1), (x + 1 < w, 1), (y > 0, -(w as isize)), (y + 1 < h, w as isize)];
    all.into_iter().filter(|(inside, _)| *inside).map(move |(_, step)| i.wrapping_add_signed(step))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(map: &[f32], width: usize, least: usize, colours: &[f32]) -> Vec<f32> {
        let mut map = map.to_vec();
        let difference = |a: usize, b: usize| (colours[a] - colours[b]).abs();
        let size = [width, map.len() / width];
        remove(&mut map, size, least, difference, &Cancel::default()).unwrap();
        map
    }

    #[test]
    fn an_island_goes_to_the_side_of_its_colour_and_a_slant_is_none() {
        // Far on the left, near on the right, a speck between them that belongs to neither.
        let far_near = |i: usize| if i % 6 < 3 { 0.09 * (i / 6) as f32 - 1.0 } else { 0.5 };
        let want: Vec<f32> = (0..36).map(far_near).collect();
        let mut map = want.clone();
        (map[14], map[15]) = (-0.2, -0.2);
        let colours: Vec<f32> = (0..36).map(|i| if i % 6 < 3 { 0.1 } else { 0.8 }).collect();
        let found = cleaned(&map, 6, 3, &colours);
        let close = |(i, (a, b)): (usize, (&f32, &f32))| assert!((a - b).abs() < 0.1, "{i}: {a} for {b}");
        found.iter().zip(&want).enumerate().for_each(close);
        assert_eq!(cleaned(&map, 6, 2, &colours), map);
    }

    #[test]
    fn a_map_of_nothing_but_islands_stays() {
        let map = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(cleaned(&map, 2, 9, &[0.0; 4]), map);
    }
}
