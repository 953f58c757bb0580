//! Real light fields, to learn from and to be judged by: 8 × 8 views around the reference view of whatever grid the file
//! has.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use plenoscope::field::{DisparityMap, FieldError, LightField, View, ViewGrid, ViewIndex};
use plenoscope::io::{self, LightFieldFile, Opened};
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::{SynthError, lift, sweep};

use crate::TrainError;
use crate::recorded::packed;
use crate::scenes::REFERENCE;
use crate::scenes::raster::{Raster, Rgb};

/// Why a light field cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TrueFieldError {
    /// The file could not be read.
    #[error("{0}")]
    Open(#[from] io::OpenError),
    /// A packed light field that could not be read.
    #[error(transparent)]
    Packed(Box<TrainError>),
    /// A photo, not a light field.
    #[error("this is one photo; expected a light field (a folder of views, HCI or ESLF): {}", .0.display())]
    Photo(PathBuf),
    /// Too few views.
    #[error("a grid of {rows} × {cols} views; expected at least 8 × 8, with 4 views before the reference view: {}", path.display())]
    Grid {
        /// Rows of views.
        rows: usize,
        /// Columns of views.
        cols: usize,
        /// The light field.
        path: PathBuf,
    },
    /// Views that make no light field.
    #[error(transparent)]
    Views(#[from] FieldError),
    /// The sweep.
    #[error(transparent)]
    Sweep(#[from] SynthError),
}

/// 64 views, the reference view being layer 36.
pub struct TrueField {
    /// What it is called.
    pub name: String,
    /// Width and height of a view.
    pub size: [usize; 2],
    /// In `[v, u]` order, sRGB 0 … 1.
    pub views: Vec<Rgb>,
    /// The ray depths that the file has, layer and map `[y, x]` in pixels per view step: of all 64 views, of the reference
    /// view alone, or none.
    pub depths: Vec<(usize, Vec<f32>)>,
}

impl TrueField {
    /// Reads a light field of any format.
    ///
    /// # Errors
    /// [`TrueFieldError`], naming the file and what is expected.
    pub fn open(path: &Path) -> Result<Self, TrueFieldError> {
        if path.to_string_lossy().ends_with(packed::ENDING) {
            return packed::true_field(path).map_err(|error| TrueFieldError::Packed(Box::new(error)));
        }
        let cancel = Cancel::default();
        let opened = io::open(path, &Job { cancel: &cancel, sink: &() })?;
        match opened {
            Opened::LightField(file) => Self::of(path, *file),
            Opened::Photo(_) => Err(TrueFieldError::Photo(path.to_owned())),
        }
    }

    /// What `path` was opened as.
    ///
    /// # Errors
    /// A grid that is too small; views that make no light field.
    pub fn of(path: &Path, file: LightFieldFile) -> Result<Self, TrueFieldError> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let size = file.field.size().map(|side| side as usize);
        let views = Self::views(&file.field, path, file.display_gamma.unwrap_or(1.0))?;
        let depths = match (&file.depths, file.reference_disparity) {
            (Some(all), _) => {
                (0..64).map(|layer| (layer, all.view(around(all.grid().reference(), layer)).to_vec())).collect()
            }
            (None, Some(map)) if map.size() == file.field.size() => vec![(REFERENCE, map.into_disparity_px())],
            _ => Vec::new(),
        };
        Ok(Self { name, size, views, depths })
    }

    fn views(field: &LightField, path: &Path, gamma: f32) -> Result<Vec<Rgb>, TrueFieldError> {
        let (grid, zero) = (field.grid(), field.grid().reference());
        let fits = |zero: u8, count: usize| zero >= 4 && usize::from(zero) + 4 <= count;
        if !fits(zero.v, grid.rows()) || !fits(zero.u, grid.cols()) {
            return Err(TrueFieldError::Grid { rows: grid.rows(), cols: grid.cols(), path: path.to_owned() });
        }
        Ok((0..64).map(|layer| picture(field.view(around(zero, layer)), gamma)).collect())
    }

    /// The views of a light field of the paper's grid.
    pub fn of_views(field: &LightField) -> Vec<Rgb> {
        field.grid().views().map(|at| picture(field.view(at), 1.0)).collect()
    }

    /// The view that the prediction is made from.
    pub fn reference(&self) -> &Rgb {
        &self.views[REFERENCE]
    }

    /// The ray depth `[y, x]` that the file has of the reference view.
    pub fn own_reference_depth(&self) -> Option<&[f32]> {
        self.depths.iter().find(|(layer, _)| *layer == REFERENCE).map(|(_, map)| &map[..])
    }

    /// Ray depth of the reference view in pixels per view step: the file's own, else what the viewer's plane sweep over all views finds.
    ///
    /// # Errors
    /// Views of several sizes.
    pub fn reference_disparity(&self) -> Result<Raster<f32>, TrueFieldError> {
        if let Some(known) = self.own_reference_depth() {
            return Ok(Raster { size: self.size, px: known.to_vec() });
        }
        let cancel = Cancel::default();
        let field = light_field(&self.views)?;
        let map = sweep::reference_map(&field, &Job { cancel: &cancel, sink: &() })?;
        Ok(Raster { size: self.size, px: map.into_disparity_px() })
    }
}

/// A view, its colours raised to a power.
fn picture(view: &View, gamma: f32) -> Rgb {
    let texel = |p: &[u8]| [0, 1, 2].map(|c| (f32::from(p[c]) / 255.0).powf(gamma));
    Raster { size: view.size().map(|side| side as usize), px: view.rgba().chunks_exact(4).map(texel).collect() }
}

/// Where a layer of the 8 × 8 views lies in a grid whose reference view is `zero`.
fn around(zero: ViewIndex, layer: usize) -> ViewIndex {
    let [v, u] = [layer / 8, layer % 8].map(|i| i as u8);
    ViewIndex { v: zero.v + v - 4, u: zero.u + u - 4 }
}

/// The ray depths of all 64 views, `[v, y, x]`, that one map of the reference view gives.
pub fn lifted(map: &[f32], size: [usize; 2]) -> Vec<f32> {
    let flat = || map.repeat(ViewGrid::PAPER.count());
    let map = DisparityMap::new(size.map(|side| side as u32), map.to_vec());
    map.map_or_else(|_| flat(), |map| lift::ray_depths(&map, ViewGrid::PAPER).disparity_px().to_vec())
}

/// 64 pictures as a light field of 8-bit views.
///
/// # Errors
/// Another number of them; several sizes.
pub fn light_field(views: &[Rgb]) -> Result<LightField, FieldError> {
    let view = |picture: &Rgb| View::new(picture.size.map(|side| side as u32), picture.rgba8()).map(Arc::new);
    LightField::new(ViewGrid::PAPER, views.iter().map(view).collect::<Result<_, _>>()?)
}
