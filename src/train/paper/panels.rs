//! Panels of the report: pictures of what the methods make of one light field.

use plenoscope::field::{FNumber, FocalPlane, Lens, LensShape, ViewPoint};
use plenoscope::render::cpu;

use super::judge::{LAMBERTIAN, Made, Shown, title};
use super::method::Method;
use crate::eval::Rgb;
use crate::eval::metrics::median;
use crate::eval::sheet::{depth_tile, epi_tile, join, usual_range};
use crate::field::light_field;
use crate::nets::{REFERENCE, SIDE};
use crate::scenes::raster::Raster;

/// Lines of an epipolar image for each view.
const LINE_PX: usize = 6;
/// Width of the stretch that is magnified, and by how much.
const STRETCH_PX: usize = 64;
const MAGNIFIED: usize = 6;
/// Width of a picture.
const TILE_PX: usize = 320;

/// What is drawn, and what it shows from left to right or from top to bottom.
pub struct Panel {
    /// Name of its file.
    pub name: &'static str,
    /// What stands below it.
    pub says: String,
    /// The picture.
    pub picture: Rgb,
}

/// All panels that the methods which are there allow.
pub fn all(shown: &Shown) -> Vec<Panel> {
    [depths(shown), epipolar(shown), ablation(shown), corner(shown), photographic(shown)]
        .into_iter()
        .flatten()
        .collect()
}

/// Photo, depth measured from the whole light field, ray depth from the photo alone.
fn depths(shown: &Shown) -> Option<Panel> {
    let own = reference_depth(shown.made.get(Method::Ours.name())?, shown)?;
    let size = shown.field.size;
    let tile = |map: &[f32]| depth_tile(map, size, usual_range(map));
    let row = vec![shown.field.reference().clone(), tile(&shown.measured), tile(own)];
    Some(Panel {
        name: "depths",
        says: "photo; depth measured from all 64 views, or the file's own; ours from the photo alone (each over its own range)".into(),
        picture: join(&[row], TILE_PX),
    })
}

fn reference_depth<'a>(made: &'a Made, shown: &Shown) -> Option<&'a [f32]> {
    let count = shown.measured.len();
    made.depths.as_ref().map(|depths| &depths[REFERENCE * count..][..count])
}

/// Epipolar images of a stretch across the strongest edge of depth, magnified: the true one above those of the methods.
fn epipolar(shown: &Shown) -> Option<Panel> {
    let (left, y) = strongest_edge(&shown.measured, shown.field.size);
    let mut rows = vec![vec![stretch(&epi_tile(|layer| &shown.field.views[layer], y, LINE_PX), left)]];
    let mut names = vec!["recorded"];
    let methods = [Method::Ours, Method::Flow, Method::Regression, Method::Corners].map(Method::name);
    for name in [&methods[..1], &[LAMBERTIAN], &methods[1..]].concat() {
        if let Some(made) = shown.made.get(name) {
            rows.push(vec![stretch(&epi_tile(|layer| &made.views[layer], y, LINE_PX), left)]);
            names.push(title(name));
        }
    }
    Some(Panel {
        name: "epipolar",
        says: format!("row {y} around its strongest edge of depth, from the top: {}", names.join(", ")),
        picture: join(&rows, STRETCH_PX * MAGNIFIED),
    })
}

/// Epipolar slices of the ray depths themselves: straight lines where they agree.
fn ablation(shown: &Shown) -> Option<Panel> {
    let (_, y) = strongest_edge(&shown.measured, shown.field.size);
    let (mut rows, mut names, mut range) = (Vec::new(), Vec::new(), None);
    for method in Method::ALL {
        let Some(depths) = shown.made.get(method.name()).and_then(|made| made.depths.as_ref()) else { continue };
        let [w, h] = shown.field.size;
        let first = REFERENCE / SIDE * SIDE;
        let slice: Vec<f32> = (0..SIDE * LINE_PX)
            .flat_map(|line| &depths[(first + line / LINE_PX) * w * h + y * w..][..w])
            .copied()
            .collect();
        // One scale for all, that of the first.
        let range = *range.get_or_insert_with(|| usual_range(&slice));
        rows.push(vec![depth_tile(&slice, [w, SIDE * LINE_PX], range)]);
        names.push(method.title());
    }
    (rows.len() > 1).then(|| Panel {
        name: "ablation",
        says: format!("ray depths of row {y} in all views of the middle row, from the top: {}", names.join(", ")),
        picture: join(&rows, 2 * TILE_PX),
    })
}

/// A corner view, true and made.
fn corner(shown: &Shown) -> Option<Panel> {
    let mut row = vec![shown.field.views[0].clone()];
    let mut names = vec!["recorded"];
    for name in [Method::Ours.name(), LAMBERTIAN, Method::Flow.name(), Method::Regression.name()] {
        if let Some(made) = shown.made.get(name) {
            row.push(made.views[0].clone());
            names.push(title(name));
        }
    }
    (row.len() > 1).then(|| Panel {
        name: "corner-view",
        says: format!("the corner view (0, 0): {}", names.join(", ")),
        picture: join(&[row], TILE_PX),
    })
}

/// Synthetic apertures f/28 … f/3.5 of ours, focused on what is near; then on what is far.
fn photographic(shown: &Shown) -> Option<Panel> {
    let made = shown.made.get(Method::Ours.name())?;
    let field = light_field(&made.views).ok()?;
    let own = reference_depth(made, shown)?;
    let [far, near] = usual_range(own);
    let middle = median(own.to_vec())?;
    let shot = |f_number: f32, disparity_px: f32| {
        let focus = FocalPlane { disparity_px, ..FocalPlane::default() };
        let lens = Lens { f_number: FNumber(f_number), shape: LensShape::Square, focus, ..Lens::default() };
        let picture = cpu::refocus(&field, &lens, ViewPoint::default());
        let texel = |p: &[u8]| [0, 1, 2].map(|c| f32::from(p[c]) / 255.0);
        Raster { size: shown.field.size, px: picture.to_srgb8().chunks_exact(4).map(texel).collect() }
    };
    let rows = [[28.0, 7.0, 3.5].map(|n| shot(n, near)).to_vec(), [near, middle, far].map(|d| shot(3.5, d)).to_vec()];
    Some(Panel {
        name: "photographic",
        says: "above: f/28, f/7, f/3.5 focused on what is near; below: f/3.5 focused near, in the middle, far".into(),
        picture: join(&rows, TILE_PX),
    })
}

/// Where depth changes most between two pixels beside each other, as the stretch around it: left end, row.
fn strongest_edge(map: &[f32], [w, h]: [usize; 2]) -> (usize, usize) {
    let change = |i: usize| (map[i + 2] - map[i]).abs();
    let inside = |i: &usize| i % w + 2 < w && (h / 8..h - h / 8).contains(&(i / w));
    let at = (0..map.len().saturating_sub(2)).filter(inside).max_by(|a, b| change(*a).total_cmp(&change(*b)));
    let at = at.unwrap_or(h / 2 * w + w / 2);
    ((at % w).saturating_sub(STRETCH_PX / 2).min(w.saturating_sub(STRETCH_PX)), at / w)
}

/// A stretch of an epipolar image, its pixels as blocks.
fn stretch(epi: &Rgb, left: usize) -> Rgb {
    let wide = STRETCH_PX.min(epi.size[0]);
    Raster::from_fn([wide * MAGNIFIED, epi.size[1]], |x, y| epi.at(left + x / MAGNIFIED, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stretch_holds_the_strongest_edge() {
        let size = [200, 40];
        let map: Vec<f32> = (0..8000).map(|i| if i % 200 > 150 && i / 200 == 20 { 1.0 } else { 0.0 }).collect();
        let (left, row) = strongest_edge(&map, size);
        assert!(row == 20 && (left..left + STRETCH_PX).contains(&150), "{left} {row}");
        assert_eq!(strongest_edge(&[0.0; 64], [8, 8]).0, 0);
    }
}
