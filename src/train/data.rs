//! The data engine's samples as batches.

use std::sync::Arc;

use crate::TrainError;
use crate::batch::{Batch, Draw};
use crate::config::{Config, Stage};
use crate::loss::Maps;
use crate::scenes::{self, Sample, SceneError, Source, Split};

/// What the data engine is told for a run.
pub fn scenes_config(config: &Config) -> Result<scenes::Config, TrainError> {
    let (width, height) = config.crop.first().copied().unwrap_or((config.long_side, config.long_side));
    Ok(scenes::Config {
        data: config.data.clone(),
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
        ..scenes::Config::default()
    })
}

/// Batches of composed scenes: crops in turn, samples numbered through.
pub fn draw(config: &Config) -> Result<Draw, TrainError> {
    let source = Source::new(&scenes_config(config)?).map_err(|e| TrainError::Data { why: e.to_string() })?;
    let (batch, crops) = (config.batch as u64, config.crop.clone());
    Ok(Arc::new(move |number| {
        let (width, height) = crops[(number % crops.len() as u64) as usize];
        let samples = (0..batch).map(|i| source.sample_sized(number * batch + i, [width, height])).collect();
        collate(samples, number * batch)
    }))
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
    let mut batch = Batch { first_sample, views: Vec::new(), truth: Vec::new(), yx: Vec::new(), maps };
    for sample in samples {
        for &i in &order {
            batch.views.extend(&sample.rgb[3 * i * plane..][..3 * plane]);
            batch.truth.extend(&sample.disparity[i * plane..][..plane]);
        }
        batch.yx.push(sample.yx);
    }
    Ok(batch)
}
