//! The scene as pictures for another renderer that does as this one does: what each pixel sees, and what is behind.

use rayon::prelude::*;

use super::Prepared;
use crate::background::{DISTANCE, SHARE};
use crate::field::{Size, sides};

/// What each pixel of a picture sees, and what goes on behind near edges.
///
/// # Shapes
/// - `rgb_linear`, `near_px`, `far_px`, `cover`: `[y, x]` of `size`
/// - `behind`: `[y, x]` of `behind_size`
pub struct Layers {
    /// Width and height.
    pub size: Size,
    /// The photo's light.
    pub rgb_linear: Vec<[f32; 3]>,
    /// Disparity of the near side, or of the only one, in pixels of the map's width.
    pub near_px: Vec<f32>,
    /// Disparity of the far side.
    pub far_px: Vec<f32>,
    /// How much of the pixel the near side covers, 0 … 1.
    pub cover: Vec<f32>,
    /// How far a pixel of the far side has a colour that a camera put there from the near one, 0 … 1.
    pub stained: Vec<f32>,
    /// Width and height of the grid of what is behind.
    pub behind_size: Size,
    /// What is behind.
    pub behind: Vec<Hidden>,
    /// Pixels of the picture per pixel of the map.
    pub scale: f32,
}

/// What is behind one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hidden {
    /// Linear light.
    pub rgb: [f32; 3],
    /// Disparity, in pixels of the map's width.
    pub disparity_px: f32,
    /// How much is known, 0 … 1.
    pub share: f32,
    /// Cells from the edge.
    pub distance: f32,
}

impl Prepared {
    /// Everything that a picture is made of, for those who make it elsewhere.
    pub fn layers(&self) -> Layers {
        let [width, height] = sides(self.size);
        let reader = self.reader(0, width);
        let rows: Vec<_> = (0..height as i32)
            .into_par_iter()
            .map(|y| {
                let mut rgb = vec![[0.0; 3]; width];
                self.light.row(0, y, &mut rgb);
                let row = reader.at_row(y);
                let seen = rgb.iter().enumerate().map(|(i, color)| reader.at(&row, i, color).0);
                let seen: Vec<_> = seen.map(|seen| (seen.near_px, seen.far_px, seen.cover, seen.stained)).collect();
                (rgb, seen)
            })
            .collect();
        let (rgb, seen): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
        let seen = seen.concat();
        let (behind_size, behind) = self.behind.cells();
        Layers {
            size: self.size,
            rgb_linear: rgb.concat(),
            near_px: seen.iter().map(|seen| seen.0).collect(),
            far_px: seen.iter().map(|seen| seen.1).collect(),
            cover: seen.iter().map(|seen| seen.2).collect(),
            stained: seen.iter().map(|seen| seen.3).collect(),
            behind_size,
            behind,
            scale: self.size[0] as f32 / self.surfaces.map_size()[0] as f32,
        }
    }
}

impl super::Behind {
    /// What is behind, cell by cell.
    fn cells(&self) -> (Size, Vec<Hidden>) {
        let of = |cell: &[f32; 6]| {
            let share = cell[SHARE];
            let mean = |c: usize| if share > 0.02 { cell[c] / share } else { 0.0 };
            let share = if share > 0.02 { share.min(1.0) } else { 0.0 };
            Hidden { rgb: [mean(0), mean(1), mean(2)], disparity_px: mean(3), share, distance: cell[DISTANCE] }
        };
        let cells = self.raster();
        (cells.size(), cells.pixels().iter().map(of).collect())
    }
}
