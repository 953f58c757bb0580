//! What a person asks for in words and numbers, on the command line and in Python: checked, and brought to what a scene
//! takes. Both doors hand their arguments over here, so that the same ones are the same picture and the same sentence.

mod cuts;
mod how;
mod lens;
mod output;
mod refocus;
mod values;

pub use cuts::{Line, depth, depth_need, epi, epi_need, view, view_index, view_need};
pub use how::How;
pub use lens::{FocusAsked, LensAsked, place};
pub use output::{Output, check_is_photo, field_format, field_formats, field_target, make_folder};
pub use refocus::{Asked, Refocus};
pub use values::{
    EPI_SCALE, EPI_SCALES, LONG_SIDES, QUALITIES, THREADS, bits, f_number, lens_shape, number, picture_size, share,
    sides, within,
};

/// Arguments that cannot be, or do not go together: the command line's exit code 2, Python's `ValueError`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Usage(pub String);
