//! The front door: a path or some bytes → what is in them.

use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

use super::carried::{self, Carried};
use super::file_type::FileType;
use super::formats::{self, phone::gdepth};
use super::raster::{self, Raster};
use super::xmp::Xmp;
use super::{DepthInfo, EmbeddedDepth, FileInfo, FileKind, OpenError, Opened, PhotoFile, Problem, exif, folder};
use crate::aside::parent;
use crate::field::{Photo, Size, pixels};
use crate::job::{Cancel, Job, Stage};
use crate::within;

/// The longest file that is read: a light field of 17×17 views in one TIFF stays below, and 600 megapixels as they are.
pub const MAX_FILE_BYTES: u64 = 1 << 31;
/// The longest text that is read: an index file.
pub(crate) const MAX_TEXT_BYTES: u64 = 16 << 20;

/// What a picture's edit is called among the notes.
const CARRIED: &str = "inside";

/// Opens a photo or a light field: a file, or a folder of views. A folder of photos opens as its first photo.
///
/// # Errors
/// [`OpenError`], which names the file and the reason in one sentence.
pub fn open(path: &Path, job: &Job) -> Result<Opened, OpenError> {
    job.advance(Stage::Open, 0, 1)?;
    let own = path.to_owned();
    // Decoders look at no flag.
    let opened = job.alone(move |job| open_path(&own, job))?.map_err(OpenError::at(Some(path)))?;
    job.advance(Stage::Open, 1, 1)?;
    Ok(opened)
}

/// Opens what is already in memory. `name` tells where it came from; files beside it are not looked at.
///
/// # Errors
/// [`OpenError`], which names the reason in one sentence.
pub fn open_bytes(bytes: &[u8], name: Option<&Path>) -> Result<Opened, OpenError> {
    let job = Job { cancel: &Cancel::default(), sink: &() };
    open_content(bytes, name, &job).map_err(OpenError::at(name))
}

fn open_path(path: &Path, job: &Job) -> Result<Opened, Problem> {
    if path.is_dir() {
        return open_folder(path, job);
    }
    if formats::is_index_file(path) {
        return open_folder(parent(path), job);
    }
    let bytes = read_file(path)?;
    job.check()?;
    let mut opened = open_content(&bytes, Some(path), job)?;
    if let Opened::Photo(file) = &mut opened {
        formats::add_depth_beside(path, file);
    }
    Ok(opened)
}

fn open_folder(path: &Path, job: &Job) -> Result<Opened, Problem> {
    if let Some(opened) = formats::read_folder(path, job)? {
        return Ok(opened);
    }
    let first = folder::pictures(path)?.into_iter().next().ok_or(Problem::EmptyFolder)?;
    open_path(&first, job).map_err(Problem::of(&first))
}

/// Reads a picture file whole; one that is none is not read beyond its first bytes.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, Problem> {
    let mut head = Vec::new();
    within::open(path)?.take(64).read_to_end(&mut head)?;
    FileType::of(&head)?;
    read_up_to(path, MAX_FILE_BYTES)
}

/// Reads a file whole, but not one that is longer than what it should hold.
pub(crate) fn read_up_to(path: &Path, max_bytes: u64) -> Result<Vec<u8>, Problem> {
    within::bytes(path, max_bytes).map_err(|error| match error.kind() {
        ErrorKind::FileTooLarge => {
            let length = std::fs::metadata(path).map_or(max_bytes, |facts| facts.len());
            Problem::TooLong { length_kib: length.div_ceil(1024), limit_kib: max_bytes.div_ceil(1024) }
        }
        _ => Problem::Read(error),
    })
}

pub(super) fn open_content(bytes: &[u8], name: Option<&Path>, job: &Job) -> Result<Opened, Problem> {
    let kind = FileType::of(bytes)?;
    match formats::read_within(bytes, name, job)? {
        Some(file) => Ok(file.into()),
        None => Ok(kind.open(bytes, job)?.with_source(name).into()),
    }
}

fn reduced([width, height]: Size, whole: Size) -> String {
    let megapixels = pixels(whole) / 1_000_000;
    format!(
        "the photo has {megapixels} megapixels — it is shown with {width}×{height}, and a picture is exported as large as its file"
    )
}

/// The photo as large as in its file, where it was opened reduced.
///
/// # Errors
/// [`OpenError`]: the file has gone, or is another one by now.
pub fn open_whole(photo: &Photo, job: &Job) -> Result<Arc<Photo>, OpenError> {
    job.advance(Stage::Open, 0, 1)?;
    let path = photo.source().unwrap_or(Path::new("")).to_owned();
    let size = photo.whole_size();
    let own = path.clone();
    let read = move |job: &Job| -> Result<Photo, Problem> {
        let bytes = read_file(&own)?;
        job.check()?;
        Ok(raster::decode(&bytes)?.into_photo()?.0)
    };
    let whole = job.alone(read)?.map_err(OpenError::at(Some(&path)))?;
    if whole.size() != size {
        return Err(OpenError::at(Some(&path))(Problem::Changed));
    }
    Ok(Arc::new(whole.with_source(&path)))
}

impl PhotoFile {
    /// A photo without depth. One that is too large to be kept is reduced, and knows how large it was.
    pub(crate) fn from_raster(raster: Raster, format: &'static str) -> Result<Self, Problem> {
        let whole = raster.upright_size();
        let (photo, mut warnings) = raster.reduced().into_photo()?;
        let photo = photo.reduced_from(whole);
        if photo.size() != whole {
            warnings.push(reduced(photo.size(), whole));
        }
        let metadata = photo.metadata();
        let info = FileInfo {
            kind: FileKind::Photo,
            format,
            size: whole,
            views: None,
            orientation: metadata.orientation,
            profile: metadata.icc.as_deref().and_then(raster::profile_name),
            bits: photo.pixels().bits(),
            embedded_depth: None,
            f35_mm: metadata.exif.as_deref().and_then(exif::f35_mm),
            disparity_px: None,
            notes: Vec::new(),
            warnings: warnings.clone(),
        };
        Ok(Self { photo: Arc::new(photo), depth: None, carried: None, splats: None, info, warnings })
    }

    /// Takes a depth map in.
    pub(crate) fn set_depth(&mut self, depth: EmbeddedDepth) {
        self.info.embedded_depth = Some(DepthInfo::from(&depth));
        self.depth = Some(depth);
    }

    /// Takes in what this program writes into the XMP of every format: an edit, and depth as phones write it.
    pub(crate) fn with_xmp(mut self) -> Self {
        let photo = Arc::clone(&self.photo);
        let Some(packet) = photo.metadata().xmp.as_deref() else { return self };
        let Ok(xmp) = Xmp::parse(packet) else {
            // A broken packet goes along as it is.
            self.take_carried(carried::find_damaged(packet));
            return self;
        };
        let orientation = photo.metadata().orientation;
        self.take_carried(carried::find(&xmp, None));
        let oriented = |depth: EmbeddedDepth| depth.oriented(orientation).map_err(|error| error.to_string());
        match gdepth::find(&xmp, None).map(|found| found.and_then(oriented)) {
            Some(Ok(depth)) => self.set_depth(depth),
            Some(Err(why)) => self.warn(formats::depth_left_out(&why)),
            None => {}
        }
        self
    }

    /// Takes in what its XMP says of how it was made.
    pub(crate) fn take_carried(&mut self, found: Option<Result<Carried, String>>) {
        let told = found.as_ref().map(|found| match found {
            Ok(carried) => format!("{} (--recipe embedded)", carried.told()),
            Err(why) => format!("an edit that cannot be used: {why}"),
        });
        self.info.notes.retain(|(name, _)| name != CARRIED);
        self.info.notes.extend(told.map(|text| (CARRIED.to_owned(), text)));
        self.carried = found;
    }

    /// Tells the person something.
    pub(crate) fn warn(&mut self, text: String) {
        self.info.warnings.push(text.clone());
        self.warnings.push(text);
    }

    pub(super) fn with_source(mut self, name: Option<&Path>) -> Self {
        if let Some(name) = name {
            self.photo = Arc::new(Photo::clone(&self.photo).with_source(name));
        }
        self
    }
}
