//! How much each view counts in a refocus: the lens's opening, spread over the grid of views.

use glam::Vec2;

use crate::field::{Lens, LensShape, ViewGrid, ViewIndex, ViewPoint};

/// One view's part in a refocus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Which view.
    pub view: ViewIndex,
    /// Steps from the viewpoint, x = du, y = dv.
    pub offset: Vec2,
    /// Share of the light; all shares add up to 1.
    pub weight: f32,
}

/// Points per axis by which an opening is sampled; 64 puts hundreds of points on each view at f/3.5.
const SAMPLES_PER_AXIS: i32 = 64;

/// The views that a lens around a viewpoint gathers, with their shares, in `[v, u]` order.
///
/// The square takes the paper's view sets ({0}, {−1, 0}, {−2 … 1}, {−4 … 3} in u and v) and grows evenly between them.
/// All other shapes are openings of [`added_views`](crate::field::FNumber::added_views) steps across; a point between
/// views counts for its four neighbours (bilinear), so an opening of no width shows the viewpoint itself.
/// What lies outside the grid has no light; views for which `arrived` is false count nothing.
pub fn taps(lens: &Lens, grid: ViewGrid, center: ViewPoint, arrived: impl Fn(ViewIndex) -> bool) -> Vec<Tap> {
    let eye = grid.clamp(center.0).to_vec2();
    let weights = match &lens.shape {
        LensShape::Square => square_weights(lens, grid, eye),
        shape => {
            let radius = lens.f_number.added_views() / 2.0;
            opening_weights(shape, Vec2::new(radius * lens.glass.narrow(), radius), grid, eye)
        }
    };
    let mut taps: Vec<Tap> = grid
        .views()
        .zip(weights)
        .filter(|&(view, weight)| weight > 0.0 && arrived(view))
        .map(|(view, weight)| Tap { view, offset: grid.offset(view).to_vec2() - eye, weight })
        .collect();
    let sum: f32 = taps.iter().map(|tap| tap.weight).sum();
    taps.iter_mut().for_each(|tap| tap.weight /= sum);
    taps
}

/// The four views around a viewpoint with their bilinear shares; where none of them has arrived, the nearest that has.
pub fn nearest_views(grid: ViewGrid, point: ViewPoint, arrived: impl Fn(ViewIndex) -> bool) -> Vec<Tap> {
    let eye = grid.clamp(point.0).to_vec2();
    let mut weights = vec![0.0; grid.count()];
    splat(&mut weights, grid, eye, 1.0);
    let tap = |(view, weight)| Tap { view, offset: grid.offset(view).to_vec2() - eye, weight };
    let mut taps: Vec<Tap> =
        grid.views().zip(weights).filter(|&(view, weight)| weight > 0.0 && arrived(view)).map(tap).collect();
    if taps.is_empty() {
        let far = |view: &ViewIndex| (grid.offset(*view).to_vec2() - eye).length_squared();
        let nearest = grid.views().filter(|&view| arrived(view)).min_by(|a, b| far(a).total_cmp(&far(b)));
        taps.extend(nearest.map(|view| tap((view, 1.0))));
    }
    let sum: f32 = taps.iter().map(|tap| tap.weight).sum();
    taps.iter_mut().for_each(|tap| tap.weight /= sum);
    taps
}

/// Shares of the paper's square opening: the part of each view's cell that lies inside it.
fn square_weights(lens: &Lens, grid: ViewGrid, eye: Vec2) -> Vec<f32> {
    let across = lens.f_number.views_across();
    // The paper's even sets reach one view farther to the left and up than to the right and down.
    let low = -across / 2.0 - 0.5 * (across - 1.0).clamp(0.0, 1.0);
    let inside = |step: f32| ((step + 0.5).min(low + across) - (step - 0.5).max(low)).max(0.0);
    grid.views()
        .map(|view| {
            let step = grid.offset(view).to_vec2() - eye;
            inside(step.x) * inside(step.y)
        })
        .collect()
}

/// Shares of any other opening, by points spread evenly over it.
fn opening_weights(shape: &LensShape, radius: Vec2, grid: ViewGrid, eye: Vec2) -> Vec<f32> {
    let mut weights = vec![0.0; grid.count()];
    let side = if radius.y > 0.0 { SAMPLES_PER_AXIS } else { 1 };
    for j in 0..side {
        for i in 0..side {
            let place = (Vec2::new(i as f32, j as f32) + 0.5) * (2.0 / side as f32) - 1.0;
            let light = if side == 1 { 1.0 } else { passes(shape, place) };
            if light > 0.0 {
                splat(&mut weights, grid, eye + place * radius, light);
            }
        }
    }
    weights
}

/// How much light passes the lens at a place of its opening, −1 … 1 in both axes.
pub fn passes(shape: &LensShape, place: Vec2) -> f32 {
    let r = place.length();
    let is_open = match *shape {
        LensShape::Picture(ref opening) => return opening.at(place.to_array()),
        LensShape::Square => true,
        // The cat's eye is a disc in the middle of the picture.
        LensShape::Disc | LensShape::CatEye { .. } => r <= 1.0,
        LensShape::Ring { inner } => (inner.clamp(0.0, 0.9)..=1.0).contains(&r),
        LensShape::Blades { count, rotation_deg, roundness } => {
            let sector = std::f32::consts::TAU / f32::from(LensShape::blades(count));
            let angle = (place.y.atan2(place.x) - rotation_deg.to_radians()).rem_euclid(sector) - sector / 2.0;
            let straight = (sector / 2.0).cos() / angle.cos();
            r <= straight + (1.0 - straight) * roundness.clamp(0.0, 1.0)
        }
    };
    f32::from(is_open)
}

/// Gives a point's light to its four nearest views; nothing to those outside the grid.
fn splat(weights: &mut [f32], grid: ViewGrid, at: Vec2, light: f32) {
    let zero = grid.reference();
    let place = at + Vec2::new(zero.u.into(), zero.v.into());
    let (low, part) = (place.floor(), place - place.floor());
    for (dy, wy) in [(0.0, 1.0 - part.y), (1.0, part.y)] {
        for (dx, wx) in [(0.0, 1.0 - part.x), (1.0, part.x)] {
            let (u, v) = (low.x + dx, low.y + dy);
            let inside = (0.0..grid.cols() as f32).contains(&u) && (0.0..grid.rows() as f32).contains(&v);
            if inside {
                weights[v as usize * grid.cols() + u as usize] += light * wx * wy;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{FNumber, ViewOffset};

    fn lens(f: f32, shape: LensShape) -> Lens {
        Lens { f_number: FNumber(f), shape, ..Lens::default() }
    }

    fn steps(f: f32) -> Vec<[f32; 2]> {
        let taps = taps(&lens(f, LensShape::Square), ViewGrid::PAPER, ViewPoint::default(), |_| true);
        let even = taps[0].weight;
        assert!(taps.iter().all(|tap| (tap.weight - even).abs() < 1e-6), "the paper's sets count evenly");
        taps.iter().map(|tap| tap.offset.to_array()).collect()
    }

    #[test]
    fn the_square_takes_the_papers_view_sets() {
        for (f, low, high) in [(28.0, 0, 0), (14.0, -1, 0), (7.0, -2, 1), (3.5, -4, 3)] {
            let want: Vec<_> = (low..=high).flat_map(|v| (low..=high).map(move |u| [u as f32, v as f32])).collect();
            assert_eq!(steps(f), want, "f/{f}");
        }
    }

    #[test]
    fn shares_add_up_to_one_and_a_closed_lens_is_one_view() {
        let shapes = [
            LensShape::Disc,
            LensShape::Ring { inner: 0.5 },
            LensShape::Blades { count: 6, rotation_deg: 10.0, roundness: 0.3 },
        ];
        for shape in &shapes {
            for f in [28.0, 20.0, 9.0, 3.5, 1.0] {
                let center = ViewPoint(ViewOffset { dv: 0.3, du: -1.7 });
                let sum: f32 =
                    taps(&lens(f, shape.clone()), ViewGrid::PAPER, center, |_| true).iter().map(|t| t.weight).sum();
                assert!((sum - 1.0).abs() < 1e-5, "{shape:?} f/{f}: {sum}");
            }
            let closed = taps(&lens(28.0, shape.clone()), ViewGrid::PAPER, ViewPoint::default(), |_| true);
            assert_eq!(closed.len(), 1);
            assert_eq!(closed[0].view, ViewGrid::PAPER.reference());
        }
    }

    #[test]
    fn a_disc_is_as_wide_as_its_f_number_says() {
        // The variance of a disc of diameter d is d²/16 in each axis; the bilinear spread adds 1/6.
        let taps = taps(&lens(7.0, LensShape::Disc), ViewGrid::new(17, 17).unwrap(), ViewPoint::default(), |_| true);
        let variance: f32 = taps.iter().map(|tap| tap.weight * tap.offset.x * tap.offset.x).sum();
        let want = (4.0f32.powi(2) - 1.0) / 16.0 + 1.0 / 6.0;
        assert!((variance - want).abs() < 0.02, "{variance} {want}");
    }
}
