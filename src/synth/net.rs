//! A model that keeps itself warm: made ready once a shape, run many times.

use std::sync::{Mutex, PoisonError};

use super::tract::{EngineError, Options, Output, Runnable, SharedWeights, Wiring, prepare_file};
use super::{Manifest, ModelError, ModelFile, SynthError};
use crate::job::{Cancel, Cancelled};
use crate::kernel::winograd::VolumeChain;

/// Shapes that are kept ready at most; the oldest goes first.
const WARM_SHAPES: usize = 8;
/// Bytes of a net from which on one shape is kept ready: before the next one is, its weights are unpacked again.
const HEAVY_BYTES: u64 = 512 << 20;
/// Side of the small picture that a model is tried with when it is loaded.
const TRIAL_SIDE: usize = 16;

/// A checked model and the shapes it is ready for.
pub(super) struct Net {
    file: ModelFile,
    wiring: Wiring,
    /// The net for every size, where it is that simple.
    chain: Option<VolumeChain>,
    warm: Mutex<Vec<(usize, Runnable)>>,
    weights: SharedWeights,
}

impl Net {
    /// Takes a model whose input at `[h, w]` is `input(h, w)` and whose answer must be `output(h, w)`.
    pub(super) fn load(
        file: ModelFile,
        input: impl Fn(usize, usize) -> Vec<usize>,
        output: impl Fn(usize, usize) -> Vec<usize>,
    ) -> Result<Self, ModelError> {
        let mut net = Self::unchecked(file);
        let side = TRIAL_SIDE.max(net.manifest().multiple_of as usize);
        let options = Options { threads: 1, ..Options::default() };
        let trial = prepare_file(&net.file.onnx(&net.wiring), &input(side, side), &options)
            .map_err(|error| net.engine(error))?;
        let (got, want) = (trial.output_shape(), output(side, side));
        if got != want {
            return Err(net.shape(got, &want));
        }
        net.chain = trial.volume_chain().cloned();
        Ok(net)
    }

    /// Takes a model whose answer is looked at only when it comes.
    pub(super) fn unchecked(file: ModelFile) -> Self {
        let wiring = file.manifest.relative.wiring();
        Self { file, wiring, chain: None, warm: Mutex::default(), weights: SharedWeights::default() }
    }

    /// What is said of an answer that is not one map.
    pub(super) fn no_map(&self, output: &Output) -> ModelError {
        let (id, place) = (self.manifest().id.clone(), self.file.place.clone());
        ModelError::NoMap { id, place, got: format!("{:?}", output.shape()) }
    }

    /// The net for pictures of any size, if it is nothing but a chain of convolutions over views.
    pub(super) fn volume_chain(&self) -> Option<&VolumeChain> {
        self.chain.as_ref()
    }

    /// What the model says about itself.
    pub(super) fn manifest(&self) -> &Manifest {
        &self.file.manifest
    }

    /// Runs it on the row-major values of an input of this shape; answers its first output.
    ///
    /// # Errors
    /// Cancelled; a shape that the model does not take; an answer that is not finite.
    pub(super) fn run(
        &self,
        shape: &[usize],
        input: &[f32],
        threads: usize,
        cancel: &Cancel,
    ) -> Result<Output, SynthError> {
        Ok(self.run_all(shape, input, threads, cancel)?.swap_remove(0))
    }

    /// The same with all outputs that the manifest names: map, sky, focal length.
    ///
    /// # Errors
    /// Those of [`run`](Self::run).
    pub(super) fn run_all(
        &self,
        shape: &[usize],
        input: &[f32],
        threads: usize,
        cancel: &Cancel,
    ) -> Result<Vec<Output>, SynthError> {
        let outputs = self.ready(shape, threads, cancel)?.run_all(input, cancel).map_err(|error| self.synth(error))?;
        if outputs.first().is_some_and(|map| map.iter().all(|value| value.is_finite())) {
            return Ok(outputs);
        }
        Err(ModelError::NotFinite { id: self.manifest().id.clone(), place: self.file.place.clone() }.into())
    }

    fn ready(&self, shape: &[usize], threads: usize, cancel: &Cancel) -> Result<Runnable, SynthError> {
        let mut warm = self.warm.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, net)) = warm.iter().find(|(n, net)| *n == threads && net.input_shape() == shape) {
            return Ok(net.clone());
        }
        let kept = if self.file.bytes > HEAVY_BYTES { 0 } else { WARM_SHAPES - 1 };
        // Before the next one comes, so that a large net is never in memory twice.
        let gone = warm.len().saturating_sub(kept);
        warm.drain(..gone);
        self.file.check()?;
        let (weights, cancel) = (self.weights.clone(), cancel.clone());
        let options = Options { threads, weights, cancel, ..Options::default() };
        let net = prepare_file(&self.file.onnx(&self.wiring), shape, &options).map_err(|error| self.synth(error))?;
        warm.push((threads, net.clone()));
        Ok(net)
    }

    fn synth(&self, error: EngineError) -> SynthError {
        match error {
            EngineError::Cancelled => Cancelled.into(),
            EngineError::Threads { source } => SynthError::Threads(source.to_string()),
            other => self.engine(other).into(),
        }
    }

    fn engine(&self, source: EngineError) -> ModelError {
        ModelError::Engine { id: self.manifest().id.clone(), place: self.file.place.clone(), source }
    }

    fn shape(&self, got: &[usize], want: &[usize]) -> ModelError {
        let (got, want) = (format!("{got:?}"), format!("{want:?}"));
        ModelError::Shape { id: self.manifest().id.clone(), place: self.file.place.clone(), got, want }
    }
}
