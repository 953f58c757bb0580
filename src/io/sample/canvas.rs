//! A band of rows that shapes are painted on.

use glam::Vec3;

use super::shapes::Shape;
use crate::field::ramp;

/// Some rows of the picture: linear light and disparity.
pub struct Band {
    width: usize,
    first_row: usize,
    rows: usize,
    light: Vec<Vec3>,
    disparity: Vec<f32>,
}

impl Band {
    /// Black rows, `first_row` being the place of the first in the picture.
    pub fn new(width: usize, first_row: usize, rows: usize) -> Self {
        let pixels = width * rows;
        Self { width, first_row, rows, light: vec![Vec3::ZERO; pixels], disparity: vec![0.0; pixels] }
    }

    /// Paints what of a shape falls on these rows. Disparity is that of the nearest shape that covers half a pixel.
    pub fn paint(&mut self, shape: &dyn Shape) {
        let [left, top, right, bottom] = shape.bounds();
        let row = |y: f32| (y.max(0.0) as usize).saturating_sub(self.first_row).min(self.rows);
        let column = |x: f32| (x.max(0.0) as usize).min(self.width);
        let (rows, columns) = (row(top)..row(bottom + 2.0), column(left)..column(right + 2.0));
        for y in rows {
            for x in columns.clone() {
                let Some(paint) = shape.at(x as f32, (self.first_row + y) as f32) else { continue };
                let at = y * self.width + x;
                self.light[at] = self.light[at].lerp(paint.light, paint.cover);
                if paint.cover >= 0.5 {
                    self.disparity[at] = paint.disparity;
                }
            }
        }
    }

    /// Linear light of the `at`-th pixel.
    pub fn light(&self, at: usize) -> Vec3 {
        self.light[at]
    }

    /// Disparity of all pixels.
    pub fn disparity(&self) -> &[f32] {
        &self.disparity
    }
}

/// A number from 0 to 1 that looks random, the same for the same pair.
pub fn hash(a: u32, b: u32) -> f32 {
    let mut n = a.wrapping_mul(0x9E37_79B1) ^ b.wrapping_mul(0x85EB_CA77).rotate_left(13);
    n = (n ^ (n >> 15)).wrapping_mul(0x2C1B_3C6D);
    n = (n ^ (n >> 12)).wrapping_mul(0x297A_2D39);
    ((n ^ (n >> 15)) >> 8) as f32 / (1 << 24) as f32
}

/// Smooth noise from −1 to 1 with features about one unit wide.
pub fn noise(x: f32, y: f32, seed: u32) -> f32 {
    let (cell_x, cell_y) = (x.floor(), y.floor());
    let (tx, ty) = (ramp(0.0, 1.0, x - cell_x), ramp(0.0, 1.0, y - cell_y));
    let corner =
        |dx: i32, dy: i32| hash((cell_x as i32 + dx) as u32 ^ seed.rotate_left(16), (cell_y as i32 + dy) as u32);
    let top = corner(0, 0) * (1.0 - tx) + corner(1, 0) * tx;
    let bottom = corner(0, 1) * (1.0 - tx) + corner(1, 1) * tx;
    (top * (1.0 - ty) + bottom * ty) * 2.0 - 1.0
}
