//! What can go wrong in the trainer.

use std::path::PathBuf;

/// An error of the trainer, in one sentence: what, why, what to do, path last.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// A picture that the net's poolings do not divide.
    #[error(
        "a picture of {width}×{height} does not fit the net: both sides must be multiples of {multiple_of}; change --crop"
    )]
    Size {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
        /// What both must be multiples of.
        multiple_of: usize,
    },
    /// A weight that is not there.
    #[error("the weights lack {name}: they are of another net")]
    Missing {
        /// Name of the array.
        name: String,
    },
    /// Weights of another net.
    #[error(
        "the weights are not those of the net {wanted}: start without them, or name the net they were trained for with --net"
    )]
    Architecture {
        /// The net that was asked for.
        wanted: String,
    },
    /// A checkpoint of a depth net where the occlusion net is wanted, or the other way round.
    #[error("this is a checkpoint of the net {have}; expected one of {wanted}: {}", path.display())]
    OtherNet {
        /// The net that it holds.
        have: String,
        /// What was asked for.
        wanted: &'static str,
        /// The file.
        path: PathBuf,
    },
    /// A file that cannot be read or written.
    #[error("cannot {action}: {source}: {}", path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
        /// The file.
        path: PathBuf,
    },
    /// An encoder's file that does not fit.
    #[error("cannot take the encoder: {why}: {}", path.display())]
    Encoder {
        /// What does not fit.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// A checkpoint that is no checkpoint.
    #[error("not a checkpoint: {why}: use a file that this trainer saved: {}", path.display())]
    Checkpoint {
        /// What is wrong with it.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// The loss is no number any more.
    #[error(
        "the loss is not a number at step {step} (seed {seed}, samples {first_sample} and on): lower --lr and resume from the last checkpoint"
    )]
    NotANumber {
        /// Step of the run.
        step: u64,
        /// Seed of the run.
        seed: u64,
        /// Number of the first sample of the batch.
        first_sample: u64,
    },
    /// A factor of ray depths for a net that has none.
    #[error("a net of {arch} gives no ray depths that --gain could multiply: leave it out")]
    NoRayDepths {
        /// The net.
        arch: String,
    },
    /// A net that the program has no use for.
    #[error(
        "a net of {arch} gives no ray depths, so the program cannot use it: export a depth net, the occlusion net, or the two of four corners"
    )]
    NotUsable {
        /// The net.
        arch: String,
    },
    /// One of the two nets of four corners.
    #[error(
        "the nets of four corners are used together: name corner-disparity.safetensors and corner-colour.safetensors of a run, and no others"
    )]
    HalfOfTwo,
    /// An exported net that does not compute what the trained one does.
    #[error("the exported net differs from the trained one by {difference:e} (at most {tolerance:e} is expected): nothing was written: {}", path.display())]
    Export {
        /// Largest absolute difference.
        difference: f32,
        /// Largest that is accepted.
        tolerance: f32,
        /// The file that was to be written.
        path: PathBuf,
    },
    /// No graphics device.
    #[error("no graphics device to train on ({why}): train with --device cpu")]
    NoDevice {
        /// What is missing.
        why: String,
    },
    /// libtorch gave up within a step.
    #[error("libtorch gave up a step ({why}): try a smaller --batch, or --device cpu; what was saved of the run stays")]
    Torch {
        /// What it said.
        why: String,
    },
    /// A graphics device that gave up within a step.
    #[error(
        "the graphics device gave up a step of {batch} samples ({why}): try --batch {}; what was saved of the run stays", (batch / 2).max(1)
    )]
    Device {
        /// What it said.
        why: String,
        /// Samples of the step.
        batch: usize,
    },
    /// Data that cannot be had, or worked with.
    #[error("{why}")]
    Data {
        /// What it said.
        why: String,
    },
}
