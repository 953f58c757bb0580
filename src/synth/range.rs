//! From what a source knows of depth to disparities: how deep the scene is, and what lies at the focal plane.
//!
//! *Relative* depth is stretched: its 2nd and 98th percentile become the usual range. A thing that is nearly flat, as far
//! as its numbers tell, is not: it keeps its share. Sky lies at the far end and has no say in the percentiles.
//! *Metric* depth is that of a real camera: `D = f·b·(1/z − 1/z_f)` px per view step, `f` the focal length in pixels of
//! the map and `b = f/28` the baseline of a step on full frame, as the paper's views are f/28.

use crate::field::{DisparityMap, FieldError, RelativeDepth, sides};

/// A scene whose far end is this much less near than its near end (as a part of it) is given the whole range.
const DEEP: f32 = 0.25;
/// Share of exact zeros from which they are a nearness net's sky, and no chance.
const SKY_SHARE: f32 = 0.005;
/// Share of the pixels that may lie outside the range at either end.
const TAIL: f32 = 0.02;
/// Focal length on 35-mm film where neither photo nor net tell it.
pub const USUAL_F35_MM: f32 = 28.0;
/// The least and greatest focal length that are believed.
pub const F35_MM: [f32; 2] = [8.0, 400.0];
/// Distances of the focal plane that are believed, in metres.
const FOCUS_M: [f32; 2] = [0.05, 1000.0];
/// Width of a frame of 35-mm film, and views of f/28 across an aperture of 1.
pub const FILM_M: f32 = 0.036;
/// See [`FILM_M`].
pub const VIEWS: f32 = 28.0;
/// Metric disparities are cut at this many times the usual range.
const WIDEST: f32 = 4.0;

/// What nearness means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Geometry {
    /// Inverse depth up to scale and shift.
    #[default]
    Relative,
    /// Inverse metres.
    Metric {
        /// Focal length in pixels of the map, where the source tells it.
        focal_px: Option<f32>,
    },
}

/// What a source of depth answers, a net or a phone.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Larger is nearer.
    pub nearness: RelativeDepth,
    /// Where the sky is, `[y, x]` of the map's size.
    pub sky: Option<Vec<bool>>,
    /// What the numbers mean.
    pub geometry: Geometry,
}

/// What the photo's file says of the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Camera {
    /// Focal length as on 35-mm film, in millimetres.
    pub f35_mm: Option<f32>,
    /// Distance of the subject, in metres.
    pub focus_m: Option<f32>,
}

/// How disparity and distance hang together in metric depth: `D = gain·(1/z − nearness)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// Disparity of one inverse metre, as a share of the picture's width.
    pub gain: f32,
    /// Inverse metres of what has disparity 0.
    pub nearness: f32,
    /// Focal length as on 35-mm film, in millimetres.
    pub f35_mm: f32,
}

impl Estimate {
    /// Depth that only orders.
    pub fn relative(nearness: RelativeDepth) -> Self {
        Self { nearness, sky: None, geometry: Geometry::Relative }
    }

    /// Inverse metres.
    pub fn metric(nearness: RelativeDepth, focal_px: Option<f32>) -> Self {
        Self { nearness, sky: None, geometry: Geometry::Metric { focal_px } }
    }

    /// The same with a mask of the sky, `[y, x]`.
    #[must_use]
    pub fn with_sky(self, sky: Vec<bool>) -> Self {
        Self { sky: Some(sky), ..self }
    }

    /// The same with the exact zeros of a nearness net as sky, where they are no chance.
    #[must_use]
    pub fn with_zeros_as_sky(self) -> Self {
        let values = self.nearness.nearness();
        let sky: Vec<bool> = values.iter().map(|n| *n == 0.0).collect();
        let share = sky.iter().filter(|is_sky| **is_sky).count() as f32 / sky.len().max(1) as f32;
        let is_sky = share > SKY_SHARE && share < 1.0 - SKY_SHARE && values.iter().all(|n| *n >= 0.0);
        if is_sky { self.with_sky(sky) } else { self }
    }

    /// Disparities at the map's own width. `range_px` are those of the far and near end, where the model says them.
    ///
    /// # Errors
    /// Values beyond all measure.
    pub fn disparity(&self, camera: &Camera, range_px: Option<[f32; 2]>) -> Result<DisparityMap, FieldError> {
        match (self.metric_scale(camera, range_px), range_px) {
            (Some(metric), _) => self.of_camera(metric),
            (None, Some(range_px)) => self.stretched(range_px),
            (None, None) => {
                let usual = RelativeDepth::usual_range_px(self.nearness.size()[0]);
                self.stretched(usual.map(|px| px * self.relief()))
            }
        }
    }

    /// How disparity and distance hang together; none where the source only orders, or a range is given for it.
    pub fn metric_scale(&self, camera: &Camera, range_px: Option<[f32; 2]>) -> Option<Metric> {
        let (Geometry::Metric { focal_px }, None) = (self.geometry, range_px) else { return None };
        let size = self.nearness.size();
        let long = size[0].max(size[1]) as f32;
        let believed = |mm: &f32| (F35_MM[0]..=F35_MM[1]).contains(mm);
        let by_net = || focal_px.map(|px| px / long * FILM_M * 1000.0).filter(believed);
        let f35_mm = camera.f35_mm.filter(believed).or_else(by_net).unwrap_or(USUAL_F35_MM);
        let focus_m = camera.focus_m.filter(|m| (FOCUS_M[0]..=FOCUS_M[1]).contains(m));
        let nearness = focus_m.map_or_else(|| self.middle(), f32::recip);
        let f35_m = f35_mm / 1000.0;
        let gain = long / size[0] as f32 * f35_m / FILM_M * f35_m / VIEWS;
        Some(Metric { gain, nearness, f35_mm })
    }

    /// Disparities of a real lens.
    fn of_camera(&self, Metric { gain, nearness, .. }: Metric) -> Result<DisparityMap, FieldError> {
        let size = self.nearness.size();
        let [far, near] = RelativeDepth::usual_range_px(size[0]).map(|px| px * WIDEST);
        let px = |(i, n): (usize, &f32)| {
            let n = if self.is_sky(i) || !n.is_finite() { 0.0 } else { *n };
            (gain * size[0] as f32 * (n - nearness)).clamp(far, near)
        };
        DisparityMap::new(size, self.nearness.nearness().iter().enumerate().map(px).collect())
    }

    /// The order over a range; what lies outside the percentiles is cut, the sky is far.
    fn stretched(&self, [far, near]: [f32; 2]) -> Result<DisparityMap, FieldError> {
        let size = self.nearness.size();
        let [low, high] = self.ends();
        let scale = (near - far) / (high - low);
        if low >= high || !scale.is_finite() {
            return Ok(DisparityMap::constant(size, 0.0));
        }
        let px = |(i, n): (usize, &f32)| match self.is_sky(i) || !n.is_finite() {
            true => far,
            false => (far + (n - low) * scale).clamp(far, near),
        };
        DisparityMap::new(size, self.nearness.nearness().iter().enumerate().map(px).collect())
    }

    /// How deep the scene is, 0 … 1: what lies at its far end is nearly as near as the near end where it is flat. Only
    /// positive numbers tell: others have a shift.
    fn relief(&self) -> f32 {
        let [low, high] = self.ends();
        let tells = low > 0.0 && self.sky.is_none();
        if tells { ((high - low) / high / DEEP).min(1.0) } else { 1.0 }
    }

    /// The percentiles at the far and at the near end.
    fn ends(&self) -> [f32; 2] {
        let known = self.known(|_| true);
        let at = |share: f32| known.get((share * (known.len().max(1) - 1) as f32) as usize).copied().unwrap_or(0.0);
        [at(TAIL), at(1.0 - TAIL)]
    }

    /// Median nearness of the middle third of the picture, where the subject is taken to be.
    fn middle(&self) -> f32 {
        let [w, h] = sides(self.nearness.size());
        let inside = |i: usize, n: usize| (n / 3..=2 * n / 3).contains(&i);
        let middle = self.known(|i| inside(i % w, w) && inside(i / w, h));
        middle.get(middle.len() / 2).copied().unwrap_or(0.0)
    }

    /// All that is no sky and known, from far to near.
    fn known(&self, wanted: impl Fn(usize) -> bool) -> Vec<f32> {
        let all = self.nearness.nearness().iter().enumerate();
        let mut known: Vec<f32> =
            all.filter(|(i, n)| n.is_finite() && !self.is_sky(*i) && wanted(*i)).map(|(_, n)| *n).collect();
        known.sort_by(f32::total_cmp);
        known
    }

    fn is_sky(&self, i: usize) -> bool {
        self.sky.as_ref().and_then(|sky| sky.get(i)).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(values: Vec<f32>) -> RelativeDepth {
        RelativeDepth::new([values.len() as u32, 1], values).unwrap()
    }

    fn disparity(estimate: &Estimate) -> DisparityMap {
        estimate.disparity(&Camera::default(), None).unwrap()
    }

    #[test]
    fn nearness_is_stretched_and_outliers_are_cut() {
        let mut nearness: Vec<f32> = (0..=100).map(|n| n as f32).collect();
        nearness[100] = 1e6;
        let map = Estimate::relative(depth(nearness)).disparity(&Camera::default(), Some([-1.0, 1.0])).unwrap();
        assert_eq!([0, 2, 98, 100].map(|x| map.at(x, 0)), [-1.0, -1.0, 1.0, 1.0]);
        assert!(map.at(50, 0).abs() < 1e-6);
    }

    #[test]
    fn a_flat_wall_stays_flat_and_a_deep_scene_has_the_usual_range() {
        let over = |low: f32| Estimate::relative(depth((0..540).map(|i| low + i as f32 / 539.0).collect()));
        let spread = |estimate: &Estimate| disparity(estimate).range_px().map(f32::abs).iter().sum::<f32>();
        assert!((spread(&over(0.1)) - 1.8).abs() < 1e-3);
        assert!(spread(&over(50.0)) < 0.15);
        assert_eq!(disparity(&Estimate::relative(depth(vec![3.0; 9]))).range_px(), [0.0; 2]);
        // Below 0 there is an unknown shift, so that nothing tells how flat it is.
        assert!((spread(&over(-50.0)) - 1.8).abs() < 1e-3);
    }

    #[test]
    fn the_sky_is_far_and_leaves_the_range_to_the_rest() {
        let ground = |i: usize| 4.0 + i as f32 / 100.0;
        let values = (0..500).map(|i| if i < 300 { 0.0 } else { ground(i) }).collect();
        let map = disparity(&Estimate::relative(depth(values)).with_zeros_as_sky());
        let [far, near] = RelativeDepth::usual_range_px(500);
        assert_eq!(map.at(10, 0), far);
        assert!((map.at(400, 0) - (far + near) / 2.0).abs() < 0.02 * (near - far));
    }

    #[test]
    fn metres_become_what_a_real_lens_would_see() {
        // 50 mm on full frame, 1080 px wide: 1500 px of focal length, 1.79 mm a step.
        let values = (0..1080).map(|i| if i < 540 { 1.0 } else { 0.5 }).collect();
        let estimate = Estimate::metric(depth(values), Some(99.0));
        let camera = Camera { f35_mm: Some(50.0), focus_m: Some(2.0) };
        let map = estimate.disparity(&camera, None).unwrap();
        assert!((map.at(0, 0) - 1500.0 * 0.05 / 28.0 * 0.5).abs() < 1e-3);
        assert!(map.at(1079, 0).abs() < 1e-6);
        for odd in [0.0, f32::NAN, 1e9, -3.0] {
            let camera = Camera { f35_mm: Some(odd), focus_m: Some(odd) };
            let [low, high] = estimate.disparity(&camera, None).unwrap().range_px();
            assert!(low >= -8.0 && high <= 8.0, "{odd} makes {low} … {high}");
        }
    }
}
