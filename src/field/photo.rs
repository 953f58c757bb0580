//! A photo as it was in its file, upright, with an sRGB copy to work on.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{FieldError, Size, check_len};

/// Pixels of a photo in its own colour space, RGBA, rows top to bottom, upright.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PhotoPixels {
    /// 8 bits a channel, `[y, x, 4]`.
    Eight(Arc<[u8]>),
    /// 16 bits a channel, `[y, x, 4]`.
    Sixteen(Arc<[u16]>),
}

impl PhotoPixels {
    /// Bits of a channel.
    pub fn bits(&self) -> u8 {
        match self {
            Self::Eight(_) => 8,
            Self::Sixteen(_) => 16,
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Eight(px) => px.len(),
            Self::Sixteen(px) => px.len(),
        }
    }
}

/// What stood in the file beside the pixels, to be carried over to exports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata {
    /// ICC profile; none means sRGB.
    pub icc: Option<Arc<[u8]>>,
    /// EXIF block, a TIFF structure without the `Exif\0\0` head.
    pub exif: Option<Arc<[u8]>>,
    /// XMP packet (UTF-8 XML).
    pub xmp: Option<Arc<[u8]>>,
    /// The orientation that was in the file, 1 … 8; the pixels here are upright already.
    pub orientation: u8,
}

/// One photo.
#[derive(Clone, Debug)]
pub struct Photo {
    size: Size,
    pixels: PhotoPixels,
    srgb8: Arc<[u8]>,
    metadata: Metadata,
    source: Option<PathBuf>,
}

impl Photo {
    /// A photo of `[width, height]` upright pixels. `srgb8` is its working copy, `[y, x, 4]`, alpha 255.
    pub fn new(size: Size, pixels: PhotoPixels, srgb8: Arc<[u8]>, metadata: Metadata) -> Result<Self, FieldError> {
        let want = super::pixels(size) * 4;
        check_len("the photo", want, pixels.len())?;
        check_len("the photo's sRGB copy", want, srgb8.len())?;
        Ok(Self { size, pixels, srgb8, metadata, source: None })
    }

    /// A photo of 8-bit sRGB pixels without metadata.
    pub fn from_srgb8(size: Size, rgba: Vec<u8>) -> Result<Self, FieldError> {
        let rgba: Arc<[u8]> = rgba.into();
        let metadata = Metadata { orientation: 1, ..Metadata::default() };
        Self::new(size, PhotoPixels::Eight(Arc::clone(&rgba)), rgba, metadata)
    }

    /// The same photo, remembering the file that it came from.
    #[must_use]
    pub fn with_source(mut self, path: &Path) -> Self {
        self.source = Some(path.to_owned());
        self
    }

    /// Width and height of the upright photo, in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Pixels in the photo's own colour space and depth.
    pub fn pixels(&self) -> &PhotoPixels {
        &self.pixels
    }

    /// The sRGB 8-bit working copy, `[y, x, 4]`.
    pub fn srgb8(&self) -> &Arc<[u8]> {
        &self.srgb8
    }

    /// What else was in the file.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The file that it came from.
    pub fn source(&self) -> Option<&Path> {
        self.source.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_buffer_of_the_wrong_length_is_refused() {
        assert!(Photo::from_srgb8([2, 2], vec![0; 15]).is_err());
        assert!(Photo::from_srgb8([0, 2], vec![]).is_err());
    }
}
