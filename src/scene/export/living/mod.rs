//! The living picture of a scene: its layers, its lens, and a strip for those who cannot draw it.

mod bytes;

use std::path::Path;

use bytes::Bytes;

use super::Settings;
use crate::field::{Lens, Size, ViewGrid, ViewPoint, fit_long_side};
use crate::io::formats::living::{self, Living, Numbers, Rgb};
use crate::job::{Job, Stage};
use crate::render::lens::{self, Layers, Motion, Region, Rgbd, Space, lenses};
use crate::scene::{Edit, Scene, SceneError};

/// A page holds no more pixels than this: 2 MP by its 3 MB.
const MOST_PIXELS: u64 = 2_100_000;
/// Pictures of the strip, and their long side in pixels.
const STRIP: (usize, u32) = (5, 480);
/// What the edit can have and the page cannot.
const LEFT_OUT: &str = "the page has a round lens without faults and grain";

/// Writes the page. A larger photo goes in smaller, which is said.
///
/// # Errors
/// [`SceneError`]; then nothing has been written.
pub(super) fn write(
    scene: &Scene,
    edit: &Edit,
    settings: &Settings,
    target: &Path,
    job: &Job,
) -> Result<(), SceneError> {
    let asked = scene.picture_size(settings.size());
    let size = at_most(asked, MOST_PIXELS);
    if size != asked {
        let [[w, h], [aw, ah]] = [size, asked];
        job.sink.warning(format!("the page holds {w} × {h} of {aw} × {ah} pixels, as it is to stay below 3 MB"));
    }
    let lens = scene.lens(edit);
    if lens.shape != Lens::default().shape || !lens.glass.is_plain() || lens.grain > 0.0 {
        job.sink.warning(LEFT_OUT.to_owned());
    }
    job.advance(Stage::Refocus, 0, 3)?;
    let rgbd = scene.rgbd()?.in_space(Space::Srgb);
    let layers = rgbd.prepare(size, job.cancel)?.layers();
    job.advance(Stage::Refocus, 1, 3)?;
    let strip = strip(&rgbd, &lens, job)?;
    let numbers = numbers(scene, edit, &lens, &layers);
    let Bytes { photo, depths, behind, behind_depths, range } = Bytes::of(&layers);
    let title = Path::new(&scene.subject().name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let scene = Numbers { range, focus: numbers.focus.clamp(range[0], range[1]), ..numbers };
    job.advance(Stage::Save, 2, 3)?;
    living::write(target, &Living { title, photo, depths, behind, behind_depths, scene, strip })?;
    Ok(job.advance(Stage::Save, 3, 3)?)
}

/// The largest size of a shape with so many pixels.
fn at_most(size: Size, pixels: u64) -> Size {
    let have = u64::from(size[0]) * u64::from(size[1]);
    if have <= pixels {
        return size;
    }
    let scale = (pixels as f64 / have as f64).sqrt();
    // One less, as the other side is rounded.
    fit_long_side(size, ((f64::from(size[0].max(size[1])) * scale) as u32).saturating_sub(1).max(1))
}

fn numbers(scene: &Scene, edit: &Edit, lens: &Lens, layers: &Layers) -> Numbers {
    let reach = scene.views().map_or(ViewGrid::PAPER, |views| views.field.grid()).inner_radius();
    let ViewPoint(eye) = edit.viewpoint;
    Numbers {
        size: layers.size,
        behind_size: layers.behind_size,
        range: [0.0; 2],
        scale: layers.scale,
        reach,
        f_number: lens.f_number.0,
        focus: lens.focus.disparity_px,
        tilt: lens.focus.tilt_px,
        curve: lens.curve_px,
        keep_sharp: lens.keep_sharp_px,
        highlights: lens.highlights,
        eye: [eye.du, eye.dv],
        pivot: edit.pivot_px(scene.map().size()[0], scene.strength()),
    }
}

/// Small pictures focused from far to near.
fn strip(rgbd: &Rgbd, lens: &Lens, job: &Job) -> Result<Vec<(String, Rgb)>, SceneError> {
    let (count, side) = STRIP;
    let prepared = rgbd.prepare(fit_long_side(rgbd.photo().size(), side), job.cancel)?;
    let whole = Region { at: [0; 2], size: prepared.size() };
    let quiet = Job { cancel: job.cancel, sink: &() };
    let pull = lenses(lens, Motion::FocusPull(rgbd.disparity().range_px()), count);
    let names = (1..).map(|number| format!("Focus {number} of {count}, from far to near"));
    let drawn = |(name, lens): (String, &Lens)| -> Result<_, lens::LensError> {
        let picture = prepared.render(lens, whole, &quiet)?;
        let pixels = picture.to_srgb8().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
        Ok((name, Rgb { size: picture.size, pixels }))
    };
    Ok(names.zip(&pull).map(drawn).collect::<Result<_, _>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_photos_go_in_smaller_and_keep_their_shape() {
        assert_eq!(at_most([1600, 1200], MOST_PIXELS), [1600, 1200]);
        let [w, h] = at_most([20_000, 10_000], MOST_PIXELS);
        assert!(u64::from(w) * u64::from(h) <= MOST_PIXELS && w.abs_diff(2 * h) < 3, "{w} × {h}");
    }
}
