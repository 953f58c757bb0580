//! What a camera makes of light: exposure, white balance, vignetting, defocus, blur, noise, bytes and JPEG.

use std::io::Cursor;

use crate::rng::Rng;
use crate::scenes::raster::Raster;

/// How one photo and its views are taken.
#[derive(Clone, Debug)]
pub struct Shutter {
    gains: [f32; 3],
    vignette: f32,
    blur_px: f32,
    /// Deviation of a point far out of focus, px, and the disparity that is in focus.
    defocus: Option<[f32; 2]>,
    /// Deviation of the noise in the dark and at full light.
    noise: [f32; 2],
    quality: Option<u8>,
    curve: Vec<f32>,
}

/// Entries of the tone curve for light 0 … 1.
const CURVE: usize = 1023;

impl Shutter {
    /// A shutter for a scene of this mean light and the disparity that is in focus.
    pub fn random(rng: &mut Rng, mean: f32, in_focus: f32) -> Self {
        let exposure = rng.range(0.16, 0.38) / mean.max(1e-4);
        let warm = rng.range(-0.12, 0.12).exp();
        let green = rng.range(-0.05, 0.05).exp();
        let defocus = rng.chance(0.4).then(|| [rng.range(0.6, 3.2), in_focus]);
        let contrast = rng.range(-0.1, 0.45);
        let blur_px = if rng.chance(0.35) { rng.range(0.0, 0.8) } else { 0.0 };
        let noise = if rng.chance(0.7) { [rng.range(0.0, 0.012), rng.range(0.0, 0.02)] } else { [0.0; 2] };
        let quality = rng.chance(0.4).then(|| 55 + rng.below(40) as u8);
        let tone = |i: usize| {
            let value = (i as f32 / CURVE as f32).powf(1.0 / 2.2);
            // A smooth S about the middle.
            let bent = value * value * (3.0 - 2.0 * value);
            value + contrast * (bent - value)
        };
        Self {
            gains: [exposure * warm, exposure * green, exposure / warm],
            vignette: rng.range(-0.1, 0.45).max(0.0),
            blur_px,
            defocus,
            noise,
            quality,
            curve: (0..=CURVE).map(tone).collect(),
        }
    }

    /// A shutter without chance, noise and blur.
    pub fn plain(mean: f32) -> Self {
        let mut shutter = Self::random(&mut Rng::new(0, 0), mean, 0.0);
        shutter.gains = [0.25 / mean.max(1e-4); 3];
        Self { vignette: 0.0, blur_px: 0.0, defocus: None, noise: [0.0; 2], quality: None, ..shutter }
    }

    /// A view's light with its disparities as sRGB 0 … 1.
    pub fn take(&self, rng: &mut Rng, mut light: Raster<[f32; 3]>, disparity: &[f32]) -> Raster<[f32; 3]> {
        let [w, h] = light.size.map(|side| side as f32);
        // Light above white still spreads as it is blurred, but not without end.
        light.px.iter_mut().for_each(|texel| (0..3).for_each(|c| texel[c] = (texel[c] * self.gains[c]).min(3.0)));
        if let Some([deviation, focus]) = self.defocus {
            defocus(&mut light, disparity, deviation, focus);
        }
        light.blur(self.blur_px);
        let wide = light.size[0];
        let half = (w * w + h * h) / 4.0;
        for (i, texel) in light.px.iter_mut().enumerate() {
            let (x, y) = ((i % wide) as f32 - w / 2.0, (i / wide) as f32 - h / 2.0);
            let fall = 1.0 - self.vignette * (x * x + y * y) / half;
            for c in texel {
                let light = *c * fall;
                // The brightest roll off.
                let light = if light > 0.7 { 1.0 - 0.09 / (light - 0.7 + 0.3) } else { light };
                *c = self.curve[(light.max(0.0) * CURVE as f32 + 0.5).min(CURVE as f32) as usize];
            }
        }
        self.add_noise(rng, &mut light);
        match self.quality {
            Some(quality) => jpeg(&light, quality).unwrap_or(light),
            None => light.map(|texel| texel.map(|c| (c * 255.0).round() / 255.0)),
        }
    }

    fn add_noise(&self, rng: &mut Rng, picture: &mut Raster<[f32; 3]>) {
        let [dark, bright] = self.noise;
        if dark + bright <= 0.0 {
            return;
        }
        for texel in &mut picture.px {
            let [a, b] = rng.normals();
            let [c, _] = rng.normals();
            for (value, noise) in texel.iter_mut().zip([a, b, c]) {
                *value = (*value + (dark + bright * *value) * noise).clamp(0.0, 1.0);
            }
        }
    }
}

/// Blurs by the distance from the focal plane, out of two blurred pictures and the sharp one.
fn defocus(light: &mut Raster<[f32; 3]>, disparity: &[f32], deviation: f32, focus: f32) {
    let [lo, hi] = disparity.iter().fold([f32::MAX, f32::MIN], |[lo, hi], &d| [lo.min(d), hi.max(d)]);
    let reach = (hi - focus).abs().max((lo - focus).abs()).max(1e-6);
    // The circle of confusion is smooth, or edges of depth would show in it.
    let mut circle = Raster { size: light.size, px: disparity.iter().map(|d| [(d - focus).abs() / reach]).collect() };
    circle.blur(0.7 * deviation);
    let mut half = light.clone();
    half.blur(0.45 * deviation);
    let mut full = half.clone();
    full.blur(0.9 * deviation);
    for (i, texel) in light.px.iter_mut().enumerate() {
        let at = 2.0 * circle.px[i][0];
        *texel = std::array::from_fn(|c| {
            let [sharp, half, full] = [texel[c], half.px[i][c], full.px[i][c]];
            if at < 1.0 { sharp + at * (half - sharp) } else { half + (at - 1.0).min(1.0) * (full - half) }
        });
    }
}

/// A picture after JPEG; none where the coder fails.
fn jpeg(picture: &Raster<[f32; 3]>, quality: u8) -> Option<Raster<[f32; 3]>> {
    let [w, h] = picture.size.map(|side| side as u32);
    let bytes: Vec<u8> = picture.px.iter().flat_map(|texel| texel.map(|c| (c * 255.0 + 0.5) as u8)).collect();
    let mut file = Vec::new();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, quality);
    encoder.encode(&bytes, w, h, image::ExtendedColorType::Rgb8).ok()?;
    let read = image::load(Cursor::new(file), image::ImageFormat::Jpeg).ok()?.into_rgb8();
    let px = read.pixels().map(|p| p.0.map(|c| f32::from(c) / 255.0)).collect();
    Some(Raster { size: picture.size, px })
}
