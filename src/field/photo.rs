//! A photo as it was in its file, upright, with an sRGB copy to work on.

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::{FieldError, Size, check_len};

/// Pixels of a photo in its own colour space, RGBA, rows top to bottom, upright.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PhotoPixels {
    /// 8 bits a channel, `[y, x, 4]`.
    Eight(Arc<Vec<u8>>),
    /// 16 bits a channel, `[y, x, 4]`.
    Sixteen(Arc<Vec<u16>>),
}

/// Some of them.
#[derive(Clone, Copy, Debug)]
pub enum PixelsPart<'a> {
    /// 8 bits a channel.
    Eight(&'a [u8]),
    /// 16 bits a channel.
    Sixteen(&'a [u16]),
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

    fn part(&self, channels: Range<usize>) -> PixelsPart<'_> {
        match self {
            Self::Eight(px) => PixelsPart::Eight(&px[channels]),
            Self::Sixteen(px) => PixelsPart::Sixteen(&px[channels]),
        }
    }
}

/// Makes sRGB of 8 bits of a photo's own pixels, as many as there are.
pub type ToSrgb8 = Arc<dyn Fn(PixelsPart<'_>, &mut [u8]) + Send + Sync>;

/// The sRGB copy of a photo's pixels.
#[derive(Clone)]
enum Srgb8 {
    /// There is one, which may be the pixels themselves.
    There(Arc<Vec<u8>>),
    /// It is made when somebody asks for all of it.
    Made { by: ToSrgb8, whole: Arc<OnceLock<Arc<Vec<u8>>>> },
}

impl std::fmt::Debug for Srgb8 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::There(px) => f.debug_tuple("There").field(&px.len()).finish(),
            Self::Made { whole, .. } => f.debug_tuple("Made").field(&whole.get().is_some()).finish(),
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
    srgb8: Srgb8,
    metadata: Metadata,
    source: Option<PathBuf>,
    whole: Option<Size>,
}

/// Rows that one thread makes of the sRGB copy before it looks for more.
const ROWS: usize = 64;

impl Photo {
    /// A photo of `[width, height]` upright pixels. `srgb8` is its working copy, `[y, x, 4]`, alpha 255.
    pub fn new(size: Size, pixels: PhotoPixels, srgb8: Arc<Vec<u8>>, metadata: Metadata) -> Result<Self, FieldError> {
        check_len("the photo's sRGB copy", super::pixels(size) * 4, srgb8.len())?;
        Self::of(size, pixels, Srgb8::There(srgb8), metadata)
    }

    /// A photo whose working copy is made by `by`, where it is asked for: it takes as much memory as the photo.
    pub fn converted(size: Size, pixels: PhotoPixels, by: ToSrgb8, metadata: Metadata) -> Result<Self, FieldError> {
        Self::of(size, pixels, Srgb8::Made { by, whole: Arc::default() }, metadata)
    }

    /// A photo of 8-bit sRGB pixels without metadata.
    pub fn from_srgb8(size: Size, rgba: Vec<u8>) -> Result<Self, FieldError> {
        let rgba = Arc::new(rgba);
        let metadata = Metadata { orientation: 1, ..Metadata::default() };
        Self::new(size, PhotoPixels::Eight(Arc::clone(&rgba)), rgba, metadata)
    }

    fn of(size: Size, pixels: PhotoPixels, srgb8: Srgb8, metadata: Metadata) -> Result<Self, FieldError> {
        check_len("the photo", super::pixels(size) * 4, pixels.len())?;
        Ok(Self { size, pixels, srgb8, metadata, source: None, whole: None })
    }

    /// The same photo, remembering the file that it came from.
    #[must_use]
    pub fn with_source(mut self, path: &Path) -> Self {
        self.source = Some(path.to_owned());
        self
    }

    /// The same photo, remembering that its file has so many upright pixels.
    #[must_use]
    pub fn reduced_from(mut self, whole: Size) -> Self {
        self.whole = Some(whole).filter(|whole| *whole != self.size);
        self
    }

    /// Width and height in its file: more than [`Photo::size`] where it was too large to be kept whole.
    pub fn whole_size(&self) -> Size {
        self.whole.unwrap_or(self.size)
    }

    /// Width and height of the upright photo, in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Pixels in the photo's own colour space and depth.
    pub fn pixels(&self) -> &PhotoPixels {
        &self.pixels
    }

    /// The sRGB 8-bit working copy, `[y, x, 4]`. Who needs its rows once asks for [`Photo::srgb8_row`].
    pub fn srgb8(&self) -> &Arc<Vec<u8>> {
        match &self.srgb8 {
            Srgb8::There(px) => px,
            Srgb8::Made { by, whole } => whole.get_or_init(|| Arc::new(self.made(by))),
        }
    }

    /// A row of the working copy, without the rest of it being made.
    pub fn srgb8_row(&self, y: usize) -> Cow<'_, [u8]> {
        let wide = self.size[0] as usize * 4;
        let row = y * wide..(y + 1) * wide;
        match &self.srgb8 {
            Srgb8::There(px) => Cow::Borrowed(&px[row]),
            Srgb8::Made { by, whole } => match whole.get() {
                Some(px) => Cow::Borrowed(&px[row]),
                None => {
                    let mut out = vec![0; wide];
                    by(self.pixels.part(row), &mut out);
                    Cow::Owned(out)
                }
            },
        }
    }

    /// The whole working copy. By threads of its own: those of the pool may all be waiting for it.
    fn made(&self, by: &ToSrgb8) -> Vec<u8> {
        let mut out = vec![0; self.pixels.len()];
        let part = self.size[0] as usize * 4 * ROWS;
        let parts = Mutex::new(out.chunks_mut(part).enumerate());
        let next = || parts.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || {
            while let Some((i, out)) = next() {
                by(self.pixels.part(i * part..i * part + out.len()), out);
            }
        };
        std::thread::scope(|threads| {
            let others = std::thread::available_parallelism().map_or(0, |all| all.get() - 1);
            for _ in 0..others.min(self.size[1] as usize / ROWS) {
                // Where there are no more threads, this one does it alone.
                let _ = std::thread::Builder::new().name("srgb".to_owned()).spawn_scoped(threads, work);
            }
            work();
        });
        out
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

    #[test]
    fn a_copy_that_is_made_is_the_same_row_by_row_and_whole() {
        let own: Vec<u16> = (0..3 * 200 * 4).map(|i| (i * 27) as u16).collect();
        let by: ToSrgb8 = Arc::new(|part, out| {
            let PixelsPart::Sixteen(px) = part else { unreachable!() };
            out.iter_mut().zip(px).for_each(|(to, from)| *to = (from >> 8) as u8);
        });
        let pixels = PhotoPixels::Sixteen(Arc::new(own.clone()));
        let photo = Photo::converted([3, 200], pixels, by, Metadata::default()).unwrap();
        let want: Vec<u8> = own.iter().map(|v| (v >> 8) as u8).collect();
        let rows = || (0..200).flat_map(|y| photo.srgb8_row(y).into_owned()).collect::<Vec<_>>();
        assert_eq!(rows(), want);
        assert_eq!(**photo.srgb8(), want);
        assert_eq!(rows(), want);
    }
}
