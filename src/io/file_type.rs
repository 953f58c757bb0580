//! A format that the first bytes of a file tell: how it is known, and what can be read of it.

use super::formats::{self, depth_map::DepthMap};
use super::raster::{self, Raster};
use super::{PhotoFile, Problem};
use crate::job::Job;

/// Makes something of a whole file.
type Parse<T> = fn(&[u8]) -> Result<T, Problem>;
/// The same where it can take so long that somebody may want to stop it.
type ParseLong<T> = fn(&[u8], &Job) -> Result<T, Problem>;

/// A format of files. What is not said of it in its own module is as in [`FileType::UNKNOWN`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct FileType {
    /// The name that people know.
    pub(crate) name: &'static str,
    /// How such files end, in lower case: for looking through folders, never for telling what a file is.
    pub(crate) suffixes: &'static [&'static str],
    /// Whether a file begins as this format does.
    pub(crate) begins: fn(&[u8]) -> bool,
    /// The photo with all that its file says; where this is missing, the pixels are the photo.
    pub(crate) photo: Option<ParseLong<PhotoFile>>,
    /// The pixels alone: of views, of depth maps, of pictures in pictures.
    pub(crate) pixels: Option<Pixels>,
    /// A map of numbers.
    pub(crate) map: Option<Parse<DepthMap>>,
}

/// How pixels are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixels {
    /// Decodes them, as they lie in the file.
    pub(crate) decode: fn(&[u8], &FileType) -> Result<Raster, Problem>,
    /// Width and height from the header, before orientation.
    pub(crate) header_size: fn(&[u8], &FileType) -> Result<[u32; 2], Problem>,
}

impl FileType {
    /// What no file is.
    pub(crate) const UNKNOWN: Self =
        Self { name: "", suffixes: &[], begins: |_| false, photo: None, pixels: None, map: None };

    /// The format of some bytes.
    ///
    /// # Errors
    /// Nothing is there, or nothing that is known.
    pub(crate) fn of(bytes: &[u8]) -> Result<&'static Self, Problem> {
        let known = || formats::file_types().find(|kind| (kind.begins)(bytes));
        if bytes.is_empty() { Err(Problem::Empty) } else { known().ok_or(Problem::Unknown) }
    }

    /// Opens a file of this format as a photo.
    pub(crate) fn open(&self, bytes: &[u8], job: &Job) -> Result<PhotoFile, Problem> {
        match (self.photo, self.pixels) {
            (Some(open), _) => open(bytes, job),
            (None, Some(_)) => Ok(PhotoFile::from_raster(raster::decode(bytes)?, self.name)?.with_xmp()),
            (None, None) => Err(Problem::Unsupported {
                format: self.name,
                reason: "it is a map of numbers, not a picture".to_owned(),
                advice: "open its photo, and give this file as the photo's disparity",
            }),
        }
    }
}
