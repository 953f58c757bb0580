//! Figures on photos that came with a depth of their own: does the net see the order that the phone measured?

use std::path::Path;

use plenoscope::io::PhotoFile;
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::reference_view;
use serde::Serialize;

use super::metrics::spearman;
use super::photos::LONG_SIDE;
use super::sheet::{depth_tile, usual_range};
use super::{EvalError, Predictor, Rgb};
use crate::scenes::REFERENCE;
use crate::scenes::raster::Raster;

/// Figures of one photo.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// The photo.
    pub name: String,
    /// Rank correlation of the ray depth with the phone's.
    pub spearman: f32,
    /// That of the row number: what a net must beat.
    pub rows_spearman: f32,
    /// The share of the picture where the phone knows a depth.
    pub known: f32,
}

/// Evaluates one photo at [`LONG_SIDE`]; beside the figures come photo, the phone's depth, the net's.
///
/// # Errors
/// A photo that came without depth; what the predictor says.
pub fn evaluate(path: &Path, file: &PhotoFile, predictor: &dyn Predictor) -> anyhow::Result<(Figures, Vec<Rgb>)> {
    let depth = file.depth.as_ref().ok_or_else(|| EvalError::NoDepth(path.to_owned()))?;
    let cancel = Cancel::default();
    let view = reference_view(&file.photo, LONG_SIDE as u32, &Job { cancel: &cancel, sink: &() })?;
    let size @ [w, h] = view.size().map(|side| side as usize);
    let texel = |p: &[u8]| [0, 1, 2].map(|c| f32::from(p[c]) / 255.0);
    let photo = Raster { size, px: view.rgba().chunks_exact(4).map(texel).collect() };
    let [mw, mh] = depth.map.size().map(|side| side as usize);
    // The nearest value: between two, a mean would be a depth that is nowhere.
    let phone = Raster::from_fn(size, |x, y| {
        depth.map.nearness()[(2 * y + 1) * mh / (2 * h) * mw + (2 * x + 1) * mw / (2 * w)]
    });
    let prediction = predictor.predict(&photo)?;
    let own = prediction.view(REFERENCE, w * h);
    let known: Vec<usize> = (0..w * h).filter(|&i| phone.px[i].is_finite()).collect();
    let of = |value: &dyn Fn(usize) -> f32| known.iter().map(|&i| value(i)).collect::<Vec<_>>();
    let measured = of(&|i| phone.px[i]);
    let figures = Figures {
        name: path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        spearman: spearman(&of(&|i| own[i]), &measured),
        rows_spearman: spearman(&of(&|i| (i / w) as f32), &measured),
        known: known.len() as f32 / (w * h) as f32,
    };
    let tile = |map: &[f32]| depth_tile(map, size, usual_range(map));
    let tiles = vec![photo, tile(&phone.px), tile(own)];
    Ok((figures, tiles))
}
