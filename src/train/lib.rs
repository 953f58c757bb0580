//! Trains Plenoscope's nets: data engine, losses, loop, evaluation, export.

pub mod eval;
pub mod scenes;
