//! HEIC photos, decoded by heifer.

use heifer::heifer_isobmff::HeifFile;

use crate::io::raster::{MAX_DECODED_BYTES, Raster, Samples, check_size};
use crate::io::sniff::Sniffed;
use crate::io::{PhotoFile, Problem};

const FORMAT: &str = "HEIC";

/// Opens a HEIC photo and the depth in it.
pub(crate) fn open(bytes: &[u8]) -> Result<PhotoFile, Problem> {
    let file = HeifFile::parse(bytes).map_err(|error| Problem::damaged(FORMAT, error))?;
    PhotoFile::from_raster(decode_primary(bytes, &file)?, Sniffed::Heif)
}

fn decode_primary(bytes: &[u8], file: &HeifFile) -> Result<Raster, Problem> {
    let id = file.primary_id;
    if let Ok(Some((width, height))) = file.image_size(id) {
        check_size(width.into(), height.into(), 4)?;
    }
    let options = heifer::Options { max_threads: 0, max_pixels: MAX_DECODED_BYTES / 4 };
    let image = heifer::decode_rgba8(bytes, &options).map_err(|error| Problem::damaged(FORMAT, error))?;
    let metadata = heifer::item_metadata(file, id).unwrap_or_default();
    Ok(Raster {
        size: [image.width, image.height],
        samples: Samples::Eight(image.data.as_chunks().0.to_vec()),
        has_alpha: image.has_alpha,
        icc: metadata.icc_profile,
        exif: metadata.exif,
        xmp: metadata.xmp,
        // The container's own turns (`irot`, `imir`) have been applied; EXIF must not turn the picture again.
        orientation: 1,
    })
}
