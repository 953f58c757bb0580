//! Why a picture was not made: the rooms below say it, this one hands it on.

use crate::burst::BurstError;
use crate::io::OpenError;
use crate::io::save::SaveError;
use crate::job::Cancelled;
use crate::render::lens::LensError;
use crate::synth::{ModelError, SynthError};

use super::asked::Usage;
use super::recipe::RecipeError;

/// Anything that can stop the way from a file to a picture.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A model could not be loaded.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The light field could not be made.
    #[error(transparent)]
    Synth(#[from] SynthError),
    /// Several photos could not become one light field.
    #[error(transparent)]
    Burst(#[from] BurstError),
    /// The lens renderer cannot use the disparities.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// The recipe could not be read.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// The file could not be written.
    #[error(transparent)]
    Save(#[from] SaveError),
    /// The arguments cannot be, or do not go together.
    #[error(transparent)]
    Usage(#[from] Usage),
    /// What was asked for would do harm, or has no sense; the text says it.
    #[error("{0}")]
    Refused(String),
    /// Stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Views were asked for where only a map had been made.
    #[error("this needs all views, and only one map was made — make the light field first")]
    NoViews,
    /// Parts that do not fit together.
    #[error(transparent)]
    Field(#[from] crate::field::FieldError),
}
