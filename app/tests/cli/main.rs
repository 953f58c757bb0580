//! The real program `plenoscope`, as a person at a terminal or a script uses it.

mod basics;
mod common;
mod light_field;
mod nets;
#[cfg(target_os = "linux")]
mod window;
