//! Trains Plenoscope's nets: data engine, nets, losses, training loop, evaluation, export.

pub mod batch;
pub mod bench;
pub mod checkpoint;
pub mod config;
pub mod contact;
pub mod corners;
pub mod curves;
pub mod data;
mod depth_losses;
pub mod device;
mod error;
pub mod eval;
pub mod export;
pub mod field;
pub mod files;
pub mod loss;
pub mod nets;
pub mod ops;
pub mod optimizer;
pub mod paper;
pub mod recorded;
pub mod rng;
pub mod run;
pub mod scenes;
mod settle;
pub mod step;
#[cfg(feature = "torch")]
pub mod torch;
pub mod view_step;
pub mod warp;
pub mod watch;

pub use error::TrainError;
