//! Real light fields, to learn from and to be judged by: 8 × 8 views around the reference view of whatever grid the file
//! has.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use plenoscope::field::{FieldError, LightField, View, ViewGrid, ViewIndex};
use plenoscope::io::{self, Opened};
use plenoscope::job::{Cancel, Cancelled, Job};
use plenoscope::synth::sweep;

use crate::scenes::REFERENCE;
use crate::scenes::raster::{Raster, Rgb};

/// Why a light field cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TrueFieldError {
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
    /// Views that make no light field.
    #[error(transparent)]
    Views(#[from] FieldError),
    /// The sweep was stopped.
    #[error(transparent)]
    Stopped(#[from] Cancelled),
}

/// 64 views, the reference view being layer 36.
pub struct TrueField {
    /// What it is called.
    pub name: String,
    /// Width and height of a view.
    pub size: [usize; 2],
    /// In `[v, u]` order, sRGB 0 … 1.
    pub views: Vec<Rgb>,
    /// Ray depth of the reference view, pixels per view step, where the file has it.
    pub disparity: Option<Raster<f32>>,
}

impl TrueField {
    /// Reads a light field of any format.
    ///
    /// # Errors
    /// [`TrueFieldError`], naming the file and what is expected.
    pub fn open(path: &Path) -> Result<Self, TrueFieldError> {
        let cancel = Cancel::default();
        let opened = io::open(path, &Job { cancel: &cancel, sink: &() })?;
        let Opened::LightField(file) = opened else { return Err(TrueFieldError::Photo(path.to_owned())) };
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let size = file.field.size().map(|side| side as usize);
        let of_all = file.depths.as_ref().map(|depths| depths.reference().to_vec());
        let alone = file.reference_disparity.as_ref().map(|map| map.disparity_px.clone());
        let disparity = of_all.or(alone).filter(|px| px.len() == size[0] * size[1]).map(|px| Raster { size, px });
        let views = Self::views(&file.field, path, file.display_gamma.unwrap_or(1.0))?;
        Ok(Self { name, size, views, disparity })
    }

    fn views(field: &LightField, path: &Path, gamma: f32) -> Result<Vec<Rgb>, TrueFieldError> {
        let (grid, zero) = (field.grid(), field.grid().reference());
        let fits = |zero: u8, count: usize| zero >= 4 && usize::from(zero) + 4 <= count;
        if !fits(zero.v, grid.rows()) || !fits(zero.u, grid.cols()) {
            return Err(TrueFieldError::Grid { rows: grid.rows(), cols: grid.cols(), path: path.to_owned() });
        }
        let size = field.size().map(|side| side as usize);
        let view = |layer: u8| {
            let at = ViewIndex { v: zero.v - 4 + layer / 8, u: zero.u - 4 + layer % 8 };
            let texel = |p: &[u8]| [0, 1, 2].map(|c| (f32::from(p[c]) / 255.0).powf(gamma));
            Raster { size, px: field.view(at).rgba().chunks_exact(4).map(texel).collect() }
        };
        Ok((0..64).map(view).collect())
    }

    /// The view that the prediction is made from.
    pub fn reference(&self) -> &Rgb {
        &self.views[REFERENCE]
    }

    /// Ray depth of the reference view in pixels per view step: the file's own, else what the viewer's plane sweep over all views finds.
    ///
    /// # Errors
    /// Views of several sizes.
    pub fn reference_disparity(&self) -> Result<Raster<f32>, TrueFieldError> {
        if let Some(known) = &self.disparity {
            return Ok(known.clone());
        }
        let cancel = Cancel::default();
        let field = light_field(&self.views)?;
        let map = sweep::reference_map(&field, &Job { cancel: &cancel, sink: &() })?;
        Ok(Raster { size: self.size, px: map.disparity_px })
    }
}

/// 64 pictures as a light field of 8-bit views.
///
/// # Errors
/// Another number of them; several sizes.
pub fn light_field(views: &[Rgb]) -> Result<LightField, FieldError> {
    let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let view = |picture: &Rgb| {
        let rgba = picture.px.iter().flat_map(|p| [byte(p[0]), byte(p[1]), byte(p[2]), 255]).collect();
        View::new(picture.size.map(|side| side as u32), rgba).map(Arc::new)
    };
    LightField::new(ViewGrid::PAPER, views.iter().map(view).collect::<Result<_, _>>()?)
}
