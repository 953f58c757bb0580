//! What the crops' scenes are painted on: surfaces with places that are covered and places that are not.

use super::chance::hash;
use plenoscope::field::color::linear_from_srgb;

/// Photo pixels from the middle of a sprite to its border.
pub const HALF: f32 = 350.0;
/// Sprite pixels for each pixel of the photo.
const FINE: f32 = 2.0;
const SIDE: usize = (2.0 * HALF * FINE) as usize;

/// Smooth noise −1 … 1 whose hills are `wave` pixels apart.
pub fn noise([x, y]: [f32; 2], wave: f32, seed: u32) -> f32 {
    let (x, y) = (x / wave, y / wave);
    let corner = |dx: f32, dy: f32| hash((x.floor() + dx) as i32, (y.floor() + dy) as i32, seed);
    let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
    let (tx, ty) = (smooth(x - x.floor()), smooth(y - y.floor()));
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    2.0 * mix(mix(corner(0.0, 0.0), corner(1.0, 0.0), tx), mix(corner(0.0, 1.0), corner(1.0, 1.0), tx), ty) - 1.0
}

/// One surface: stored colours, of alpha 0 or 255, around the middle of a scene.
pub struct Sprite {
    rgba: Vec<[u8; 4]>,
}

impl Sprite {
    /// Covered where `color` gives one: stored values 0 … 1.
    pub fn painted(color: impl Fn([f32; 2]) -> Option<[f32; 3]>) -> Self {
        let mut sprite = Self { rgba: vec![[0; 4]; SIDE * SIDE] };
        for (i, pixel) in sprite.rgba.iter_mut().enumerate() {
            if let Some(color) = color(place([i % SIDE, i / SIDE])) {
                *pixel = stored(color);
            }
        }
        sprite
    }

    /// Draws a line that goes from `width[0]` pixels at its start to `width[1]` at its end.
    pub fn stroke(&mut self, way: &[[f32; 2]], width: [f32; 2], color: [f32; 3]) {
        let parts = (way.len() - 1) as f32;
        for (n, pair) in way.windows(2).enumerate() {
            let radius = |at: f32| (width[0] + (width[1] - width[0]) * (n as f32 + at) / parts) / 2.0;
            self.line([pair[0], pair[1]], [radius(0.0), radius(1.0)], color);
        }
    }

    fn line(&mut self, [a, b]: [[f32; 2]; 2], radius: [f32; 2], color: [f32; 3]) {
        let widest = radius[0].max(radius[1]);
        let bound = |axis: usize, sign: f32| {
            let far = if sign > 0.0 { a[axis].max(b[axis]) } else { a[axis].min(b[axis]) };
            ((far + sign * widest + HALF) * FINE).clamp(0.0, SIDE as f32 - 1.0) as usize
        };
        let along = [b[0] - a[0], b[1] - a[1]];
        let length2 = (along[0].powi(2) + along[1].powi(2)).max(1e-6);
        for y in bound(1, -1.0)..=bound(1, 1.0) {
            for x in bound(0, -1.0)..=bound(0, 1.0) {
                let p = place([x, y]);
                let t = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / length2;
                let t = t.clamp(0.0, 1.0);
                let away = (p[0] - a[0] - t * along[0]).hypot(p[1] - a[1] - t * along[1]);
                if away <= radius[0] + (radius[1] - radius[0]) * t {
                    self.rgba[y * SIDE + x] = stored(color);
                }
            }
        }
    }

    /// Linear light at a place, if it is covered there. Beyond the border there is what is within, mirrored.
    #[inline]
    pub fn at(&self, [x, y]: [f32; 2]) -> Option<[f32; 3]> {
        let inside = |at: f32| {
            let at = (((at + HALF) * FINE).floor() as i32).rem_euclid(2 * SIDE as i32) as usize;
            at.min(2 * SIDE - 1 - at)
        };
        let [r, g, b, a] = self.rgba[inside(y) * SIDE + inside(x)];
        (a > 0).then(|| [r, g, b].map(|v| LINEAR.with(|table| table[usize::from(v)])))
    }
}

thread_local! {
    static LINEAR: [f32; 256] = std::array::from_fn(|v| linear_from_srgb(v as f32 / 255.0));
}

fn place([x, y]: [usize; 2]) -> [f32; 2] {
    [x, y].map(|at| (at as f32 + 0.5) / FINE - HALF)
}

fn stored(color: [f32; 3]) -> [u8; 4] {
    let [r, g, b] = color.map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
    [r, g, b, 255]
}
