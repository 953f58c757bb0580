//! Order across the edge of a subject: a mask says what stands before what, though not by how much.

use rayon::prelude::*;

use super::Maps;

/// Distances in px of the pairs; a step between two that lie nearer to each other is a sharper edge.
const REACHES: [usize; 4] = [1, 2, 4, 8];
/// Coverage, 0 … 255, from which a pixel is the subject, and up to which it is its surround.
const INSIDE: u8 = 192;
const OUTSIDE: u8 = 63;

/// Mean of max(0, margin − (D₁ − D₂)) over the pairs of the reference views of which the first is the subject and the
/// second lies beside it or above it. Below it may be ground that is nearer. `subjects` holds each sample's coverage,
/// `[y, x]`, empty where nothing is known; `margin` is in px per view step.
pub fn subject_order(
    maps: &Maps,
    depth: &[f32],
    subjects: &[Vec<u8>],
    margin: f32,
    weight: f32,
    gradient: &mut [f32],
) -> f32 {
    let (plane, all) = (maps.plane(), maps.plane() * maps.views.len());
    let here = maps.reference() * plane..(maps.reference() + 1) * plane;
    let known = || subjects.par_iter().filter(|mask| mask.len() == plane);
    let count = known().map(|mask| pairs(mask, maps.width).count()).sum::<usize>().max(1);
    let k = weight / count as f32;
    let sums: Vec<f64> = (depth.par_chunks(all), gradient.par_chunks_mut(all), subjects)
        .into_par_iter()
        .filter(|(.., mask)| mask.len() == plane)
        .map(|(d, g, mask)| {
            let (d, g) = (&d[here.clone()], &mut g[here.clone()]);
            let mut sum = 0.0f64;
            for (near, far) in pairs(mask, maps.width) {
                let lack = margin - (d[near] - d[far]);
                if lack > 0.0 {
                    sum += f64::from(lack);
                    g[near] -= k;
                    g[far] += k;
                }
            }
            sum
        })
        .collect();
    (sums.iter().sum::<f64>() / count as f64) as f32
}

/// Pixels of a subject, each with one of its surround.
fn pairs(mask: &[u8], width: usize) -> impl Iterator<Item = (usize, usize)> {
    let inside = move |i: &usize| mask[*i] >= INSIDE;
    (0..mask.len()).filter(inside).flat_map(move |i| {
        REACHES.into_iter().flat_map(move |reach| {
            let left = (i % width >= reach).then(|| i - reach);
            let right = (i % width + reach < width).then_some(i + reach);
            let above = i.checked_sub(reach * width);
            [left, right, above].into_iter().flatten().filter(|&j| mask[j] <= OUTSIDE).map(move |j| (i, j))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nets::REFERENCE;

    /// A subject in the middle of 8 × 6 px.
    fn scene() -> (Maps, Vec<u8>) {
        let maps = Maps { samples: 1, views: vec![REFERENCE], height: 6, width: 8 };
        let inside = |i: usize| (3..5).contains(&(i % 8)) && (2..4).contains(&(i / 8));
        let mask = (0..48).map(|i| if inside(i) { 255 } else { 0 }).collect();
        (maps, mask)
    }

    #[test]
    fn a_subject_behind_its_surround_costs_and_one_before_it_does_not() {
        let (maps, mask) = scene();
        let loss = |sign: f32| {
            let depth: Vec<f32> = mask.iter().map(|m| sign * f32::from(*m) / 255.0).collect();
            let mut gradient = vec![0.0; 48];
            (subject_order(&maps, &depth, std::slice::from_ref(&mask), 0.5, 1.0, &mut gradient), gradient)
        };
        let (before, none) = loss(1.0);
        assert_eq!(before, 0.0);
        assert!(none.iter().all(|g| *g == 0.0));
        let (behind, gradient) = loss(-1.0);
        assert_eq!(behind, 1.5);
        assert!(gradient[2 * 8 + 3] < 0.0 && gradient[2 * 8 + 2] > 0.0, "the subject must come nearer");
        assert!(gradient[32..].iter().all(|g| *g == 0.0), "what lies below it may be nearer");
    }

    #[test]
    fn samples_without_a_subject_say_nothing() {
        let (maps, _) = scene();
        let mut gradient = vec![0.0; 48];
        assert_eq!(subject_order(&maps, &[0.0; 48], &[Vec::new()], 0.5, 1.0, &mut gradient), 0.0);
        assert!(gradient.iter().all(|g| *g == 0.0));
    }
}
