//! The window without a display: the main walk, edits and queue, and what it looks like.
//!
//! Needs a device (a software Vulkan is enough). Without one the tests say so and pass; with `PLENOSCOPE_NEED_GPU` set
//! they fail.

#![cfg(feature = "ui")]

mod common;
mod edits;
mod faults;
mod hints;
mod keyboard;
mod languages;
mod looks;
mod monkey;
#[path = "../common/nets.rs"]
mod nets;
mod queue;
mod repair;
mod sources;
#[cfg(unix)]
mod training;
mod walk;
