//! Crops of real light fields, at the depth that their views tell.

use super::place::Tone;
use super::raster::Raster;
use super::{Kind, REFERENCE, Sample, Source, add_noise};
use crate::rng::Rng;

impl Source {
    /// A crop of one light field. It is mirrored only where every view has its mirror image in the grid (u − 4 ↔ 4 − u).
    pub(super) fn real(&self, rng: &mut Rng, crop: [usize; 2], views: Vec<usize>) -> Sample {
        let field = &self.library.fields[rng.below(self.library.fields.len())];
        let [w, h] = field.views[0].size;
        let left = rng.below(w.saturating_sub(crop[0]) + 1);
        let top = rng.below(h.saturating_sub(crop[1]) + 1);
        let flip = rng.chance(0.5) && views.iter().all(|layer| layer % 8 != 0);
        let tone = Tone::random(rng, self.config.variety);
        let mut rgb = Vec::with_capacity(views.len() * 3 * crop[0] * crop[1]);
        let across = |x: usize| (left + if flip { crop[0] - 1 - x } else { x }).min(w - 1);
        for &layer in &views {
            let (u, v) = (layer % 8, layer / 8);
            let view = &field.views[8 * v + if flip { 8 - u } else { u }];
            let cut = Raster::from_fn(crop, |x, y| view.at(across(x), (top + y).min(h - 1)).map(f32::from));
            let cut = tone.apply(&cut);
            (0..3).for_each(|c| rgb.extend(cut.px.iter().map(|texel| texel[c])));
        }
        add_noise(rng, &mut rgb, &self.config);
        let depth = Raster::from_fn(crop, |x, y| field.disparity.at(across(x), (top + y).min(h - 1)));
        let unknown = vec![f32::NAN; depth.px.len()];
        let of_view = |&layer: &usize| if layer == REFERENCE { &depth.px } else { &unknown };
        let disparity = views.iter().flat_map(of_view).copied().collect();
        let along = |at: usize, all: usize| 2.0 * at as f32 / (all.max(2) - 1) as f32 - 1.0;
        let (x0, x1) = (along(left, w), along(left + crop[0] - 1, w));
        let [x0, x1] = if flip { [-x1, -x0] } else { [x0, x1] };
        let yx = [along(top, h), along(top + crop[1] - 1, h), x0, x1];
        let origin = field.name.clone();
        Sample { size: crop, views, rgb, disparity, subject: None, yx, kind: Kind::Real, origin, worth: 1.0 }
    }
}
