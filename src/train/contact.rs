//! The contact sheet of a run: what its net makes of the samples it has just seen, for a person to look at.

use crate::TrainError;
use crate::batch::Batch;
use crate::checkpoint::Checkpoint;
use crate::config::Config;
use crate::eval::sheet::{depth_tile, epi_tile, usual_range};
use crate::eval::{Rgb, warp};
use crate::nets::{REFERENCE, SIDE, VIEWS};
use crate::scenes::raster::Raster;
use crate::scenes::steps;
use crate::step;

/// Height in pixels of a view's line in an epipolar image.
const LINE_PX: usize = 8;
/// A view of the upper rim that is no corner: corners may be given.
const RIM: usize = 3;
/// Rows of a sheet, at most.
const ROWS: usize = 8;

/// Photo, true and predicted ray depths of the reference view, and the epipolar image of the middle row that each
/// of the two gives, one row a sample.
pub fn depth_rows(net: &Checkpoint, batch: &Batch, config: &Config) -> Result<Vec<Vec<Rgb>>, TrainError> {
    let maps = &batch.maps;
    let (size, p, here) = ([maps.width, maps.height], maps.plane(), maps.reference());
    let all = step::infer_all_depths(net.best(), &net.arch.graph(), batch, config)?;
    let rows = (0..maps.samples.min(ROWS)).map(|n| {
        let photo = view(batch, n, here);
        let truth = &batch.truth[(n * maps.views.len() + here) * p..][..p];
        let predicted = &all[n * VIEWS * p..][..VIEWS * p];
        let own = &predicted[REFERENCE * p..][..p];
        let true_epi = epi(&photo, |_| truth);
        let predicted_epi = epi(&photo, |layer| &predicted[layer * p..][..p]);
        let tile = |map: &[f32]| depth_tile(map, size, usual_range(map));
        vec![photo, tile(truth), tile(own), true_epi, predicted_epi]
    });
    Ok(rows.collect())
}

/// A true outermost view, the Lambertian one, and that after the occlusion net, one row a sample.
pub fn occlusion_rows(
    net: &Checkpoint,
    batch: &Batch,
    depth: &[f32],
    config: &Config,
) -> Result<Vec<Vec<Rgb>>, TrainError> {
    let maps = &batch.maps;
    let (rendered, full) = step::infer_views(net.best(), &net.arch.graph(), batch, depth, config)?;
    let of =
        |values: &[f32], n: usize| raster(&values[n * maps.views.len() * 3 * maps.plane()..], maps.width, maps.height);
    Ok((0..maps.samples.min(ROWS)).map(|n| vec![view(batch, n, 0), of(&rendered, n), of(&full, n)]).collect())
}

/// The photo, a true view of the upper rim, and what a method without the photo's ray depths made of it (`made`, `[n, v, 3, h, w]`
/// in 0 … 1), one row a sample.
pub fn view_rows(batch: &Batch, made: &[f32]) -> Vec<Vec<Rgb>> {
    let maps = &batch.maps;
    let rim = RIM.min(maps.views.len() - 1);
    let row = |n: usize| {
        let own = raster(&made[(n * maps.views.len() + rim) * 3 * maps.plane()..], maps.width, maps.height);
        vec![view(batch, n, maps.reference()), view(batch, n, rim), own]
    };
    (0..maps.samples.min(ROWS)).map(row).collect()
}

/// The epipolar image of the middle row, its views rendered from the photo.
fn epi<'a>(photo: &Rgb, depth: impl Fn(usize) -> &'a [f32]) -> Rgb {
    let row = REFERENCE / SIDE * SIDE;
    let views: Vec<Rgb> = (row..row + SIDE)
        .map(|layer| {
            let (du, dv) = steps(layer);
            warp::lambertian(photo, depth(layer), du, dv)
        })
        .collect();
    epi_tile(|layer| &views[layer - row], photo.size[1] / 2, LINE_PX)
}

fn view(batch: &Batch, sample: usize, at: usize) -> Rgb {
    let maps = &batch.maps;
    raster(&batch.views[(sample * maps.views.len() + at) * 3 * maps.plane()..], maps.width, maps.height)
}

/// The first `[3, h, w]` values as a picture.
fn raster(values: &[f32], width: usize, height: usize) -> Rgb {
    let p = width * height;
    Raster { size: [width, height], px: (0..p).map(|i| [values[i], values[p + i], values[2 * p + i]]).collect() }
}
