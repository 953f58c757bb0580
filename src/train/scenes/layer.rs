//! Layers of a scene, and the views and exact ray depths that they give.
//!
//! A layer has colour, coverage and a disparity map in the reference view's frame. A view's ray at pixel x meets the
//! layer where `d = D(x + u·d)`; the view shows the layer's colour there. Layers are composed from far to near, and
//! the ray depth is that of the nearest layer that covers more than half. So views, ray depths and what is hidden
//! behind every edge are exact.

use plenoscope::field::bilinear;

use super::raster::Raster;

/// One layer on the scene's canvas.
pub struct Layer {
    /// Colour times coverage, and coverage, 0 … 1.
    pub rgba: Raster<[f32; 4]>,
    /// Disparity in pixels per view step.
    pub disparity: Raster<f32>,
    /// Left, top, right, bottom of what is covered.
    pub bounds: [usize; 4],
    /// The map is not smooth: rays are followed through it from near to far instead of by two steps of iteration.
    pub rough: bool,
}

impl Layer {
    /// A layer that covers the whole canvas.
    pub fn whole(rgb: Raster<[f32; 3]>, disparity: Raster<f32>, rough: bool) -> Self {
        let size = rgb.size;
        let rgba = rgb.map(|c| [c[0], c[1], c[2], 1.0]);
        Self { rgba, disparity, bounds: [0, 0, size[0], size[1]], rough }
    }

    fn range(&self) -> [f32; 2] {
        self.disparity.px.iter().fold([f32::MAX, f32::MIN], |[lo, hi], &d| [lo.min(d), hi.max(d)])
    }
}

/// Layers from far to near on one canvas, which is larger than the picture by `margin` on every side.
pub struct Scene {
    /// Far to near; the first one covers everything.
    pub layers: Vec<Layer>,
    /// Pixels around the picture that views may look into.
    pub margin: usize,
    /// Width and height of the picture.
    pub size: [usize; 2],
}

/// One rendered view.
pub struct Rendered {
    /// Straight sRGB 0 … 1, `[y, x]`.
    pub rgb: Vec<[f32; 3]>,
    /// Ray depth in pixels per view step, `[y, x]`.
    pub disparity: Vec<f32>,
}

impl Scene {
    /// The view `(du, dv)` steps to the right of and below the reference view.
    pub fn view(&self, du: f32, dv: f32) -> Rendered {
        let count = self.size[0] * self.size[1];
        let mut out = Rendered { rgb: vec![[0.0; 3]; count], disparity: vec![0.0; count] };
        for layer in &self.layers {
            self.compose(layer, du, dv, &mut out);
        }
        out
    }

    fn compose(&self, layer: &Layer, du: f32, dv: f32, out: &mut Rendered) {
        let range = layer.range();
        let reach = |step: f32| (step * range[0]).abs().max((step * range[1]).abs()).ceil() as usize + 1;
        let [w, h] = self.size;
        let [l, t, r, b] = layer.bounds;
        let (reach_x, reach_y) = (reach(du), reach(dv));
        let columns = l.saturating_sub(reach_x).max(self.margin)..(r + reach_x).min(w + self.margin);
        let rows = t.saturating_sub(reach_y).max(self.margin)..(b + reach_y).min(h + self.margin);
        let ray = Ray::new(layer, [du, dv], range);
        for y in rows {
            for x in columns.clone() {
                let d = ray.disparity(x as f32, y as f32);
                let texel = layer.rgba.tap(x as f32 + du * d, y as f32 + dv * d);
                if texel[3] <= 0.002 {
                    continue;
                }
                let i = (y - self.margin) * w + x - self.margin;
                let rgb = &mut out.rgb[i];
                *rgb = std::array::from_fn(|c| texel[c] + (1.0 - texel[3]) * rgb[c]);
                if texel[3] > 0.5 {
                    out.disparity[i] = d;
                }
            }
        }
    }
}

/// Finds where the rays of one view meet one layer.
struct Ray<'a> {
    map: &'a Raster<f32>,
    step: [f32; 2],
    range: [f32; 2],
    /// Trial planes from near to far; 0 for smooth layers.
    planes: usize,
}

impl<'a> Ray<'a> {
    fn new(layer: &'a Layer, step: [f32; 2], range: [f32; 2]) -> Self {
        let longest = step[0].abs().max(step[1].abs());
        let moved = longest * (range[1] - range[0]);
        let planes = if layer.rough { (moved / 0.6).ceil() as usize } else { 0 };
        Self { map: &layer.disparity, step, range, planes }
    }

    #[inline(always)]
    fn tap(&self, x: f32, y: f32, d: f32) -> f32 {
        self.map.tap(x + self.step[0] * d, y + self.step[1] * d)
    }

    #[inline(always)]
    fn disparity(&self, x: f32, y: f32) -> f32 {
        if self.step == [0.0, 0.0] {
            return self.map.at(x as usize, y as usize);
        }
        if self.planes <= 1 {
            let mut d = self.map.at(x as usize, y as usize);
            for _ in 0..3 {
                d = self.tap(x, y, d);
            }
            return d;
        }
        self.march(x, y)
    }

    /// The nearest crossing: the first plane from near to far that the surface is not behind, then two secant steps.
    fn march(&self, x: f32, y: f32) -> f32 {
        let [far, near] = self.range;
        let mut above = (near, self.tap(x, y, near) - near);
        if above.1 >= 0.0 {
            return near;
        }
        let mut below = (far, 0.0);
        for plane in 1..=self.planes {
            let d = near + (far - near) * plane as f32 / self.planes as f32;
            let gap = self.tap(x, y, d) - d;
            if gap >= 0.0 {
                below = (d, gap);
                break;
            }
            above = (d, gap);
        }
        for _ in 0..2 {
            let d = above.0 + (below.0 - above.0) * above.1 / (above.1 - below.1).min(-1e-9);
            let gap = self.tap(x, y, d) - d;
            if gap >= 0.0 { below = (d, gap) } else { above = (d, gap) }
        }
        above.0 + (below.0 - above.0) * above.1 / (above.1 - below.1).min(-1e-9)
    }
}

/// Bilinear tap of a picture, for tests and for checks of what was rendered.
pub fn tap_rgb(rgb: &[[f32; 3]], size: [usize; 2], x: f32, y: f32) -> [f32; 3] {
    bilinear(size, x, y, |i| rgb[i])
}
