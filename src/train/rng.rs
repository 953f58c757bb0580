//! Seeded random numbers that are the same on every machine and in every version (SplitMix64).

/// A stream of random numbers, told by a seed and the number of the sample that it makes.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// The stream of sample `index` under `seed`.
    pub fn new(seed: u64, index: u64) -> Self {
        let mut rng = Self(seed ^ 0x5ce9_e5ca_11ab_1e00);
        let start = rng.next_u64();
        Self(start.wrapping_add(index.wrapping_mul(0xd134_2543_de82_ef95)))
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to 1, without 1.
    pub fn unit(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// From `lo` to `hi`.
    pub fn range(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.unit()
    }

    /// A number between two, as likely between one and its double wherever that lies.
    pub fn log_range(&mut self, lo: f32, hi: f32) -> f32 {
        self.range(lo.ln(), hi.ln()).exp()
    }

    /// An index below `count`; 0 where there is nothing to choose.
    pub fn below(&mut self, count: usize) -> usize {
        if count == 0 { 0 } else { (self.next_u64() % count as u64) as usize }
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f32) -> bool {
        self.unit() < probability
    }

    /// An index drawn by weight; 0 where all weights are 0.
    pub fn weighted(&mut self, weights: &[f32]) -> usize {
        let mut left = self.unit() * weights.iter().sum::<f32>();
        for (i, weight) in weights.iter().enumerate() {
            if left < *weight {
                return i;
            }
            left -= weight;
        }
        weights.iter().position(|&weight| weight > 0.0).unwrap_or(0)
    }

    /// A normal number of mean 0 and deviation 1 (Box–Muller).
    pub fn normal(&mut self) -> f32 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f32::consts::TAU * self.unit()).cos()
    }

    /// Two nearly normal numbers of mean 0 and deviation 1 (sums of four bytes: cheap, and enough for camera noise).
    pub fn normals(&mut self) -> [f32; 2] {
        // Four uniform bytes have mean 510 and deviation √(4·(256² − 1)/12) = 147.8.
        let bytes = self.next_u64().to_le_bytes();
        let sum = |b: &[u8]| (b.iter().map(|&v| f32::from(v)).sum::<f32>() - 510.0) / 147.8;
        [sum(&bytes[..4]), sum(&bytes[4..])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_seed_and_by_index_and_repeat() {
        let first = |seed, index| Rng::new(seed, index).next_u64();
        assert_eq!(first(1, 2), first(1, 2));
        assert_ne!(first(1, 2), first(1, 3));
        assert_ne!(first(1, 2), first(2, 2));
    }

    #[test]
    fn normal_numbers_have_mean_0_and_deviation_1() {
        let mut rng = Rng::new(7, 0);
        let exact: Vec<f32> = (0..100_000).map(|_| rng.normal()).collect();
        let quick: Vec<f32> = (0..50_000).flat_map(|_| rng.normals()).collect();
        for all in [exact, quick] {
            let mean = all.iter().sum::<f32>() / all.len() as f32;
            let var = all.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / all.len() as f32;
            assert!(mean.abs() < 0.02 && (var.sqrt() - 1.0).abs() < 0.02, "{mean} {var}");
        }
    }
}
