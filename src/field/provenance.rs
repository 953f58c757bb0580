//! Where the colour of each ray comes from.

use super::{FieldError, Raster, Size, ViewGrid, ViewIndex, check_len, pixels};

/// Where the colour of a ray comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Seen {
    /// The reference photo sees it.
    Reference = 0,
    /// Another photo of the burst sees it.
    Frame = 1,
    /// Nobody has seen it.
    Invented = 2,
}

/// Where the colour of every ray of a light field comes from.
///
/// # Shapes
/// - `rays`: `[v, u, y, x]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    grid: ViewGrid,
    size: Size,
    rays: Vec<Seen>,
}

impl Provenance {
    /// Of a grid of views of `[width, height]` pixels.
    pub fn new(grid: ViewGrid, size: Size, rays: Vec<Seen>) -> Result<Self, FieldError> {
        check_len("the provenance", grid.count() * pixels(size), rays.len())?;
        Ok(Self { grid, size, rays })
    }

    /// Rows and columns of views.
    pub fn grid(&self) -> ViewGrid {
        self.grid
    }

    /// Width and height of a view, in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Those of one view, `[y, x]`.
    pub fn view(&self, at: ViewIndex) -> &[Seen] {
        let plane = pixels(self.size);
        let start = self.grid.layer_from_view(at) * plane;
        &self.rays[start..start + plane]
    }

    /// Of one ray.
    pub fn at(&self, view: ViewIndex, x: u32, y: u32) -> Seen {
        self.view(view)[y as usize * self.size[0] as usize + x as usize]
    }

    /// The share of all rays that comes from there, 0 … 1.
    pub fn share(&self, from: Seen) -> f32 {
        self.rays.iter().filter(|seen| **seen == from).count() as f32 / self.rays.len() as f32
    }

    /// One view as a picture: white from the reference photo, grey from another, black invented.
    pub fn picture(&self, at: ViewIndex) -> Raster<u8> {
        let [w, _] = super::sides(self.size);
        let view = self.view(at);
        Raster::from_fn(self.size, |x, y| GREYS[view[y * w + x] as usize])
    }
}

/// What stands for each in a picture.
const GREYS: [u8; 3] = [255, 128, 0];

impl Seen {
    /// What a grey of [`Provenance::picture`] stands for.
    pub fn of_grey(grey: u8) -> Self {
        match grey {
            192.. => Self::Reference,
            64.. => Self::Frame,
            _ => Self::Invented,
        }
    }
}
