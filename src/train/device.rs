//! Where a run's tensors live: on the processor, or on a graphics device.
//!
//! Graphs, losses and seeds are the same. On the processor the convolutions are ours; on a graphics device they are burn's (WGSL on
//! Vulkan, Metal and DX12 with the feature `gpu`, CUDA with `cuda`) or libtorch's ([`Place::Torch`]), and what goes to and fro in a
//! step is the net's input, what it says, and the gradient of that.

use burn::tensor::Device;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::TrainError;
use crate::ops::Path;

/// What computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// The processor, with our own operations.
    #[default]
    Cpu,
    /// A graphics device, with burn's operations; the trainer must be built with `--features gpu` or `cuda`.
    Gpu,
    /// libtorch, on CUDA where it is there, for nets over pictures; the trainer must be built with `--features torch`.
    Torch,
}

impl Place {
    /// Makes sure that it is there.
    ///
    /// # Errors
    /// A trainer that was built without, or a machine that has none.
    pub fn ready(self) -> Result<(), TrainError> {
        match self {
            Self::Cpu => Ok(()),
            Self::Gpu => graphics().map(drop),
            Self::Torch if cfg!(feature = "torch") => Ok(()),
            Self::Torch => Err(TrainError::NoDevice {
                why: "this trainer was built without; build it with --features torch".into(),
            }),
        }
    }
}

/// The device on which the operations of a path compute.
///
/// # Errors
/// As [`Place::ready`].
pub fn of(path: Path) -> Result<Device, TrainError> {
    match path {
        Path::Stock | Path::Own(_) => Ok(Device::flex()),
        Path::Graphics => graphics(),
    }
}

#[cfg(feature = "cuda")]
fn graphics() -> Result<Device, TrainError> {
    use std::panic::catch_unwind;
    use std::sync::OnceLock;
    // The toolkit is found, or not, when the first tensor is made; burn panics where it is not.
    static FOUND: OnceLock<bool> = OnceLock::new();
    let tried = || catch_unwind(|| burn::tensor::Tensor::<1>::zeros([1], &Device::cuda(0)).into_data()).is_ok();
    if *FOUND.get_or_init(tried) {
        return Ok(Device::cuda(0));
    }
    Err(TrainError::NoDevice { why: "CUDA found none".into() })
}

#[cfg(all(feature = "gpu", not(feature = "cuda")))]
fn graphics() -> Result<Device, TrainError> {
    use std::sync::OnceLock;
    static FOUND: OnceLock<Result<Device, String>> = OnceLock::new();
    let found = FOUND.get_or_init(|| Device::wgpu_options().init().map_err(|error| error.to_string()));
    found.clone().map_err(|why| TrainError::NoDevice { why })
}

#[cfg(not(any(feature = "gpu", feature = "cuda")))]
fn graphics() -> Result<Device, TrainError> {
    Err(TrainError::NoDevice { why: "this trainer was built without; build it with --features gpu".into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(not(any(feature = "gpu", feature = "cuda")))]
    #[test]
    fn a_trainer_without_graphics_says_how_to_get_them() {
        assert!(Place::Cpu.ready().is_ok());
        let text = Place::Gpu.ready().unwrap_err().to_string();
        assert!(text.contains("--features gpu") && text.contains("--device cpu"), "{text}");
        #[cfg(not(feature = "torch"))]
        assert!(Place::Torch.ready().unwrap_err().to_string().contains("--features torch"));
    }

    /// What a net says of a picture, and the gradients of its weights.
    #[cfg(any(feature = "gpu", feature = "cuda"))]
    fn pass(arch: crate::nets::Arch, path: Path) -> (Vec<f32>, Vec<Vec<f32>>) {
        use crate::nets::{Mode, Tape, Weights, values};
        let graph = arch.graph();
        let weights = Weights::random(&graph, 3);
        let mut tape = Tape::new(&weights, Mode::Train, path).unwrap();
        let input = |n: usize| (0..n).map(|i| (i as f32 * 0.37).sin()).collect::<Vec<_>>();
        let channels = graph.input_channels();
        let (said, sum) = if graph.rank == 2 {
            let y = tape.run2(&graph, tape.input(input(2 * channels * 16 * 24), [2, channels, 16, 24]), None).unwrap();
            let weighed = y.clone() * tape.input(input(y.dims().iter().product()), y.dims());
            (values(y), weighed.sum())
        } else {
            let y = tape.run3(&graph, tape.input(input(channels * 5 * 12 * 16), [1, channels, 5, 12, 16])).unwrap();
            let weighed = y.clone() * tape.input(input(y.dims().iter().product()), y.dims());
            (values(y), weighed.sum())
        };
        let (gradients, _) = tape.finish_step(&sum.backward());
        (said, gradients.into_iter().map(|(_, gradient)| gradient).collect())
    }

    #[cfg(any(feature = "gpu", feature = "cuda"))]
    #[test]
    fn a_step_on_a_graphics_device_is_that_on_the_processor() {
        use crate::nets::Arch;
        if let Err(error) = Place::Gpu.ready() {
            eprintln!("SKIPPED: {error}");
            return;
        }
        let apart = |a: &[f32], b: &[f32]| {
            let of = |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v).powi(2)).sum::<f64>().sqrt();
            of(&mut a.iter().zip(b).map(|(a, b)| a - b)) / of(&mut a.iter().copied()).max(1e-12)
        };
        for arch in [Arch::Tiny, Arch::Occlusion, Arch::CornerColour] {
            let ((ours, gradients), (theirs, others)) = (pass(arch, Path::OWN), pass(arch, Path::Graphics));
            assert!(apart(&ours, &theirs) < 1e-3, "{arch:?}: {}", apart(&ours, &theirs));
            assert_eq!(gradients.len(), others.len());
            for (i, (a, b)) in gradients.iter().zip(&others).enumerate() {
                assert!(apart(a, b) < 1e-3, "{arch:?}, array {i}: {}", apart(a, b));
            }
        }
    }
}
