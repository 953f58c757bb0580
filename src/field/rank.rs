//! How well two maps agree on what is nearer: their correlation by rank.

/// Spearman's rank correlation, −1 … 1; 0 where one of the two does not vary. Equal values share their mean rank.
pub fn spearman(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = (ranks(a), ranks(b));
    correlation(a.iter().copied().zip(b.iter().copied()))
}

/// Pearson's correlation of pairs, −1 … 1; 0 where one of the two does not vary.
pub fn correlation(pairs: impl Iterator<Item = (f32, f32)> + Clone) -> f32 {
    Moments::of(pairs).correlation()
}

/// Means, spreads and covariance of pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Means of the first and of the second numbers.
    pub mean: [f64; 2],
    /// Their standard deviations.
    pub spread: [f64; 2],
    /// Their covariance.
    pub covariance: f64,
}

impl Moments {
    /// Of pairs; all zero where there are none.
    pub fn of(pairs: impl Iterator<Item = (f32, f32)> + Clone) -> Self {
        let (mut sums, mut count) = ([0.0f64; 2], 0.0f64);
        for (a, b) in pairs.clone() {
            sums = [sums[0] + f64::from(a), sums[1] + f64::from(b)];
            count += 1.0;
        }
        let count = count.max(1.0);
        let mean = sums.map(|sum| sum / count);
        let (mut squares, mut products) = ([0.0; 2], 0.0);
        for (a, b) in pairs {
            let (a, b) = (f64::from(a) - mean[0], f64::from(b) - mean[1]);
            squares = [squares[0] + a * a, squares[1] + b * b];
            products += a * b;
        }
        Self { mean, spread: squares.map(|sum| (sum / count).sqrt()), covariance: products / count }
    }

    /// Pearson's correlation, −1 … 1; 0 where one of the two does not vary.
    pub fn correlation(&self) -> f32 {
        let [a, b] = self.spread;
        if a * b > 1e-9 { (self.covariance / (a * b)) as f32 } else { 0.0 }
    }
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
