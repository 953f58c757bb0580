//! How much of a picture was seen, and how much was invented.
//!
//! A ray of a photo's light field was invented where it ends behind what the photo sees, or beside it: the far side or the
//! occlusion net filled it (paper, §3.3). And a ray is doubtful where the views disagree about its depth: the residual of
//! the paper's consistency term, `ψ_c = |D(x, u) − D(x + D(x, u), u − 1)|` (§3.1). A camera's own views invent nothing.
//! And an edge is doubtful about which two sources of depth disagree (`disagree`).

use rayon::prelude::*;

use super::{MadeViews, Scene, SceneError};
use crate::field::color::linear_from_srgb8;
use crate::field::{
    FNumber, Lens, Picture, Provenance, Raster, RayDepths, Seen, View, ViewGrid, ViewIndex, ViewPoint, ramp,
};

/// A surface hides a ray's end when it is nearer by this much, px per view step.
const HIDDEN_PX: f32 = 0.15;
/// Neighbouring views that differ by these about a ray's depth: not at all in doubt, and wholly, px per view step.
const APART_PX: [f32; 2] = [0.1, 0.4];
/// A ray that ends this far beside the photo, in pixels, shows what the photo does not.
const BESIDE_PX: f32 = 0.75;
/// Rays of a view that are looked at in each direction for its share.
const SAMPLES: u32 = 160;

/// The tint of what was invented, in linear light.
const AMBER: [f32; 3] = [0.81, 0.37, 0.04];

/// The share of a picture that may be invented where nobody says another.
pub const USUAL_LIMIT: f32 = 0.02;

/// What was seen of a light field.
#[derive(Clone, Copy, Debug)]
pub struct Trust<'a> {
    depths: &'a RayDepths,
    /// Whether other views than the reference view were made of it.
    is_made: bool,
    /// Where each ray comes from, where that is known.
    provenance: Option<&'a Provenance>,
    /// Where sources of depth disagree about an edge of the reference view.
    torn: Option<&'a Raster<f32>>,
}

/// For each view, the share of it that was invented, in `[v, u]` order.
#[derive(Clone, Debug, PartialEq)]
pub struct Invented {
    grid: ViewGrid,
    shares: Vec<f32>,
}

/// How far one can go before more of a picture is invented than one wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The widest opening within it.
    pub widest: FNumber,
    /// How far one can look in any direction, in view steps.
    pub reach: f32,
}

impl Invented {
    /// The share of a view, 0 … 1.
    pub fn of(&self, view: ViewIndex) -> f32 {
        self.shares[self.grid.layer_from_view(view)]
    }

    /// How far one can look and open before more than `limit` of the picture is invented.
    pub fn limits(&self, limit: f32) -> Limits {
        let steps: Vec<f32> = self.grid.views().map(|at| self.grid.offset(at).to_vec2().length()).collect();
        let beyond = steps.iter().zip(&self.shares).filter(|(_, share)| **share > limit).map(|(steps, _)| *steps);
        let farthest = steps.iter().copied().fold(0.0, f32::max);
        let reach = beyond.fold(f32::INFINITY, f32::min);
        let reach = if reach.is_finite() { (reach - 0.5).max(0.0) } else { farthest };
        Limits { widest: widest(&steps, &self.shares, limit), reach }
    }
}

/// A picture with amber laid over it where it is doubtful.
pub fn tinted(view: &View, doubt: &Raster<f32>) -> Picture {
    Picture::from_fn(view.size(), |x, y| {
        let [r, g, b, _] = view.pixel(x, y).map(linear_from_srgb8);
        let share = doubt.at(x as usize, y as usize).clamp(0.0, 1.0);
        // Grey beneath, so that the tint is told from what is amber itself.
        let grey = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        [(r, AMBER[0]), (g, AMBER[1]), (b, AMBER[2])].map(|(c, amber)| c + (0.25 * grey + 0.75 * amber - c) * share)
    })
}

impl Scene {
    /// What was seen of it.
    ///
    /// # Errors
    /// It has no views.
    pub fn trust(&self) -> Result<Trust<'_>, SceneError> {
        let MadeViews { depths, provenance, .. } = self.made_views()?;
        let is_made = self.subject().photo().is_some() && self.subject().splats().is_none();
        Ok(Trust { depths, is_made, provenance: provenance.as_deref(), torn: None })
    }
}

impl<'a> Trust<'a> {
    /// The same with edges of the reference view about which sources of depth disagree ([`Maker::disagreement`]), at
    /// the views' size. They are doubtful, and not invented.
    ///
    /// [`Maker::disagreement`]: super::Maker::disagreement
    #[must_use]
    pub fn with_torn_edges(self, torn: Option<&'a Raster<f32>>) -> Self {
        Self { torn: torn.filter(|torn| torn.size() == self.depths.size()), ..self }
    }

    /// How doubtful each ray of a view is: 0 seen, 1 invented.
    pub fn of_view(&self, view: ViewIndex) -> Raster<f32> {
        Raster::par_from_fn(self.depths.size(), |x, y| {
            let (x, y) = (x as u32, y as u32);
            self.doubt(view, x, y).max(self.torn_at(view, x, y))
        })
    }

    /// Whether a ray ends at an edge that sources of depth disagree about.
    fn torn_at(&self, view: ViewIndex, x: u32, y: u32) -> f32 {
        let Some(torn) = self.torn else { return 0.0 };
        let [x, y] = self.end(view, [x, y], self.depths.at(view, x, y));
        torn.at(clamped(x, torn.size()[0]) as usize, clamped(y, torn.size()[1]) as usize)
    }

    /// How doubtful each pixel of a picture of the views' size is: the mean over the rays that the lens gathers. `lens` is
    /// in pixels of that size.
    pub fn of_picture(&self, lens: &Lens, from: ViewPoint) -> Raster<f32> {
        let (grid, [w, h]) = (self.depths.grid(), self.depths.size());
        let radius = lens.f_number.added_views() / 2.0;
        let steps = |at: ViewIndex| grid.offset(at).to_vec2() - from.0.to_vec2();
        let mut gathered: Vec<ViewIndex> = grid.views().filter(|at| steps(*at).length() <= radius).collect();
        if gathered.is_empty() {
            gathered.push(grid.nearest(from.0));
        }
        let maps: Vec<(glam::Vec2, Raster<f32>)> =
            gathered.into_par_iter().map(|at| (steps(at), self.of_view(at))).collect();
        Raster::par_from_fn([w, h], |x, y| {
            let place = [(x as f32 + 0.5) / w as f32, (y as f32 + 0.5) / h as f32];
            let sharp = lens.focus.at(place[0], place[1]);
            let sum: f32 =
                maps.iter().map(|(step, map)| map.tap(x as f32 - step.x * sharp, y as f32 - step.y * sharp)).sum();
            sum / maps.len() as f32
        })
    }

    /// The share of a view that was invented, 0 … 1.
    pub fn share(&self, view: ViewIndex) -> f32 {
        let [w, h] = self.depths.size();
        let (nx, ny) = (SAMPLES.min(w), SAMPLES.min(h));
        let doubts = (0..nx * ny).map(|i| self.doubt(view, i % nx * w / nx, i / nx * h / ny));
        doubts.filter(|doubt| *doubt > 0.5).count() as f32 / (nx * ny) as f32
    }

    /// The share of every view that was invented.
    pub fn invented(&self) -> Invented {
        let grid = self.depths.grid();
        let views: Vec<ViewIndex> = grid.views().collect();
        Invented { grid, shares: views.into_par_iter().map(|at| self.share(at)).collect() }
    }

    /// 0 for a ray that was seen, 1 for one that was invented.
    fn doubt(&self, view: ViewIndex, x: u32, y: u32) -> f32 {
        let grid = self.depths.grid();
        if view == grid.reference() && self.is_made {
            return 0.0;
        }
        if let Some(provenance) = self.provenance {
            return f32::from(u8::from(provenance.at(view, x, y) == Seen::Invented));
        }
        let d = self.depths.at(view, x, y);
        if self.is_made && self.is_unseen(view, [x, y], d) { 1.0 } else { self.residual(view, [x, y], d) }
    }

    /// Where a ray ends in the reference view.
    fn end(&self, view: ViewIndex, [x, y]: [u32; 2], d: f32) -> [f32; 2] {
        let step = self.depths.grid().offset(view);
        [x as f32 + step.du * d, y as f32 + step.dv * d]
    }

    /// Whether a ray ends where the reference view does not see it.
    fn is_unseen(&self, view: ViewIndex, [x, y]: [u32; 2], d: f32) -> bool {
        let (grid, size) = (self.depths.grid(), self.depths.size());
        let end = self.end(view, [x, y], d);
        let is_beside = |axis: usize| end[axis] < -BESIDE_PX || end[axis] > size[axis] as f32 - 1.0 + BESIDE_PX;
        is_beside(0) || is_beside(1) || self.nearest(grid.reference(), end) > d + HIDDEN_PX
    }

    /// The consistency term's residual towards the reference view, as a doubt.
    fn residual(&self, view: ViewIndex, [x, y]: [u32; 2], d: f32) -> f32 {
        let zero = self.depths.grid().reference();
        let towards = |at: u8, to: u8| at.saturating_add_signed((to as i8 - at as i8).signum());
        let next = ViewIndex { v: towards(view.v, zero.v), u: towards(view.u, zero.u) };
        let step = |a: u8, b: u8| f32::from(a) - f32::from(b);
        // x_u = x − (u − u0)·D: one step back is D to the right.
        let place = [x as f32 + step(view.u, next.u) * d, y as f32 + step(view.v, next.v) * d];
        ramp(APART_PX[0], APART_PX[1], (self.nearest(next, place) - d).abs())
    }

    fn nearest(&self, view: ViewIndex, place: [f32; 2]) -> f32 {
        let size = self.depths.size();
        let [x, y] = [0, 1].map(|axis| clamped(place[axis], size[axis]));
        self.depths.at(view, x, y)
    }
}

/// The pixel of a place along a side.
fn clamped(at: f32, side: u32) -> u32 {
    at.round().clamp(0.0, (side - 1) as f32) as u32
}

/// The widest lens whose rays are invented by no more than the limit on average. Beyond the views what is hidden grows
/// with the opening.
fn widest(steps: &[f32], invented: &[f32], limit: f32) -> FNumber {
    let mean = |radius: f32| {
        let inside = steps.iter().zip(invented).filter(|(steps, _)| **steps <= radius);
        let (sum, count) = inside.fold((0.0, 0.0f32), |(sum, count), (_, share)| (sum + share, count + 1.0));
        sum / count.max(1.0)
    };
    let most = steps.iter().copied().fold(0.0, f32::max) / std::f32::consts::SQRT_2;
    let share = |radius: f32| if radius <= most || most == 0.0 { mean(radius) } else { mean(most) * radius / most };
    let radius = |f: f32| FNumber(f).added_views() / 2.0;
    // In steps of a fiftieth of the f-number, from closed to open.
    let stops = std::iter::successors(Some(FNumber::PHOTO.0), |f| Some(f / 1.02));
    let mut last = FNumber::PHOTO;
    for f in stops.take_while(|f| *f >= FNumber::WIDEST.0) {
        if share(radius(f)) > limit {
            return last;
        }
        last = FNumber(f);
    }
    FNumber::WIDEST
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::DisparityMap;
    use crate::synth::lift;

    /// A near post of a width before a far plane.
    fn post(width: u32, near: f32) -> RayDepths {
        let at = |i: u32| if (60..60 + width).contains(&(i % 160)) { near } else { -0.5 };
        lift::ray_depths(&DisparityMap::new([160, 40], (0..160 * 40).map(at).collect()).unwrap(), ViewGrid::PAPER)
    }

    #[test]
    fn what_comes_out_from_behind_a_post_is_invented_and_nothing_else() {
        let depths = post(40, 1.5);
        let trust = Trust { depths: &depths, is_made: true, provenance: None, torn: None };
        let view = ViewIndex { v: 4, u: 1 };
        let doubt = trust.of_view(view);
        // Three steps to the left the post is 3 · 2 px to the right of the plane behind it.
        let row: Vec<usize> = (4..156).filter(|x| doubt.at(*x, 20) > 0.5).collect();
        assert!((5..=8).contains(&row.len()), "{row:?}");
        assert!(row.windows(2).all(|pair| pair[1] == pair[0] + 1), "one strip beside the post: {row:?}");
        assert!(trust.of_view(ViewGrid::PAPER.reference()).pixels().iter().all(|doubt| *doubt == 0.0));
    }

    #[test]
    fn the_deeper_the_scene_the_sooner_the_limit_and_a_flat_one_has_none() {
        let flat = post(40, -0.5);
        let [flat, low, high] = [&flat, &post(40, 0.3), &post(40, 1.5)]
            .map(|depths| Trust { depths, is_made: true, provenance: None, torn: None }.invented().limits(USUAL_LIMIT));
        assert!(high.widest.0 > low.widest.0 && high.reach <= low.reach, "{high:?}\n{low:?}");
        assert!(low.reach <= flat.reach && flat.widest.0 <= low.widest.0);
        let deep = post(40, 1.5);
        let invented = Trust { depths: &deep, is_made: true, provenance: None, torn: None }.invented();
        let more = invented.limits(0.1);
        assert!(more.widest.0 < high.widest.0, "who allows more may open wider");
        assert_eq!(invented.of(ViewGrid::PAPER.reference()), 0.0);
    }

    #[test]
    fn recorded_views_are_doubted_only_where_they_disagree() {
        let depths = post(40, 1.5);
        let recorded = Trust { depths: &depths, is_made: false, provenance: None, torn: None };
        let made = Trust { depths: &depths, is_made: true, provenance: None, torn: None };
        let view = ViewIndex { v: 4, u: 1 };
        assert!(recorded.share(view) < made.share(view));
        let wrong: Vec<f32> =
            depths.disparity_px().iter().enumerate().map(|(i, d)| if i / 6400 == 33 { d + 1.0 } else { *d }).collect();
        let wrong = RayDepths::new(ViewGrid::PAPER, depths.size(), wrong).unwrap();
        assert!(
            Trust { depths: &wrong, is_made: false, provenance: None, torn: None }.share(view) > 0.9,
            "one view says otherwise"
        );
    }

    #[test]
    fn a_closed_lens_shows_one_view_and_an_open_one_the_mean_of_many() {
        let depths = post(40, 1.5);
        let trust = Trust { depths: &depths, is_made: true, provenance: None, torn: None };
        let sum = |f: f32| {
            let lens = Lens { f_number: FNumber(f), ..Lens::default() };
            trust.of_picture(&lens, ViewPoint::default()).pixels().iter().sum::<f32>()
        };
        assert_eq!(sum(28.0), 0.0);
        assert!(sum(7.0) > 0.0 && sum(3.5) > sum(7.0));
    }
}
