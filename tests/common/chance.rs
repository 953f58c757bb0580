//! Chance that is the same in every run.

/// Evenly spread number 0 … 1 that belongs to a place.
pub fn hash(x: i32, y: i32, seed: u32) -> f32 {
    let mut h =
        (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE35);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 12;
    (h.wrapping_mul(0x297A_2D39) >> 8) as f32 / (1 << 24) as f32
}
