//! A depth map in a file beside the photo: `photo_DEPTH.jpg`.

use std::path::Path;

use crate::field::Photo;
use crate::io::EmbeddedDepth;

/// Looks for the map of a photo. A broken one is a warning.
pub(crate) fn find(_path: &Path, _photo: &Photo, _warnings: &mut Vec<String>) -> Option<EmbeddedDepth> {
    None
}
