//! Pictures made for HDR screens (ITU-R BT.2100) → what a screen of today shows of them.

use rayon::prelude::*;

use super::Samples;

/// `transfer` of perceptual quantization and of hybrid log-gamma (ITU-T H.273).
const PQ: u16 = 16;
const HLG: u16 = 18;
/// Brightness of a white sheet, in cd/m² (ITU-R BT.2408).
const WHITE: f32 = 203.0;
/// From this share of white on, brightness is compressed, so that what is brighter than white keeps its shape.
const KNEE: f32 = 0.75;

/// What the person is told.
pub(crate) const WARNING: &str = "the picture is made for HDR screens: what is brighter than white is compressed";

/// The samples with sRGB's transfer curve, if theirs is one for HDR screens.
pub(crate) fn to_sdr(samples: Samples, transfer: u16) -> (Samples, bool) {
    if !matches!(transfer, PQ | HLG) {
        return (samples, false);
    }
    let table: Vec<u16> = (0..=65_535u16)
        .into_par_iter()
        .map(|code| {
            let encoded = f32::from(code) / 65_535.0;
            let of_white = if transfer == PQ { pq(encoded) / WHITE } else { hlg(encoded) };
            (srgb(compressed(of_white)) * 65_535.0 + 0.5) as u16
        })
        .collect();
    let mut pixels = match samples {
        Samples::Sixteen(pixels) => pixels,
        Samples::Eight(pixels) => pixels.iter().map(|px| px.map(|value| u16::from(value) * 257)).collect(),
    };
    pixels.par_iter_mut().for_each(|[r, g, b, _]| [r, g, b].into_iter().for_each(|c| *c = table[usize::from(*c)]));
    (Samples::Sixteen(pixels), true)
}

/// PQ's curve: 0 … 1 → cd/m² (BT.2100, table 4).
fn pq(encoded: f32) -> f32 {
    let root = encoded.powf(1.0 / 78.843_75);
    10_000.0 * ((root - 0.835_937_5).max(0.0) / (18.851_563 - 18.6875 * root)).powf(1.0 / 0.159_301_76)
}

/// HLG's curve: 0 … 1 → shares of white (BT.2100, table 5; white is 75 %), for a screen of 1000 cd/m² (system gamma 1.2).
fn hlg(encoded: f32) -> f32 {
    let scene = |e: f32| {
        if e <= 0.5 { e * e / 3.0 } else { (((e - 0.559_910_7) / 0.178_832_77).exp() + 0.284_668_92) / 12.0 }
    };
    (scene(encoded) / scene(0.75)).powf(1.2)
}

/// Shares of white → 0 … 1.
fn compressed(of_white: f32) -> f32 {
    let over = of_white - KNEE;
    if over <= 0.0 { of_white } else { KNEE + (1.0 - KNEE) * (1.0 - (-over / (1.0 - KNEE)).exp()) }
}

fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What BT.2408 and BT.2100 say of white, grey and peak.
    #[test]
    fn white_lies_just_below_the_top_and_order_is_kept() {
        assert!((pq(0.580_7) - WHITE).abs() < 1.0 && (pq(1.0) - 10_000.0).abs() < 1.0 && pq(0.0).abs() < 1e-6);
        assert!((hlg(0.75) - 1.0).abs() < 1e-6 && (hlg(1.0) * WHITE - 1000.0).abs() < 25.0, "{}", hlg(1.0) * WHITE);
        for transfer in [PQ, HLG] {
            let ramp = (0..=255).map(|v| [v, v, v, 255]).collect();
            let (Samples::Sixteen(seen), true) = to_sdr(Samples::Eight(ramp), transfer) else { panic!("16 bits") };
            assert!(seen.windows(2).all(|two| two[0][0] <= two[1][0]) && seen[0][0] == 0, "{transfer}");
            assert!(seen.iter().all(|px| px[3] == 65_535));
            let white = seen[if transfer == PQ { 148 } else { 191 }][0];
            assert!((60_000..64_500).contains(&white), "{transfer}: {white}");
        }
        let (same, changed) = to_sdr(Samples::Eight(vec![[7; 4]]), 13);
        assert!(!changed && matches!(same, Samples::Eight(px) if px == [[7; 4]]));
    }
}
