//! A disparity map as GDepth (developers.google.com/depthmap-metadata): `RangeInverse`, 16 bits, white far, stretched to
//! the picture. Units are left open: disparity alone knows no metres.

use png::{BitDepth, ColorType};

use crate::field::DisparityMap;
use crate::io::formats::out;

/// What says what the map means. Far is 10 times as far as near, as nobody knows the unit.
pub(super) const HEAD: [(&str, &str); 5] =
    [("Format", "RangeInverse"), ("Near", "1.0"), ("Far", "10.0"), ("Mime", "image/png"), ("Software", "Plenoscope")];

/// 16-bit grey: inverse depth is linear in disparity, so `n = (near − d) / (near − far)`.
pub(super) fn png(map: &DisparityMap) -> std::io::Result<Vec<u8>> {
    let [far, near] = map.range_px();
    let scale = if near > far { 65_535.0 / (near - far) } else { 0.0 };
    let value = |d: f32| (((near - d) * scale).round() as u16).to_be_bytes();
    let rows = map.disparity_px().chunks_exact(map.size()[0] as usize);
    let rows = rows.map(|row| row.iter().flat_map(|&d| value(d)).collect());
    let mut bytes = Vec::new();
    out::png(&mut bytes, map.size(), (ColorType::Grayscale, BitDepth::Sixteen), &[], rows)?;
    Ok(bytes)
}
