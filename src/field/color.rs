//! sRGB ↔ linear light. The only place that knows the transfer curve (IEC 61966-2-1).

use std::sync::LazyLock;

/// Linear light 0 … 1 from an sRGB-encoded value 0 … 1.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// sRGB-encoded value 0 … 1 from linear light; below 0 and above 1 are clamped.
pub fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear light of an 8-bit sRGB value, from a table.
pub fn linear_from_srgb8(encoded: u8) -> f32 {
    static TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0)));
    TABLE[usize::from(encoded)]
}

/// The 8-bit sRGB value nearest to a linear light.
pub fn srgb8_from_linear(linear: f32) -> u8 {
    (srgb_from_linear(linear) * 255.0 + 0.5) as u8
}

/// The 16-bit sRGB value nearest to a linear light.
pub fn srgb16_from_linear(linear: f32) -> u16 {
    (srgb_from_linear(linear) * 65535.0 + 0.5) as u16
}

/// A network's value in −1 … 1 from an 8-bit value.
pub fn signed_from_u8(value: u8) -> f32 {
    f32::from(value) / 127.5 - 1.0
}

/// The 8-bit value nearest to a network's value in −1 … 1.
pub fn u8_from_signed(value: f32) -> u8 {
    (value.clamp(-1.0, 1.0) * 127.5 + 128.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_bit_value_survives_the_round_trips() {
        for value in 0..=255u8 {
            assert_eq!(srgb8_from_linear(linear_from_srgb8(value)), value);
            assert_eq!(u8_from_signed(signed_from_u8(value)), value);
        }
    }

    #[test]
    fn half_the_light_is_srgb_188() {
        assert_eq!(srgb8_from_linear(0.5), 188);
    }
}
