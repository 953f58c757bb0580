//! Why several photos give no light field.

use crate::field::FieldError;
use crate::job::Cancelled;
use crate::synth::SynthError;

/// Why several photos give no light field; what is left is one photo.
#[derive(Debug, thiserror::Error)]
pub enum BurstError {
    /// Nothing moved.
    #[error("the camera did not move; one photo is used")]
    Still,
    /// A rotation explains everything.
    #[error(
        "the camera only turned, so that nothing can be measured; one photo is used — move it sideways by some centimetres"
    )]
    OnlyTurned,
    /// No frame shows what the reference frame shows.
    #[error("the photos do not show the same things; one photo is used")]
    Unlike,
    /// The job was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Pictures that do not fit together.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// What is made of the map failed.
    #[error(transparent)]
    Synth(#[from] SynthError),
}
