//! JPEG photos.

use crate::io::raster;
use crate::io::sniff::Sniffed;
use crate::io::{PhotoFile, Problem, jpeg_parts};

/// Opens a JPEG and the depth in it.
pub(crate) fn open(bytes: &[u8]) -> Result<PhotoFile, Problem> {
    let parts = jpeg_parts::parse(bytes);
    PhotoFile::from_raster(raster::jpeg::decode_parts(bytes, &parts)?, Sniffed::Jpeg)
}
