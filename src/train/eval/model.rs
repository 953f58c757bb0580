//! The product's own pipeline as a predictor: what people will see is what is judged.

use std::path::Path;

use plenoscope::field::Photo;
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::{DepthSource, ModelSource, ModelTag, Scale, SynthParams, Synthesizer};

use super::{Prediction, Predictor, Rgb};
use crate::scenes::raster::Raster;

/// The nets of a models folder, or the ones in the program, run by `plenoscope::synth`.
pub struct Models {
    synthesizer: Synthesizer,
    params: SynthParams,
}

impl Models {
    /// Loads them; `folder` is laid out like `models/`, `depth` names a depth net other than the pair's own, `scale` says
    /// how far its ray depths reach.
    ///
    /// # Errors
    /// What [`Synthesizer::load`] says.
    pub fn load(folder: Option<&Path>, depth: Option<&str>, scale: Scale, threads: usize) -> anyhow::Result<Self> {
        let models = folder.map_or(ModelSource::Embedded, |folder| ModelSource::Folder(folder.to_owned()));
        let source = depth.map_or(DepthSource::Network, |id| DepthSource::Model(id.to_owned()));
        let params = SynthParams { long_side: u32::MAX, threads, source, scale, ..SynthParams::default() };
        Ok(Self { synthesizer: Synthesizer::load(&models)?, params })
    }

    /// Name and checksum of the nets.
    pub fn tags(&self) -> Vec<ModelTag> {
        self.synthesizer.models(&self.params)
    }
}

impl Predictor for Models {
    fn predict(&self, reference: &Rgb) -> anyhow::Result<Prediction> {
        let size = reference.size.map(|side| side as u32);
        let photo = Photo::from_srgb8(size, reference.rgba8())?;
        let cancel = Cancel::default();
        let made = self.synthesizer.synthesize(&photo, &self.params, &Job { cancel: &cancel, sink: &() })?;
        let view = |rgba: &[u8]| {
            let px = rgba.chunks_exact(4).map(|p| [0, 1, 2].map(|c| f32::from(p[c]) / 255.0)).collect();
            Raster { size: reference.size, px }
        };
        let occlusion = made.models.len() > 1;
        let corrected = occlusion.then(|| made.field.views().iter().map(|v| view(v.rgba())).collect());
        Ok(Prediction { disparity_px: made.depths.disparity_px().to_vec(), corrected, gain: self.params.scale.gain() })
    }
}
