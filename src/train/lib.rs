//! Trains Plenoscope's nets: data engine, losses, loop, evaluation, export.

pub mod scenes;
