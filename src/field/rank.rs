//! How well two maps agree on what is nearer: their correlation by rank.

/// Spearman's rank correlation, −1 … 1; 0 where one of the two does not vary. Equal values share their mean rank.
pub fn spearman(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = (ranks(a), ranks(b));
    correlation(a.iter().copied().zip(b.iter().copied()))
}

/// Pearson's correlation of pairs, −1 … 1; 0 where one of the two does not vary.
pub fn correlation(pairs: impl Iterator<Item = (f32, f32)> + Clone) -> f32 {
    let mut mean = (0.0f64, 0.0f64, 0.0f64);
    for (a, b) in pairs.clone() {
        mean = (mean.0 + f64::from(a), mean.1 + f64::from(b), mean.2 + 1.0);
    }
    let (a0, b0) = (mean.0 / mean.2.max(1.0), mean.1 / mean.2.max(1.0));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in pairs {
        let (a, b) = (f64::from(a) - a0, f64::from(b) - b0);
        (aa, bb, ab) = (aa + a * a, bb + b * b, ab + a * b);
    }
    if aa * bb > 1e-18 { (ab / (aa * bb).sqrt()) as f32 } else { 0.0 }
}

fn ranks(values: &[f32]) -> Vec<f32> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_unstable_by(|&i, &j| values[i].total_cmp(&values[j]));
    let mut ranks = vec![0.0; values.len()];
    let mut start = 0;
    for equal in order.chunk_by(|&i, &j| values[i] == values[j]) {
        let mean = start as f32 + (equal.len() - 1) as f32 / 2.0;
        equal.iter().for_each(|&i| ranks[i] = mean);
        start += equal.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_counts_and_not_scale() {
        let a: Vec<f32> = (0..50).map(|i| i as f32).collect();
        let cubed: Vec<f32> = a.iter().map(|v| v.powi(3)).collect();
        let turned: Vec<f32> = a.iter().map(|v| 3.0 - v).collect();
        assert!((spearman(&a, &cubed) - 1.0).abs() < 1e-6 && (spearman(&a, &turned) + 1.0).abs() < 1e-6);
        assert!(correlation(a.iter().copied().zip(cubed)) < 0.95);
    }

    #[test]
    fn equal_values_share_a_rank_and_a_constant_has_no_order() {
        assert_eq!(ranks(&[5.0, 1.0, 5.0, 9.0]), [1.5, 0.0, 1.5, 3.0]);
        assert_eq!(spearman(&[2.0; 4], &[1.0, 2.0, 3.0, 4.0]), 0.0);
    }
}
