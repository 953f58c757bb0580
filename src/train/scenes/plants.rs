//! Procedural foreground: blades of grass, stems and leaves, coloured and textured from a photo's greens.

use super::raster::Raster;
use crate::rng::Rng;

/// A green of the photo, 0 … 255, or a plain one where it has none.
fn green(rng: &mut Rng, photo: &Raster<[u8; 3]>) -> [f32; 3] {
    for _ in 0..60 {
        let texel = photo.px[rng.below(photo.px.len())].map(f32::from);
        if texel[1] > texel[0] && texel[1] > 1.05 * texel[2] && texel[1] > 30.0 {
            return texel;
        }
    }
    [70.0, 120.0, 40.0]
}

/// Lays a pixel over what is there; `rgba` is premultiplied.
fn over(texel: &mut [f32; 4], colour: [f32; 3], alpha: f32) {
    (0..3).for_each(|c| texel[c] = colour[c] * alpha + texel[c] * (1.0 - alpha));
    texel[3] = alpha + texel[3] * (1.0 - alpha);
}

/// Where texture comes from: brightness of a photo's part around its mean.
struct Texture<'a> {
    photo: &'a Raster<[u8; 3]>,
    from: [usize; 2],
    strength: f32,
}

impl<'a> Texture<'a> {
    fn new(rng: &mut Rng, photo: &'a Raster<[u8; 3]>) -> Self {
        Self { photo, from: photo.size.map(|side| rng.below(side)), strength: rng.range(0.0, 0.7) }
    }

    fn at(&self, x: usize, y: usize) -> f32 {
        let [w, h] = self.photo.size;
        let texel = self.photo.at((x + self.from[0]) % w, (y + self.from[1]) % h);
        1.0 + self.strength * (f32::from(texel[1]) / 128.0 - 1.0)
    }
}

/// Blades and stems that rise from below (sometimes hang from above) over a canvas, premultiplied 0 … 1.
pub fn blades(rng: &mut Rng, size: [usize; 2], photo: &Raster<[u8; 3]>) -> Raster<[f32; 4]> {
    let [w, h] = size.map(|side| side as f32);
    let mut layer = Raster::from_fn(size, |_, _| [0.0f32; 4]);
    let base = green(rng, photo);
    for _ in 0..1 + rng.below(9) {
        let hangs = rng.chance(0.12);
        let root = [rng.range(-0.1, 1.1) * w, if hangs { -0.1 * h } else { rng.range(1.0, 1.2) * h }];
        let length = h * rng.range(0.3, 1.3) * if hangs { -1.0 } else { 1.0 };
        let bend = [rng.range(-0.5, 0.5) * length.abs(), rng.range(-0.2, 0.2) * length.abs()];
        let wide = rng.range(0.5, 7.0) * h / 144.0;
        let taper = if rng.chance(0.4) { 20.0 } else { rng.range(1.0, 5.0) };
        let shade = rng.range(0.5, 1.5);
        let colour = base.map(|c| (c * shade + rng.range(-10.0, 10.0)).clamp(0.0, 255.0) / 255.0);
        let (light, texture) = (rng.range(-0.35, 0.35), Texture::new(rng, photo));
        for y in 0..size[1] {
            let t = (root[1] - y as f32) / length;
            if !(0.0..=1.0).contains(&t) {
                continue;
            }
            let middle = root[0] + bend[0] * t * t + bend[1] * t;
            // The width along a row grows with the slant.
            let slant = (1.0 + ((2.0 * bend[0] * t + bend[1]) / length).powi(2)).sqrt();
            let half = (wide * (1.0 - t.powf(taper)) + 0.3) * slant;
            let from = (middle - half - 1.0).max(0.0) as usize;
            for x in from..((middle + half + 2.0).max(0.0) as usize).min(size[0]) {
                let across = (x as f32 - middle) / half;
                let alpha = (half + 0.5 - (x as f32 - middle).abs()).clamp(0.0, 1.0);
                let shine = (1.0 + light * across) * texture.at(x, y);
                over(&mut layer.px[y * size[0] + x], colour.map(|c| (c * shine).clamp(0.0, 1.0)), alpha);
            }
        }
    }
    layer
}

/// One to four leaves with a midrib, premultiplied 0 … 1.
pub fn leaves(rng: &mut Rng, size: [usize; 2], photo: &Raster<[u8; 3]>) -> Raster<[f32; 4]> {
    let [w, h] = size.map(|side| side as f32);
    let mut layer = Raster::from_fn(size, |_, _| [0.0f32; 4]);
    let base = green(rng, photo);
    for _ in 0..1 + rng.below(4) {
        let middle = [rng.range(-0.05, 1.05) * w, rng.range(-0.05, 1.05) * h];
        let half = [h * rng.range(0.1, 0.4), h * rng.range(0.03, 0.16)];
        let (sin, cos) = f32::sin_cos(rng.range(0.0, std::f32::consts::TAU));
        let (bend, shade) = (rng.range(-0.4, 0.4), rng.range(0.5, 1.5));
        let colour = base.map(|c| (c * shade + rng.range(-10.0, 10.0)).clamp(0.0, 255.0) / 255.0);
        let (light, texture) = (rng.range(-0.4, 0.4), Texture::new(rng, photo));
        let reach = half[0] + half[1] + 2.0;
        let span = |at: f32, all: usize| (at - reach).max(0.0) as usize..((at + reach).max(0.0) as usize).min(all);
        for y in span(middle[1], size[1]) {
            for x in span(middle[0], size[0]) {
                let (dx, dy) = (x as f32 - middle[0], y as f32 - middle[1]);
                let along = (cos * dx + sin * dy) / half[0];
                if along.abs() >= 1.0 {
                    continue;
                }
                let across = cos * dy - sin * dx - bend * half[1] * (1.0 - along * along);
                let width = half[1] * (1.0 - along * along).powf(0.8);
                let alpha = (width + 0.5 - across.abs()).clamp(0.0, 1.0);
                let rib = 1.0 + 0.25 * (-across * across / 0.8).exp();
                let shine = rib * (1.0 + light * across.signum()) * texture.at(x, y);
                over(&mut layer.px[y * size[0] + x], colour.map(|c| (c * shine).clamp(0.0, 1.0)), alpha);
            }
        }
    }
    layer
}
