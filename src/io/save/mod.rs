//! Pictures into files: PNG and TIFF with 8 or 16 bits, JPEG, WebP, with what the photo's file said about it.
//!
//! [`atomic()`] and [`folder()`] are how everything is written that a person keeps.

mod animation;
mod atomic;
mod carry;
mod encode;
pub(crate) mod exif;
mod gdepth;
mod jpeg;
#[cfg(test)]
mod tests;
mod video;
mod webp_animation;
mod xmp;

use std::io::BufWriter;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::aside::IsLink;
use crate::field::{Metadata, Photo, Picture, Transfer};

pub use animation::{AnimationOptions, animation};
pub use atomic::{atomic, atomic_new, folder, free_path, same_file};
pub use carry::Carry;
pub use encode::encode;

pub use crate::field::{Pixels, Samples};

/// Why a file could not be written. The old file, if there was one, is as it was.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// The target is a folder.
    #[error("the picture cannot be saved — there is a folder of that name — give the name of a file: {}", .0.display())]
    IsFolder(PathBuf),
    /// The folder is not there.
    #[error("the picture cannot be saved — its folder does not exist — make it first, or choose another: {}", .0.display())]
    NoFolder(PathBuf),
    /// A file where a folder is to be.
    #[error("the folder cannot be made — there is a file of that name — choose another name: {}", .0.display())]
    InTheWay(PathBuf),
    /// A link where a folder is to be.
    #[error("the folder cannot be made — there is a symbolic link of that name, which is not followed — name the folder that it leads to: {}", .0.display())]
    IsLink(PathBuf),
    /// A name that the disk does not take.
    #[error("the picture cannot be saved — its name is too long, or has letters that the disk does not take — choose a shorter one: {}", .0.display())]
    Name(PathBuf),
    /// The target is the photo itself.
    #[error("the picture would replace the photo that it is made from — choose another name, or ask for it (--force): {}", .0.display())]
    IsSource(PathBuf),
    /// A file of that name came there while the picture was made.
    #[error("the picture is not saved — a file of that name came there meanwhile — choose another name: {}", .0.display())]
    Exists(PathBuf),
    /// No right to write there.
    #[error("the picture cannot be saved — writing is not allowed there — choose another folder: {}", .0.display())]
    NoRights(PathBuf),
    /// No room on the disk.
    #[error("the picture cannot be saved — the disk is full — make room, or choose another disk: {}", .0.display())]
    DiskFull(PathBuf),
    /// The disk, or the network that it is on, gives up.
    #[error("the picture cannot be saved — the disk does not take it ({why}) — see whether it is still connected, or choose another: {}", .path.display())]
    Disk {
        /// What the system says.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// The extension names no format that is known here.
    #[error("the picture cannot be saved — its name names no format — end it in .png, .jpg, .tif or .webp: {}", .0.display())]
    Extension(PathBuf),
    /// The extension names no animation.
    #[error("the animation cannot be saved — its name names no format — end it in .gif, .webp, .png, .apng, .mp4 or .webm: {}", .0.display())]
    Animation(PathBuf),
    /// The picture does not fit the format.
    #[error("the picture cannot be saved — {why}: {}", .path.display())]
    Encode {
        /// What the encoder says.
        why: String,
        /// The file.
        path: PathBuf,
    },
    /// The job was asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl From<crate::job::Cancelled> for SaveError {
    fn from(_: crate::job::Cancelled) -> Self {
        Self::Cancelled
    }
}

impl SaveError {
    /// The sentence for an error of the file system.
    pub fn from_io(error: &std::io::Error, path: &Path) -> Self {
        use std::io::ErrorKind;
        let path = path.to_owned();
        match error.kind() {
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => Self::NoRights(path),
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => Self::DiskFull(path),
            ErrorKind::NotFound | ErrorKind::NotADirectory => Self::NoFolder(path),
            ErrorKind::IsADirectory => Self::IsFolder(path),
            ErrorKind::AlreadyExists => Self::InTheWay(path),
            ErrorKind::InvalidFilename => Self::Name(path),
            _ if error.get_ref().is_some_and(|inner| inner.is::<IsLink>()) => Self::IsLink(path),
            _ if error.raw_os_error().is_some() => Self::Disk { why: error.to_string(), path },
            _ => Self::Encode { why: error.to_string(), path },
        }
    }

    /// The same error about a file, where it was made without knowing which.
    fn at(self, file: &Path) -> Self {
        match &self {
            Self::NoRights(path) | Self::DiskFull(path) | Self::Disk { path, .. } | Self::Encode { path, .. }
                if path.as_os_str().is_empty() =>
            {
                self.about(file)
            }
            _ => self,
        }
    }

    /// The same error about the file or folder that was asked for, where it was made about a part of it.
    #[must_use]
    pub(crate) fn about(self, file: &Path) -> Self {
        match self {
            Self::NoRights(_) => Self::NoRights(file.to_owned()),
            Self::DiskFull(_) => Self::DiskFull(file.to_owned()),
            Self::Disk { why, .. } => Self::Disk { why, path: file.to_owned() },
            Self::Encode { why, .. } => Self::Encode { why, path: file.to_owned() },
            other => other,
        }
    }
}

/// A picture format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// 8 or 16 bits, without loss.
    Png,
    /// 8 bits, 4:4:4.
    Jpeg,
    /// 8 or 16 bits, without loss.
    Tiff,
    /// 8 bits, without loss.
    WebP,
}

impl Format {
    /// The format that a file name asks for.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" | "jpe" | "jfif" => Some(Self::Jpeg),
            "tif" | "tiff" => Some(Self::Tiff),
            "webp" => Some(Self::WebP),
            _ => None,
        }
    }

    /// The extension that a new file gets.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
            Self::Tiff => "tif",
            Self::WebP => "webp",
        }
    }

    /// Whether it has 16 bits a channel.
    pub fn has_16_bits(self) -> bool {
        matches!(self, Self::Png | Self::Tiff)
    }
}

/// How much of what the photo's file said goes along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// EXIF and XMP, made true for the picture.
    #[default]
    All,
    /// The same without the position.
    WithoutPosition,
    /// Neither; the colour profile stays, as without it the colours would change.
    Nothing,
}

/// Where a picture comes from: what its numbers mean, and what is known about the photo.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// The photo's metadata.
    pub metadata: Metadata,
    /// The curve between the picture's linear light and stored values.
    pub transfer: Transfer,
    /// The photo's file, which is not to be written over.
    pub source: Option<PathBuf>,
}

impl Origin {
    /// For pictures whose light is in the photo's own primaries (what the lens renderer makes): its profile stays.
    pub fn in_own_space(photo: &Photo) -> Self {
        let metadata = photo.metadata().clone();
        let transfer = Transfer::of_profile(metadata.icc.as_deref());
        Self { metadata, transfer, source: photo.source().map(Path::to_owned) }
    }

    /// For pictures in linear sRGB that were made from the photo's sRGB copy: without a profile, which means sRGB.
    pub fn in_srgb(photo: &Photo) -> Self {
        let metadata = Metadata { icc: None, ..photo.metadata().clone() };
        Self { metadata, transfer: Transfer::srgb(), source: photo.source().map(Path::to_owned) }
    }
}

/// How a picture is written.
#[derive(Clone, Debug)]
pub struct PictureOptions {
    /// The format; none lets the file's name say it.
    pub format: Option<Format>,
    /// 8, or 16 where the format has that.
    pub bits: u8,
    /// Of JPEG, 1 … 100.
    pub quality: u8,
    /// Which metadata goes along.
    pub keep: Keep,
    /// Where the picture comes from.
    pub origin: Origin,
    /// What it takes along of how it was made; nothing where no metadata goes along.
    pub carry: Carry,
    /// Whether the photo's own file may be written over.
    pub replace_source: bool,
    /// Whether a file that is there, or comes there meanwhile, is replaced.
    pub replace: bool,
}

impl Default for PictureOptions {
    fn default() -> Self {
        let origin = Origin::default();
        let carry = Carry::default();
        Self {
            format: None,
            bits: 8,
            quality: 92,
            keep: Keep::All,
            origin,
            carry,
            replace_source: false,
            replace: true,
        }
    }
}

/// Writes a picture of linear light; the name's ending says the format.
pub fn picture(path: &Path, picture: &Picture, options: &PictureOptions) -> Result<(), SaveError> {
    let format = check(path, options)?;
    let bits = if format.has_16_bits() { options.bits } else { 8 };
    let stored = Pixels::from_linear(picture.size, &picture.rgb_linear, bits, &options.origin.transfer);
    pixels(path, &stored, options)
}

/// Writes stored values; the name's ending says the format.
pub fn pixels(path: &Path, pixels: &Pixels, options: &PictureOptions) -> Result<(), SaveError> {
    let format = check(path, options)?;
    let write = |file: &mut std::fs::File| {
        let mut out = BufWriter::with_capacity(1 << 18, file);
        encode(&mut out, format, pixels, options)?;
        out.into_inner().map(drop).map_err(|e| SaveError::from_io(e.error(), path))
    };
    if options.replace { atomic(path, write) } else { atomic_new(path, write) }
}

/// Whether a picture may be written to a path, before the work is done that makes it.
pub fn check(path: &Path, options: &PictureOptions) -> Result<Format, SaveError> {
    if path.is_dir() {
        return Err(SaveError::IsFolder(path.to_owned()));
    }
    if let Some(source) = &options.origin.source
        && !options.replace_source
        && same_file(source, path)
    {
        return Err(SaveError::IsSource(path.to_owned()));
    }
    options.format.or_else(|| Format::of(path)).ok_or_else(|| SaveError::Extension(path.to_owned()))
}
