//! The data engine's samples as batches.

use std::sync::Arc;

use crate::TrainError;
use crate::batch::{Batch, Draw};
use crate::config::{Config, Stage};
use crate::loss::Maps;
use crate::scenes::{self, Kind, Sample, SceneError, Source, Split};
use crate::watch::{KINDS, Watch};

/// What the data engine is told for a run.
pub fn scenes_config(config: &Config) -> Result<scenes::Config, TrainError> {
    let (width, height) = config.crop.first().copied().unwrap_or((config.long_side, config.long_side));
    Ok(scenes::Config {
        data: config.data.clone(),
        maps: config.maps.clone(),
        long_side: config.long_side,
        crop: [width, height],
        views_per_sample: config.views,
        views_group: config.batch as u64,
        mix: config.mix.parse().map_err(|e: SceneError| TrainError::Data { why: e.to_string() })?,
        seed: config.seed,
        split: Split::Train,
        // What is hidden is learned from what the views differ by; noise of their own would be most of it.
        noise: config.stage != Stage::Occlusion,
        augment: true,
        variety: config.variety,
        // Depth nets must learn one scale. The occlusion net meets ray depths of any, from nets, phones and files.
        stretch: if config.stage == Stage::Occlusion { [0.2, 1.25] } else { [1.0; 2] },
        // As nearness maps are: one net learns one curve.
        curve: scenes::Curve::Relief,
        measured: config.measured,
        rooms: config.rooms,
        turned: config.turned,
        shading: config.shading,
        pitfalls: config.pitfalls,
        fine: config.fine,
        ..scenes::Config::default()
    })
}

/// The data engine of a run. `note_down` is told of each file that cannot be used and is left out.
///
/// # Errors
/// Settings or folders that cannot work.
pub fn engine(config: &scenes::Config, note_down: &mut dyn FnMut(&str)) -> Result<Arc<Source>, TrainError> {
    let source = Source::new(config).map_err(|e| TrainError::Data { why: e.to_string() })?;
    source.notes().for_each(note_down);
    Ok(Arc::new(source))
}

/// Batches of composed scenes: crops in turn, samples numbered through.
pub fn draw(config: &Config, source: &Arc<Source>) -> Draw {
    let (batch, crops, source) = (config.batch as u64, config.crop.clone(), source.clone());
    Arc::new(move |number| {
        let (width, height) = crops[(number % crops.len() as u64) as usize];
        let samples = (0..batch).map(|i| source.sample_sized(number * batch + i, [width, height])).collect();
        collate(samples, number * batch)
    })
}

/// Samples of each kind and side that a run is watched on.
const WATCHED: usize = 24;
/// Numbers from here on are no run's.
const BEYOND: u64 = 1 << 40;

/// What to watch a run of a depth net on: samples like those of the run, of both sides of the split.
///
/// # Errors
/// Validation pictures that cannot be used.
pub fn watch(config: &Config, source: &Arc<Source>) -> Result<Watch, TrainError> {
    let other = engine(&scenes::Config { split: Split::Val, augment: false, ..scenes_config(config)? }, &mut |_| {})?;
    let mut sides = Vec::new();
    for kind in KINDS {
        let both = [watched(source, kind, config)?, watched(&other, kind, config)?];
        if both.iter().all(|batches| !batches.is_empty()) {
            sides.push((kind, both));
        }
    }
    Ok(Watch::new(sides))
}

fn watched(source: &Source, kind: Kind, config: &Config) -> Result<Vec<Batch>, TrainError> {
    let (width, height) = config.crop[0];
    let numbers = BEYOND..BEYOND + 8 * WATCHED as u64;
    let samples: Vec<Sample> = numbers
        .filter(|&number| source.kind_of(number) == kind)
        .map(|number| source.reference_alone(number, [width, height]))
        .take(WATCHED)
        .collect();
    let mut batches = Vec::new();
    let mut rest = samples.into_iter().peekable();
    while rest.peek().is_some() {
        batches.push(collate(rest.by_ref().take(config.batch).collect(), BEYOND)?);
    }
    Ok(batches)
}

/// Samples of one size and one set of views as a batch, views ascending.
pub fn collate(samples: Vec<Sample>, first_sample: u64) -> Result<Batch, TrainError> {
    let first = samples.first().ok_or_else(|| TrainError::Data { why: "a batch of no samples".into() })?;
    let (size, layers) = (first.size, first.views.clone());
    if samples.iter().any(|s| s.size != size || s.views != layers) {
        return Err(TrainError::Data { why: "samples of one batch differ in size or views".into() });
    }
    let mut order: Vec<usize> = (0..layers.len()).collect();
    order.sort_by_key(|&i| layers[i]);
    let views = order.iter().map(|&i| layers[i]).collect();
    let maps = Maps { samples: samples.len(), views, height: size[1], width: size[0] };
    let plane = maps.plane();
    let (views, truth, yx, worth, subjects) = Default::default();
    let mut batch = Batch { first_sample, views, truth, yx, worth, subjects, maps };
    for sample in samples {
        for &i in &order {
            batch.views.extend(&sample.rgb[3 * i * plane..][..3 * plane]);
            batch.truth.extend(&sample.disparity[i * plane..][..plane]);
        }
        batch.yx.push(sample.yx);
        batch.worth.push(sample.worth);
        batch.subjects.push(sample.subject.unwrap_or_default());
    }
    Ok(batch)
}
