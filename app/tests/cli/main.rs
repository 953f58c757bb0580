//! The real program `plenoscope`, as a person at a terminal or a script uses it.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]

mod agree;
mod apart;
mod basics;
mod batch;
mod book;
mod burst;
mod common;
mod embedded;
mod faults;
mod film;
#[cfg(unix)]
mod guests;
mod light_field;
mod living;
mod nets;
#[path = "../../../tests/common/nets.rs"]
mod small_nets;
mod splats;
#[cfg(target_os = "linux")]
mod torn;
#[cfg(target_os = "linux")]
mod window;
mod window_export;
