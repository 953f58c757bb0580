//! Windows of real light fields, near and wide, at the depth that their views tell.

use super::place::Tone;
use super::raster::Raster;
use super::{Kind, REFERENCE, Sample, Source, add_noise};
use crate::rng::Rng;

impl Source {
    /// A window of one light field, up to the whole, as large as a crop. It is mirrored only where every view has its
    /// mirror image in the grid (u − 4 ↔ 4 − u).
    pub(super) fn real(&self, rng: &mut Rng, crop: [usize; 2], views: Vec<usize>) -> Sample {
        let field = &self.library.fields[rng.below(self.library.fields.len())];
        let whole = field.disparity.size;
        let most = (whole[0] as f32 / crop[0] as f32).min(whole[1] as f32 / crop[1] as f32);
        // A crop's pixel is this many of the views'; none is enlarged where that can be helped.
        let zoom = most.powf(if self.config.augment && most > 1.0 { rng.range(0.0, 1.0) } else { 1.0 });
        let window = [0, 1].map(|axis| ((crop[axis] as f32 * zoom).round() as usize).clamp(1, whole[axis]));
        let left = rng.below(whole[0] - window[0] + 1);
        let top = rng.below(whole[1] - window[1] + 1);
        let flip = rng.chance(0.5) && views.iter().all(|layer| layer % 8 != 0);
        let tone = Tone::random(rng, self.config.variety);
        let across = |x: usize| left + if flip { window[0] - 1 - x } else { x };
        let mut rgb = Vec::with_capacity(views.len() * 3 * crop[0] * crop[1]);
        for &layer in &views {
            let (u, v) = (layer % 8, layer / 8);
            let view = &field.views[8 * v + if flip { 8 - u } else { u }];
            let cut = Raster::from_fn(window, |x, y| view.at(across(x), top + y).map(f32::from)).resized(crop);
            let cut = tone.apply(&cut);
            (0..3).for_each(|c| rgb.extend(cut.px.iter().map(|texel| texel[c])));
        }
        add_noise(rng, &mut rgb, &self.config);
        let depth = Raster::from_fn(window, |x, y| [field.disparity.at(across(x), top + y) / zoom]).resized(crop);
        let unknown = vec![f32::NAN; depth.px.len()];
        let of_view = |&layer: &usize| if layer == REFERENCE { depth.px.as_flattened() } else { &unknown };
        let disparity = views.iter().flat_map(of_view).copied().collect();
        let along = |at: usize, all: usize| 2.0 * at as f32 / (all.max(2) - 1) as f32 - 1.0;
        let [[x0, x1], [y0, y1]] =
            [0, 1].map(|axis| [0, window[axis] - 1].map(|end| along([left, top][axis] + end, whole[axis])));
        let [x0, x1] = if flip { [-x1, -x0] } else { [x0, x1] };
        let yx = [y0, y1, x0, x1];
        let origin = field.name.clone();
        Sample { size: crop, views, rgb, disparity, subject: None, yx, kind: Kind::Real, origin, worth: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Config, Field, Library};
    use super::*;

    const SLOPE: f32 = 0.6;

    /// A plane: view(v, u)[x, y] = reference[x + (u − 4)·D, y + (v − 4)·D].
    fn plane() -> Source {
        let pattern = |x: f32, y: f32| [0.0, 2.0, 4.0].map(|c| 128.0 + 90.0 * (0.12 * x + 0.08 * y + c).sin());
        let view = |v: usize, u: usize| {
            let [dx, dy] = [u, v].map(|i| SLOPE * (i as f32 - 4.0));
            Raster::from_fn([96, 72], |x, y| pattern(x as f32 + dx, y as f32 + dy).map(|c| c as u8))
        };
        let views = (0..64).map(|layer| view(layer / 8, layer % 8)).collect();
        let disparity = Raster::from_fn([96, 72], |_, _| SLOPE);
        let fields = vec![Field { name: "plane".into(), views, disparity }];
        let config = Config { long_side: 48, crop: [40, 32], noise: false, ..Config::default() };
        Source::from_library(&config, Library { fields, ..Library::default() })
    }

    #[test]
    fn windows_come_near_and_wide_with_the_ray_depth_of_their_pixels() {
        let source = plane();
        let mut slopes = Vec::new();
        for seed in 0..20 {
            let sample = source.real(&mut Rng::new(seed, 0), [40, 32], vec![36, 39]);
            let slope = sample.disparity[0];
            assert!(sample.disparity[..1280].iter().all(|d| (d - slope).abs() < 1e-4));
            let plane = |view: usize| Raster { size: [40, 32], px: sample.rgb[view * 3 * 1280..][..1280].to_vec() };
            let (reference, beside) = (plane(0), plane(1));
            for (x, y) in [(6, 5), (20, 16), (33, 28)] {
                let tapped = reference.tap(x as f32 + 3.0 * slope, y as f32);
                assert!((beside.at(x, y) - tapped).abs() < 0.03, "{seed}: {} {tapped}", beside.at(x, y));
            }
            slopes.push(slope);
        }
        slopes.sort_by(f32::total_cmp);
        // From the whole picture (72 rows on 32) to its own pixels.
        assert!(slopes[0] < 0.32 && slopes[0] > 0.26 && slopes[19] > 0.5 && slopes[19] <= 0.61, "{slopes:?}");
    }
}
