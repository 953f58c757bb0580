//! A true light field to compare with: 8 × 8 views around the reference view of whatever grid the file has.

use std::path::{Path, PathBuf};

use plenoscope::field::{LightField, ViewIndex};
use plenoscope::io::{self, Opened};
use plenoscope::job::{Cancel, Job};

use super::metrics::Rgb;
use crate::scenes::REFERENCE;
use crate::scenes::raster::Raster;

/// Why a light field or a folder of photos cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum EvalError {
    /// The file could not be read.
    #[error("{0}")]
    Open(#[from] io::OpenError),
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
    /// Nothing to evaluate on.
    #[error("no validation pictures; expected flowers/ or everyday/ with `split` val in their manifests: {}", .0.display())]
    NoPhotos(PathBuf),
    /// Writing a contact sheet failed.
    #[error("{0}")]
    Save(#[from] io::save::SaveError),
}

/// 64 views, the reference view being layer 36.
pub struct TrueField {
    /// What it is called.
    pub name: String,
    /// Width and height of a view.
    pub size: [usize; 2],
    /// In `[v, u]` order, sRGB 0 … 1.
    pub views: Vec<Rgb>,
}

impl TrueField {
    /// Reads a light field of any format.
    ///
    /// # Errors
    /// [`EvalError`], naming the file and what is expected.
    pub fn open(path: &Path) -> Result<Self, EvalError> {
        let cancel = Cancel::default();
        let opened = io::open(path, &Job { cancel: &cancel, sink: &() })?;
        let Opened::LightField(file) = opened else { return Err(EvalError::Photo(path.to_owned())) };
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Self::from_field(&file.field, name, path, file.display_gamma.unwrap_or(1.0))
    }

    fn from_field(field: &LightField, name: String, path: &Path, gamma: f32) -> Result<Self, EvalError> {
        let (grid, zero) = (field.grid(), field.grid().reference());
        let fits = |zero: u8, count: usize| zero >= 4 && usize::from(zero) + 4 <= count;
        if !fits(zero.v, grid.rows()) || !fits(zero.u, grid.cols()) {
            return Err(EvalError::Grid { rows: grid.rows(), cols: grid.cols(), path: path.to_owned() });
        }
        let size = field.size().map(|side| side as usize);
        let view = |layer: u8| {
            let at = ViewIndex { v: zero.v - 4 + layer / 8, u: zero.u - 4 + layer % 8 };
            let texel = |p: &[u8]| [0, 1, 2].map(|c| (f32::from(p[c]) / 255.0).powf(gamma));
            Raster { size, px: field.view(at).rgba().chunks_exact(4).map(texel).collect() }
        };
        Ok(Self { name, size, views: (0..64).map(view).collect() })
    }

    /// The view that the prediction is made from.
    pub fn reference(&self) -> &Rgb {
        &self.views[REFERENCE]
    }
}
