//! What comes out of [`open`](fn@super::open): the file's content, and what it was.

use std::sync::Arc;

use serde::Serialize;

use super::DisparityMap;
use super::carried::Carried;
use super::formats::layout::Layout;
use super::raster::orient;
use crate::field::{FieldError, LightField, Photo, Provenance, RayDepths, RelativeDepth};
use crate::splats::Pictured;

/// A file, told by its content.
#[derive(Debug)]
pub enum Opened {
    /// One photo.
    Photo(Box<PhotoFile>),
    /// A grid of views.
    LightField(Box<LightFieldFile>),
}

impl From<LightFieldFile> for Opened {
    fn from(file: LightFieldFile) -> Self {
        Self::LightField(Box::new(file))
    }
}

impl From<PhotoFile> for Opened {
    fn from(file: PhotoFile) -> Self {
        Self::Photo(Box::new(file))
    }
}

impl Opened {
    /// What the file is.
    pub fn info(&self) -> &FileInfo {
        match self {
            Self::Photo(file) => &file.info,
            Self::LightField(file) => &file.info,
        }
    }
}

/// A photo and what else was in its file.
#[derive(Debug)]
pub struct PhotoFile {
    /// The upright photo. For a portrait photo with a blurred front, the all-in-focus original, where the file has it.
    pub photo: Arc<Photo>,
    /// Depth that the phone measured.
    pub depth: Option<EmbeddedDepth>,
    /// What it says of how it was made, where this program wrote it; else why that cannot be used.
    pub carried: Option<Result<Carried, String>>,
    /// The scene that it is a picture of, where the file holds Gaussian splats.
    pub splats: Option<Arc<Pictured>>,
    /// What the file is.
    pub info: FileInfo,
    /// What a person should know: for example a depth map that could not be read.
    pub warnings: Vec<String>,
}

/// A light field and what else was in its files.
#[derive(Debug)]
pub struct LightFieldFile {
    /// The views.
    pub field: Arc<LightField>,
    /// Whether the views are only those at the corners of the grid: upper left, upper right, lower left, lower right.
    pub corners: bool,
    /// The disparity of every ray, where the file has it.
    pub depths: Option<Arc<RayDepths>>,
    /// Where each ray's colour comes from, where the file says it.
    pub provenance: Option<Arc<Provenance>>,
    /// The disparity of the reference view alone, where the file has only that (HCI benchmark scenes).
    pub reference_disparity: Option<DisparityMap>,
    /// What was done to the stored views to fit our convention; `layout.opposite()` is the other sign.
    pub layout: Layout,
    /// γ with which a dark file should be shown and given to nets: `shown = stored ^ γ`. Never baked into what is saved.
    pub display_gamma: Option<f32>,
    /// What the file is.
    pub info: FileInfo,
    /// What a person should know: for example views that were turned over to fit the sign convention.
    pub warnings: Vec<String>,
}

impl LightFieldFile {
    /// Views with or without ray depths; the warnings are those of `info`.
    pub(crate) fn new(field: Arc<LightField>, depths: Option<Arc<RayDepths>>, mut info: FileInfo) -> Self {
        if let Some(depths) = &depths {
            info.disparity_px = Some(depths.range_px());
        }
        let warnings = info.warnings.clone();
        Self {
            field,
            corners: false,
            depths,
            provenance: None,
            reference_disparity: None,
            layout: Layout::default(),
            display_gamma: None,
            info,
            warnings,
        }
    }

    /// Tells the person something.
    pub(crate) fn warn(&mut self, text: String) {
        self.info.warnings.push(text.clone());
        self.warnings.push(text);
    }
}

/// Depth that came with a photo, as the phone measured it.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddedDepth {
    /// Where it comes from.
    pub kind: DepthKind,
    /// Inverse depth, upright, covering the whole photo: 1/m where `metric`, else in a unit that only orders (affine to
    /// 1/m). Its size is seldom that of the photo.
    pub map: RelativeDepth,
    /// Whether the values are 1/m.
    pub metric: bool,
}

impl EmbeddedDepth {
    /// The same, turned upright as EXIF says.
    pub(crate) fn oriented(self, orientation: u8) -> Result<Self, FieldError> {
        let (size, nearness) = orient(self.map.nearness().to_vec(), self.map.size(), orientation);
        Ok(Self { map: RelativeDepth::new(size, nearness)?, ..self })
    }
}

/// Where a photo's depth comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DepthKind {
    /// GDepth in the XMP of a JPEG (Google Lens Blur and many phones).
    Gdepth,
    /// Dynamic Depth: pictures behind the JPEG (Android 10 and later).
    DynamicDepth,
    /// The auxiliary picture of an Apple portrait photo.
    ApplePortrait,
    /// Both eyes of a spatial photo, matched.
    SpatialPair,
    /// The depth look-up table of a processed Lytro file.
    LytroTable,
    /// A file beside the photo (`_DEPTH`).
    SideFile,
}

impl std::fmt::Display for DepthKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Gdepth => "GDepth",
            Self::DynamicDepth => "Dynamic Depth",
            Self::ApplePortrait => "Apple portrait",
            Self::SpatialPair => "from both eyes of a spatial photo",
            Self::LytroTable => "Lytro's depth table",
            Self::SideFile => "a file beside the photo",
        })
    }
}

/// What `info` says of embedded depth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DepthInfo {
    /// Where it comes from.
    pub kind: DepthKind,
    /// Width and height of the map.
    pub size: [u32; 2],
    /// Nearest and farthest measured point in metres, where the values are metric.
    pub range_m: Option<[f32; 2]>,
}

impl From<&EmbeddedDepth> for DepthInfo {
    fn from(depth: &EmbeddedDepth) -> Self {
        let finite = || depth.map.nearness().iter().copied().filter(|n| n.is_finite() && *n > 0.0);
        let (far, near) = (finite().fold(f32::INFINITY, f32::min), finite().fold(0.0, f32::max));
        let range_m = (depth.metric && near > 0.0).then(|| [1.0 / near, 1.0 / far]);
        Self { kind: depth.kind, size: depth.map.size(), range_m }
    }
}

/// Photo, light field or splats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum FileKind {
    /// One picture.
    #[serde(rename = "photo")]
    Photo,
    /// A grid of views.
    #[serde(rename = "light field")]
    LightField,
    /// A scene of Gaussian splats.
    #[serde(rename = "splats")]
    Splats,
}

/// What a file is: the object that `info --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileInfo {
    /// Photo, light field or splats.
    pub kind: FileKind,
    /// The format's name.
    pub format: &'static str,
    /// Width and height of the upright photo, or of a view.
    pub size: [u32; 2],
    /// Rows and columns of views.
    pub views: Option<[usize; 2]>,
    /// EXIF orientation that was in the file, 1 … 8.
    pub orientation: u8,
    /// Name of the colour profile.
    pub profile: Option<String>,
    /// Bits of a channel.
    pub bits: u8,
    /// Depth that came with the photo.
    pub embedded_depth: Option<DepthInfo>,
    /// Focal length as on 35-mm film.
    pub f35_mm: Option<f32>,
    /// Least and greatest disparity, in pixels per view step, where the file says it.
    pub disparity_px: Option<[f32; 2]>,
    /// What else the file says that a person may want to know: name and text.
    pub notes: Vec<(String, String)>,
    /// What was not as it should be.
    pub warnings: Vec<String>,
}

impl FileInfo {
    /// A light field's description, before anything else is known of it.
    pub(crate) fn light_field(format: &'static str, field: &LightField) -> Self {
        Self {
            kind: FileKind::LightField,
            format,
            size: field.size(),
            views: Some([field.grid().rows(), field.grid().cols()]),
            orientation: 1,
            profile: None,
            bits: 8,
            embedded_depth: None,
            f35_mm: None,
            disparity_px: None,
            notes: Vec::new(),
            warnings: Vec::new(),
        }
    }
}
