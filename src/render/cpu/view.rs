//! What an eye between the views sees: the four nearest views, warped to it by their ray depths. Twin of `view.wgsl`.

use glam::Vec2;

use super::{nearest, tap};
use crate::field::{LightField, RayDepths, ViewPoint};
use crate::render::{Picture, aperture};

/// Steps of the fixed-point search for the ray that ends in a pixel.
pub(crate) const SEARCH_STEPS: u32 = 3;
/// Disparity by which a search may end beside its ray and still count half, in pixels per view step.
pub(crate) const HALF_TRUST_PX: f32 = 0.05;

/// A viewpoint between views, blended from the four nearest. Without ray depths what is off the plane of disparity 0
/// doubles; see [`view_with_depths`].
pub fn view(field: &LightField, point: ViewPoint) -> Picture {
    view_with_depths(field, None, point)
}

/// As [`view`], with each view warped to the viewpoint by its own ray depths, so that nothing doubles.
///
/// At a view itself the picture is that view, exactly.
pub fn view_with_depths(field: &LightField, depths: Option<&RayDepths>, point: ViewPoint) -> Picture {
    let grid = field.grid();
    let size = field.size();
    let taps = aperture::nearest_views(grid, point, |_| true);
    let maps: Option<Vec<&[f32]>> =
        depths.filter(|d| d.size() == size && d.grid() == grid).map(|d| taps.iter().map(|t| d.view(t.view)).collect());
    Picture::from_fn(size, |x, y| {
        let here = Vec2::new(x as f32, y as f32);
        let near = maps
            .as_ref()
            .map(|maps| maps.iter().map(|map| nearest(map, size, here.x, here.y)).fold(f32::NEG_INFINITY, f32::max));
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for (i, part) in taps.iter().enumerate() {
            let (place, trust) = match (&maps, near) {
                (Some(maps), Some(near)) => search(maps[i], size, here, part.offset, near),
                _ => (here, 1.0),
            };
            let color = tap(field.view(part.view), place.x, place.y);
            (0..3).for_each(|i| sum[i] += color[i] * part.weight * trust);
            total += part.weight * trust;
        }
        sum.map(|light| light / total)
    })
}

/// Where in a view, `offset` steps away, the ray is that ends at `here`; and how far the answer can be trusted, 0 … 1.
fn search(map: &[f32], size: [u32; 2], here: Vec2, offset: Vec2, near: f32) -> (Vec2, f32) {
    let mut disparity = near;
    let mut change = 0.0;
    for _ in 0..SEARCH_STEPS {
        let place = here - offset * disparity;
        let found = nearest(map, size, place.x, place.y);
        change = (found - disparity) / HALF_TRUST_PX;
        disparity = found;
    }
    (here - offset * disparity, 1.0 / (1.0 + change * change))
}
