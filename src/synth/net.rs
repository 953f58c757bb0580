//! A model that keeps itself warm: made ready once a shape, run many times.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::tract::{EngineError, Options, Output, Runnable, SharedWeights, Wiring, prepare_file};
use super::{Manifest, ModelError, ModelFile, SynthError};
use crate::job::{Cancel, Cancelled};
use crate::kernel::winograd::VolumeChain;

/// Shapes that are kept ready at most; the oldest goes first. A photo may need three.
const WARM_SHAPES: usize = 12;
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
    warm: Mutex<Vec<Warm>>,
    weights: SharedWeights,
}

/// The net for one shape and number of threads; whoever asks while it is made ready waits for it.
struct Warm {
    shape: Vec<usize>,
    threads: usize,
    net: Arc<Mutex<Option<Runnable>>>,
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

    /// Makes it ready for several shapes beside each other, one thread each. With one thread alone, or a large net, each
    /// is made ready when it is run.
    pub(super) fn make_ready(&self, shapes: &[Vec<usize>], threads: usize, cancel: &Cancel) {
        if threads == 1 || shapes.len() < 2 || self.is_heavy() {
            return;
        }
        // What fails here fails again where it is run, and is told there.
        thread::scope(|scope| shapes.iter().for_each(|shape| drop(scope.spawn(|| self.ready(shape, threads, cancel)))));
    }

    fn ready(&self, shape: &[usize], threads: usize, cancel: &Cancel) -> Result<Runnable, SynthError> {
        let mut warm = locked(&self.warm);
        let place = self.place(&mut warm, shape, threads);
        // So that a large net is never in memory twice.
        let _alone = self.is_heavy().then_some(warm);
        let mut place = locked(&place);
        if let Some(net) = &*place {
            return Ok(net.clone());
        }
        self.file.check()?;
        let (weights, cancel) = (self.weights.clone(), cancel.clone());
        let options = Options { threads, weights, cancel, ..Options::default() };
        let net = prepare_file(&self.file.onnx(&self.wiring), shape, &options).map_err(|error| self.synth(error))?;
        *place = Some(net.clone());
        Ok(net)
    }

    /// Where the net for a shape is kept; others make room for it before it comes.
    fn place(&self, warm: &mut Vec<Warm>, shape: &[usize], threads: usize) -> Arc<Mutex<Option<Runnable>>> {
        if let Some(held) = warm.iter().find(|held| held.threads == threads && held.shape == shape) {
            return Arc::clone(&held.net);
        }
        let kept = if self.is_heavy() { 0 } else { WARM_SHAPES - 1 };
        let gone = warm.len().saturating_sub(kept);
        warm.drain(..gone);
        let net = Arc::default();
        warm.push(Warm { shape: shape.to_vec(), threads, net: Arc::clone(&net) });
        net
    }

    fn is_heavy(&self) -> bool {
        self.file.bytes > HEAVY_BYTES
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

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::ModelBytes;
    use crate::synth::library::sha256;
    use crate::synth::tract::graph_tests::{DataType, Graph, PICTURE};

    /// A net that answers red, of a file of so many bytes as it says.
    fn red(bytes: u64) -> Net {
        let graph = Graph::new(13)
            .input("x", DataType::Float, &PICTURE)
            .weights("w", &[1, 3, 1, 1], &[1.0, 0.0, 0.0])
            .node("Conv", &["x", "w"], &["y"], vec![])
            .output("y");
        let onnx: &[u8] = graph.bytes().leak();
        let manifest = Manifest { sha256: sha256(onnx), ..Manifest::default() };
        let onnx = ModelBytes::Embedded(onnx);
        Net::unchecked(ModelFile { manifest, onnx, bytes, folder: None, place: String::new() })
    }

    fn ready(net: &Net) -> Vec<usize> {
        let warm = locked(&net.warm);
        let mut widths: Vec<_> = warm.iter().filter(|w| locked(&w.net).is_some()).map(|w| w.shape[3]).collect();
        widths.sort_unstable();
        widths
    }

    #[test]
    fn several_shapes_are_ready_before_the_first_is_run() {
        let shapes = [4, 8, 16].map(|width| vec![1, 3, 1, width]);
        let net = red(100);
        net.make_ready(&shapes, 2, &Cancel::default());
        assert_eq!(ready(&net), [4, 8, 16]);
        let input: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let output = net.run(&shapes[0], &input, 2, &Cancel::default()).unwrap();
        assert_eq!(output[..], [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(ready(&net), [4, 8, 16], "none is made twice");
    }

    #[test]
    fn of_a_large_net_one_shape_is_kept() {
        let shapes = [4, 8].map(|width| vec![1, 3, 1, width]);
        let net = red(HEAVY_BYTES + 1);
        net.make_ready(&shapes, 2, &Cancel::default());
        assert_eq!(ready(&net), [0; 0], "they would be in memory together");
        for shape in &shapes {
            net.run(shape, &vec![0.5; 3 * shape[3]], 2, &Cancel::default()).unwrap();
        }
        assert_eq!(ready(&net), [8]);
    }
}
