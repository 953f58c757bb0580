//! The Python package `plenoscope`, its compiled half: arguments come in, arrays go out, the library decides.
//!
//! What people read and call is `python/plenoscope/__init__.py`; here are classes, and one function for each of its.

mod arrays;
mod errors;
mod input;
mod light_field;
mod making;
mod options;
mod photo;
mod pictures;
mod recipe;
mod run;

use plenoscope::kernel::blocks::LargeBlocks;
use pyo3::pymodule;

/// As in the program: planes of the nets are kept for the next one, and not given back each time.
#[global_allocator]
static BLOCKS: LargeBlocks = LargeBlocks::keeping(384 << 20);

/// The compiled half of `plenoscope`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::light_field::{LightField, light_field, open, sample, synthesize, write_light_field};
    #[pymodule_export]
    use super::photo::{Photo, photo};
    #[pymodule_export]
    use super::pictures::{depth, epi, refocus, view};
    #[pymodule_export]
    use super::recipe::Recipe;
}
