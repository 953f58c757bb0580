//! The depth layers of a scene: where many of its rays lie together, with fewer between.

/// Steps in which rays are counted.
const BINS: usize = 96;
/// Rays at either end that are left out.
const TAIL: f32 = 0.002;
/// A layer holds at least this share of the fullest one's height.
const LEAST: f32 = 0.03;
/// Between two layers lie at most this many of the lesser one's rays.
const VALLEY: f32 = 0.75;
/// More layers than this help nobody.
pub const MOST: usize = 9;

/// The disparities of the layers, from the nearest to the farthest; one at least.
pub fn layers(disparities: &[f32]) -> Vec<f32> {
    let mut sorted: Vec<f32> = disparities.iter().copied().filter(|d| d.is_finite()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let at = |share: f32| sorted.get(((sorted.len().max(1) - 1) as f32 * share) as usize).copied().unwrap_or(0.0);
    let (far, near) = (at(TAIL), at(1.0 - TAIL));
    if near - far < 1e-6 {
        return vec![near];
    }
    let counts = smooth(smooth(counted(&sorted, far, near)));
    let disparity = |peak: usize| far + (peak as f32 + 0.5) / BINS as f32 * (near - far);
    peaks(&counts).into_iter().rev().map(disparity).collect()
}

fn counted(sorted: &[f32], far: f32, near: f32) -> Vec<f32> {
    let mut counts = vec![0.0; BINS];
    for d in sorted.iter().filter(|d| (far..=near).contains(d)) {
        counts[(((d - far) / (near - far) * BINS as f32) as usize).min(BINS - 1)] += 1.0;
    }
    counts
}

/// Binomial weights over five neighbours.
fn smooth(counts: Vec<f32>) -> Vec<f32> {
    let at = |i: isize| counts.get(i.max(0) as usize).copied().unwrap_or(0.0) * f32::from(u8::from(i >= 0));
    (0..counts.len() as isize)
        .map(|i| (at(i - 2) + 4.0 * at(i - 1) + 6.0 * at(i) + 4.0 * at(i + 1) + at(i + 2)) / 16.0)
        .collect()
}

/// The places of the layers, from far to near: peaks with a valley on each side, the least told apart merged first.
fn peaks(counts: &[f32]) -> Vec<usize> {
    let top = counts.iter().copied().fold(0.0, f32::max);
    let is_peak = |i: usize| {
        let before = if i == 0 { 0.0 } else { counts[i - 1] };
        let after = counts.get(i + 1).copied().unwrap_or(0.0);
        counts[i] >= LEAST * top && counts[i] > before && counts[i] >= after
    };
    let mut peaks: Vec<usize> = (0..counts.len()).filter(|&i| is_peak(i)).collect();
    while peaks.len() > 1 {
        // How full the valley behind each peak is, of the lesser of both: 1 tells nothing apart.
        let fill = |pair: &[usize]| {
            let valley = counts[pair[0]..=pair[1]].iter().copied().fold(f32::INFINITY, f32::min);
            valley / counts[pair[0]].min(counts[pair[1]])
        };
        let fills = peaks.windows(2).map(fill).enumerate();
        let Some((first, worst)) = fills.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        if worst <= VALLEY && peaks.len() <= MOST {
            break;
        }
        let lesser = if counts[peaks[first]] < counts[peaks[first + 1]] { first } else { first + 1 };
        peaks.remove(lesser);
    }
    peaks
}

/// The number of the layer that is nearest to a disparity.
pub fn nearest(layers: &[f32], disparity: f32) -> usize {
    let apart = |layer: &f32| (layer - disparity).abs();
    layers.iter().enumerate().min_by(|a, b| apart(a.1).total_cmp(&apart(b.1))).map_or(0, |(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many rays around each disparity.
    fn rays(layers: &[(f32, usize)]) -> Vec<f32> {
        let spread = |n: usize, of: usize| (n as f32 / of as f32 - 0.5) * 0.12;
        layers.iter().flat_map(|&(at, of)| (0..of).map(move |n| at + spread(n, of))).collect()
    }

    #[test]
    fn each_thing_is_a_layer_from_near_to_far() {
        let found = layers(&rays(&[(-1.0, 4000), (0.2, 900), (1.5, 300)]));
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found.iter().zip([1.5, 0.2, -1.0]).all(|(got, want)| (got - want).abs() < 0.08), "{found:?}");
        assert_eq!([2.0, 0.9, 0.1, -9.0].map(|d| nearest(&found, d)), [0, 0, 1, 2]);
    }

    #[test]
    fn a_slope_a_plane_and_nothing_are_one_layer() {
        let slope: Vec<f32> = (0..5000).map(|n| n as f32 / 1000.0).collect();
        assert!(layers(&slope).len() <= 2, "{:?}", layers(&slope));
        assert_eq!(layers(&[0.5; 100]), [0.5]);
        assert_eq!(layers(&[]).len(), 1);
        let many: Vec<(f32, usize)> = (0..20).map(|n| (n as f32, 100)).collect();
        assert!(layers(&rays(&many)).len() <= MOST);
    }
}
