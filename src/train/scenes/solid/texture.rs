//! Pictures to paint things with: mip levels, repeated or not, read as light.

use std::sync::LazyLock;

use crate::scenes::raster::{Raster, floor};

/// One level of a texture, sRGB and coverage.
struct Level {
    size: [usize; 2],
    px: Vec<[u8; 4]>,
}

/// A picture with its mip levels; places outside 0 … 1 repeat it.
pub struct Texture {
    levels: Vec<Level>,
    /// Whether any of it is transparent, so that faces must ask before they hide what is behind.
    pub cut_out: bool,
}

/// Linear light of an sRGB byte.
pub static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| to_linear(i as f32 / 255.0)));

/// Linear light of an sRGB value in 0 … 1.
pub fn to_linear(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

impl Texture {
    /// A texture of a picture with coverage in the fourth channel.
    pub fn new(picture: Raster<[u8; 4]>) -> Self {
        let cut_out = picture.px.iter().any(|texel| texel[3] < 128);
        let mut levels = vec![Level { size: picture.size, px: picture.px }];
        while levels[levels.len() - 1].size != [1, 1] {
            let next = halved(&levels[levels.len() - 1]);
            levels.push(next);
        }
        Self { levels, cut_out }
    }

    /// A texture of an opaque picture.
    pub fn opaque(picture: &Raster<[u8; 3]>) -> Self {
        Self::new(picture.map(|&[r, g, b]| [r, g, b, 255]))
    }

    /// Width over height.
    pub fn aspect(&self) -> f32 {
        self.levels[0].size[0] as f32 / self.levels[0].size[1] as f32
    }

    /// Linear light and coverage at a place, seen through a pixel that covers `reach` of the picture in u and v.
    #[inline]
    pub fn light(&self, u: f32, v: f32, reach: f32) -> [f32; 4] {
        let level = &self.levels[self.level(reach)];
        let [w, h] = level.size;
        let (x, y) = (wrapped(u) * w as f32 - 0.5, wrapped(v) * h as f32 - 0.5);
        let (fx, fy) = (x - floor(x), y - floor(y));
        // One pixel before the first is the last: the picture repeats.
        let (x0, y0) = (if x < 0.0 { w - 1 } else { x as usize }, if y < 0.0 { h - 1 } else { y as usize });
        let (x1, y1) = (if x0 + 1 < w { x0 + 1 } else { 0 }, if y0 + 1 < h { y0 + 1 } else { 0 });
        let linear = &*LINEAR;
        let at = |x: usize, y: usize| {
            let [r, g, b, a] = level.px[y * w + x];
            [linear[r as usize], linear[g as usize], linear[b as usize], f32::from(a) / 255.0]
        };
        let (a, b, c, d) = (at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1));
        std::array::from_fn(|i| {
            let (top, bottom) = (a[i] + fx * (b[i] - a[i]), c[i] + fx * (d[i] - c[i]));
            top + fy * (bottom - top)
        })
    }

    /// Whether a place is covered, by the nearest texel.
    #[inline]
    pub fn covers(&self, u: f32, v: f32) -> bool {
        let level = &self.levels[0];
        let [w, h] = level.size;
        let (x, y) = ((wrapped(u) * w as f32) as usize, (wrapped(v) * h as f32) as usize);
        level.px[y.min(h - 1) * w + x.min(w - 1)][3] >= 128
    }

    /// The level of which a pixel covers about one texel.
    #[inline]
    fn level(&self, reach: f32) -> usize {
        let texels = reach * self.levels[0].size[0].max(self.levels[0].size[1]) as f32;
        // The exponent of the number is its logarithm, rounded down.
        let level = (((texels * 1.2).max(1.0).to_bits() >> 23) & 0xff) as usize - 127;
        level.min(self.levels.len() - 1)
    }
}

#[inline]
fn wrapped(value: f32) -> f32 {
    value - floor(value)
}

/// The level of half the size: means of four, colours weighed by coverage.
fn halved(level: &Level) -> Level {
    let [w, h] = level.size;
    let size = [w.div_ceil(2).max(1), h.div_ceil(2).max(1)];
    let size = if level.size == size { [1, 1] } else { size };
    let mut px = Vec::with_capacity(size[0] * size[1]);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let mut sum = [0u32; 4];
            for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let texel = level.px[(2 * y + j).min(h - 1) * w + (2 * x + i).min(w - 1)];
                let alpha = u32::from(texel[3]);
                (0..3).for_each(|c| sum[c] += u32::from(texel[c]) * alpha);
                sum[3] += alpha;
            }
            let colour = |c: usize| ((sum[c] + sum[3] / 2) / sum[3].max(1)) as u8;
            px.push([colour(0), colour(1), colour(2), (sum[3] / 4) as u8]);
        }
    }
    Level { size, px }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_away_a_texture_is_its_mean_and_it_repeats() {
        let checks = Raster::from_fn([8, 6], |x, y| if (x + y) % 2 == 0 { [200u8; 3] } else { [100; 3] });
        let texture = Texture::opaque(&checks);
        let mean = texture.light(0.3, 0.7, 1.0);
        assert!((mean[0] - to_linear(150.0 / 255.0)).abs() < 0.01, "{mean:?}");
        let (here, there) = (texture.light(0.2, 0.4, 0.0), texture.light(3.2, -1.6, 0.0));
        assert!(here.iter().zip(there).all(|(a, b)| (a - b).abs() < 1e-4), "{here:?} {there:?}");
        assert!(!texture.cut_out);
    }
}
