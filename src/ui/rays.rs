//! The ray depths of what is open, and what they say about the scene.

use std::sync::Arc;

use crate::field::{DisparityMap, Lens, RayDepths, Strength, ViewIndex, ViewPoint};
use crate::scene::{Edit, Focus, Salience, focus, layers};

/// Ray depths with what they say about the scene.
#[derive(Clone, Debug)]
pub struct Rays {
    /// The disparity of every ray.
    pub depths: Arc<RayDepths>,
    /// Those of the reference view.
    reference: Arc<DisparityMap>,
    /// What they say.
    pub survey: Arc<Survey>,
}

impl Rays {
    /// Looks over ray depths of strength 1. Takes some milliseconds, so it is not for the window's thread.
    pub fn new(depths: Arc<RayDepths>, salience: &Salience) -> Self {
        let subject = focus::subject(&depths.reference_map(), salience);
        Self::about(depths, subject)
    }

    /// Ray depths of any strength, of which it is known where their subject is.
    pub fn about(depths: Arc<RayDepths>, subject: [f32; 2]) -> Self {
        let reference = Arc::new(depths.reference_map());
        let survey = Arc::new(Survey::new(&depths, subject));
        Self { depths, reference, survey }
    }

    /// The lens of an edit while there is no scene yet, in pixels of the views' width.
    pub fn lens(&self, edit: &Edit) -> Lens {
        match edit.focus {
            Focus::Subject => {
                Edit { focus: Focus::At(self.survey.subject), ..edit.clone() }.lens(&self.reference, Strength::AS_MADE)
            }
            _ => edit.lens(&self.reference, Strength::AS_MADE),
        }
    }

    /// Where in the reference view the point lies that is seen at a place of a view: `x + (u − u0)·D` ([`crate::field`]).
    pub fn place_in_reference(&self, view: ViewIndex, place: [f32; 2]) -> [f32; 2] {
        let ([w, h], step) = (self.depths.size(), self.depths.grid().offset(view));
        let disparity_px = self.disparity_at(view, place);
        let x = place[0] + step.du * disparity_px / w as f32;
        let y = place[1] + step.dv * disparity_px / h as f32;
        [x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)]
    }

    /// Where a point of the reference view is seen from a viewpoint: the inverse of [`Rays::place_in_reference`].
    pub fn place_from_reference(&self, eye: ViewPoint, place: [f32; 2]) -> [f32; 2] {
        let [w, h] = self.depths.size();
        let disparity_px = self.disparity_at(self.depths.grid().reference(), place);
        [place[0] - eye.0.du * disparity_px / w as f32, place[1] - eye.0.dv * disparity_px / h as f32]
    }

    /// The disparity at a place of a view, x and y from 0 to 1, in pixels per view step.
    pub fn disparity_at(&self, view: ViewIndex, place: [f32; 2]) -> f32 {
        focus::median_at(self.depths.size(), place, |x, y| self.depths.at(view, x, y))
    }
}

/// What the ray depths say about a scene.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Disparities between which almost all rays lie, far and near, with a little room.
    pub range_px: [f32; 2],
    /// Share of the reference view's rays in each of [`Survey::BINS`] equal steps of the range; the largest is 1.
    pub bins: Vec<f32>,
    /// Disparities of the depth layers, from the nearest to the farthest.
    pub layers_px: Vec<f32>,
    /// For each view, how much of it the reference view has seen (the rest was invented), 0 … 1, in `[v, u]` order.
    pub seen: Vec<f32>,
    /// Where the subject most likely is in the reference view, x and y from 0 to 1.
    pub subject: [f32; 2],
}

impl Survey {
    /// Bars of the histogram.
    pub const BINS: usize = 96;
    /// Rays that are looked at in each direction.
    const SAMPLES: u32 = 64;
    /// Disparity by which two rays may differ and still be one point.
    const SAME_POINT_PX: f32 = 0.15;

    fn new(depths: &RayDepths, subject: [f32; 2]) -> Self {
        let mut sorted: Vec<f32> = depths.reference().iter().copied().filter(|d| d.is_finite()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |share: f32| sorted.get(((sorted.len().max(1) - 1) as f32 * share) as usize).copied().unwrap_or(0.0);
        let (far, near) = (at(0.002), at(0.998));
        let room = ((near - far) * 0.08).max(0.05);
        let range_px = [far - room, near + room];
        let mut counts = vec![0u32; Self::BINS];
        for d in &sorted {
            let place = (d - range_px[0]) / (range_px[1] - range_px[0]) * Self::BINS as f32;
            if let Some(count) = counts.get_mut(place.max(0.0) as usize) {
                *count += 1;
            }
        }
        let most = counts.iter().copied().max().unwrap_or(1).max(1) as f32;
        // The square root keeps small things visible beside a large wall.
        let bins = counts.into_iter().map(|count| (count as f32 / most).sqrt()).collect();
        let seen = depths.grid().views().map(|view| Self::seen(depths, view)).collect();
        let layers_px = layers::layers(&sorted);
        Self { range_px, bins, layers_px, seen, subject }
    }

    fn seen(depths: &RayDepths, view: ViewIndex) -> f32 {
        let (grid, [w, h]) = (depths.grid(), depths.size());
        let step = grid.offset(view);
        let zero = grid.reference();
        let (nx, ny) = (Self::SAMPLES.min(w), Self::SAMPLES.min(h));
        let mut same = 0;
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            let (x, y) = (i * w / nx, j * h / ny);
            let d = depths.at(view, x, y);
            let to = |p: u32, s: f32, n: u32| (p as f32 + s * d).round().clamp(0.0, (n - 1) as f32) as u32;
            let there = depths.at(zero, to(x, step.du, w), to(y, step.dv, h));
            same += u32::from((there - d).abs() < Self::SAME_POINT_PX);
        }
        same as f32 / (nx * ny) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::ViewGrid;

    #[test]
    fn a_flat_scene_is_seen_whole_and_a_step_is_not() {
        let flat = RayDepths::new(ViewGrid::PAPER, [20, 10], vec![0.5; 64 * 200]).unwrap();
        let survey = Survey::new(&flat, [0.5; 2]);
        assert!(survey.seen.iter().all(|&share| share == 1.0));
        assert!(survey.range_px[0] < 0.5 && survey.range_px[1] > 0.5);
        assert_eq!(survey.bins.iter().copied().fold(0.0, f32::max), 1.0);

        let step: Vec<f32> = (0..64 * 200).map(|i| if i % 20 < 10 { -2.0 } else { 2.0 }).collect();
        let survey = Survey::new(&RayDepths::new(ViewGrid::PAPER, [20, 10], step).unwrap(), [0.5; 2]);
        assert_eq!(survey.seen[ViewGrid::PAPER.layer_from_view(ViewGrid::PAPER.reference())], 1.0);
        assert!(survey.seen[ViewGrid::PAPER.layer_from_view(ViewIndex { v: 4, u: 0 })] < 0.9);
    }
}
