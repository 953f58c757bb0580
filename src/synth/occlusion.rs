//! The occlusion net (paper, §3.3): `L̂ = õ(L_r, D) + L_r`.
//!
//! A net that is nothing but a chain of convolutions over the views goes down the picture row by row: Lambertian
//! colours are rendered straight into its first layer, and nothing of the picture's size lies between its layers. Any
//! other net is run in strips of rows, so that memory stays bounded.

use glam::Vec4;
use rayon::prelude::*;

use super::far_side::FarSide;
use super::lambertian::{encode, fill_row, render_row};
use super::net::Net;
use super::picture::Signed;
use super::{ModelError, ModelFile, SynthError};
use crate::field::{RayDepths, Size, View, ViewGrid, bilinear, center_at, pixels, sides};
use crate::job::{Cancelled, Job, Progress, Stage};
use crate::kernel::winograd::{Columns, Rows, VolumeChain};

/// Rows (and columns) that the net sees beyond a pixel: five layers of 3×3×3.
const HALO: usize = 5;
/// Memory that the widest activation of one strip may take.
const STRIP_BYTES: usize = 96 << 20;
/// Channels of the widest activation.
const WIDEST: usize = 8;

/// The occlusion net of a manifest with `task = "occlusion"`.
pub(super) struct OcclusionNet {
    net: Net,
}

/// Residuals of all views, as multiples of 1 / 32767: half the memory, far below a step of 8 bits.
///
/// # Shapes
/// - `rgb`: `[v, u, c, y, x]`
pub(super) struct Residuals {
    size: Size,
    rgb: Vec<i16>,
}

const UNIT: f32 = 32767.0;

fn stored(residual: f32) -> i16 {
    (residual.clamp(-1.0, 1.0) * UNIT).round() as i16
}

impl OcclusionNet {
    /// Checks the model against its manifest and the grid of the depth net.
    pub(super) fn load(file: ModelFile, grid: ViewGrid) -> Result<Self, ModelError> {
        file.check_grid(grid)?;
        let views = grid.count();
        let net = Net::load(file, |h, w| vec![1, 4, views, h, w], |h, w| vec![1, 3, views, h, w])?;
        Ok(Self { net })
    }

    pub(super) fn net(&self) -> &Net {
        &self.net
    }

    /// Residuals for the Lambertian views of `photo` with these ray depths (both of one size).
    pub(super) fn residuals(
        &self,
        photo: &Signed,
        depths: &RayDepths,
        threads: usize,
        job: &Job,
    ) -> Result<Residuals, SynthError> {
        if let Some(chain) = self.net.volume_chain() {
            return Ok(row_by_row(chain, photo, depths, job)?);
        }
        let [w, h] = photo.sides();
        let strips = Strips::new(h, rows_that_fit(w, depths.grid()));
        let mut out = Residuals { size: photo.size(), rgb: vec![0; depths.grid().count() * 3 * w * h] };
        for (done, strip) in strips.iter().enumerate() {
            job.advance(Stage::Occlusion, done as u32, strips.count() as u32)?;
            let input = strip_input(photo, depths, strip.first, strips.rows);
            let shape = [1, 4, depths.grid().count(), strips.rows, w];
            let residual = self.net.run(&shape, &input, threads, job.cancel)?;
            out.keep(&residual, strips.rows, &strip);
        }
        job.advance(Stage::Occlusion, strips.count() as u32, strips.count() as u32)?;
        Ok(out)
    }
}

/// Residuals of a net that takes its input row by row.
fn row_by_row(chain: &VolumeChain, photo: &Signed, depths: &RayDepths, job: &Job) -> Result<Residuals, Cancelled> {
    let ([w, h], grid) = (photo.sides(), depths.grid());
    let mut out = Residuals { size: photo.size(), rgb: vec![0; grid.count() * 3 * w * h] };
    let fill = |at: Columns, rows: &mut [f32], step: usize| {
        let view = grid.view_from_layer(at.view);
        let disparity_px = &depths.view(view)[at.y * w..][at.x.clone()];
        fill_row(photo, disparity_px, [at.x.start, at.y], grid.offset(view), rows, step);
    };
    let (mut done, total) = (0, (w * h) as u32);
    let take = |rows: Rows| {
        job.sink.progress(Progress { stage: Stage::Occlusion, done, total });
        done += (rows.x.len() * rows.y.len()) as u32;
        out.keep_rows(&rows);
    };
    job.advance(Stage::Occlusion, 0, total)?;
    chain.run([grid.count(), h, w], fill, take, Some(job.cancel.flag()))?;
    job.advance(Stage::Occlusion, total, total)?;
    Ok(out)
}

/// Rows of a strip whose widest activation takes [`STRIP_BYTES`].
fn rows_that_fit(width: usize, grid: ViewGrid) -> usize {
    let row = WIDEST * grid.count() * width * size_of::<f32>();
    (STRIP_BYTES / row).max(4 * HALO)
}

/// Strips of one height that cover a picture: one shape, so one net that stays warm.
struct Strips {
    height: usize,
    rows: usize,
}

/// The net sees rows `first ..`; of its answer `keep` counts (in rows of the picture).
struct Strip {
    first: usize,
    keep: std::ops::Range<usize>,
}

impl Strips {
    fn new(height: usize, rows: usize) -> Self {
        Self { height, rows: rows.min(height) }
    }

    fn step(&self) -> usize {
        self.rows - 2 * HALO
    }

    fn count(&self) -> usize {
        if self.rows == self.height { 1 } else { (self.height - 2 * HALO).div_ceil(self.step()) }
    }

    fn iter(&self) -> impl Iterator<Item = Strip> {
        let last = self.count() - 1;
        (0..=last).map(move |i| {
            let first = if i == last { self.height - self.rows } else { i * self.step() };
            let from = if i == 0 { 0 } else { i * self.step() + HALO };
            let to = if i == last { self.height } else { (i + 1) * self.step() + HALO };
            Strip { first, keep: from..to }
        })
    }
}

/// The net's input for rows `first .. first + rows`: Lambertian colours and disparity, `[c, v, u, y, x]`.
fn strip_input(photo: &Signed, depths: &RayDepths, first: usize, rows: usize) -> Vec<f32> {
    let ([w, _], grid) = (photo.sides(), depths.grid());
    let plane = rows * w;
    let mut input = vec![0.0; 4 * grid.count() * plane];
    let (red, rest) = input.split_at_mut(grid.count() * plane);
    let (green, rest) = rest.split_at_mut(grid.count() * plane);
    let (blue, disparity) = rest.split_at_mut(grid.count() * plane);
    let planes = red.par_chunks_exact_mut(w).zip(green.par_chunks_exact_mut(w)).zip(blue.par_chunks_exact_mut(w));
    planes.zip(disparity.par_chunks_exact_mut(w)).enumerate().for_each(|(row, (((r, g), b), d))| {
        let (view, y) = (grid.view_from_layer(row / rows), first + row % rows);
        d.copy_from_slice(&depths.view(view)[y * w..(y + 1) * w]);
        render_row(photo, d, [0, y], grid.offset(view), |x, colour| {
            (r[x], g[x], b[x]) = (colour.x, colour.y, colour.z)
        });
    });
    input
}

impl Residuals {
    /// Copies the rows of a strip's answer, `[c, v, u, y, x]`, that count.
    fn keep(&mut self, residual: &[f32], rows: usize, strip: &Strip) {
        let [w, h] = sides(self.size);
        let views = self.rgb.len() / (3 * w * h);
        self.rgb.par_chunks_exact_mut(w * h).enumerate().for_each(|(plane, out)| {
            let (view, c) = (plane / 3, plane % 3);
            let from = &residual[(c * views + view) * rows * w..][..rows * w];
            let inside = (strip.keep.start - strip.first) * w..(strip.keep.end - strip.first) * w;
            let out = &mut out[strip.keep.start * w..strip.keep.end * w];
            out.iter_mut().zip(&from[inside]).for_each(|(o, r)| *o = stored(*r));
        });
    }

    /// Copies finished rows.
    fn keep_rows(&mut self, rows: &Rows) {
        let [w, h] = sides(self.size);
        self.rgb.par_chunks_exact_mut(w * h).enumerate().for_each(|(plane, out)| {
            let (view, c) = (plane / 3, plane % 3);
            for y in rows.y.clone() {
                let out = &mut out[y * w..][rows.x.clone()];
                out.iter_mut().zip(rows.row(view, c, y)).for_each(|(o, r)| *o = stored(*r));
            }
        });
    }

    /// The residual of one view at its `i`-th pixel.
    #[inline]
    fn at(&self, layer: usize, i: usize) -> Vec4 {
        let plane = pixels(self.size);
        let channel = |c: usize| f32::from(self.rgb[(layer * 3 + c) * plane + i]) / UNIT;
        Vec4::new(channel(0), channel(1), channel(2), 0.0)
    }

    /// The corrected view: Lambertian colour plus residual, the residual brought to the photo's size; where rays end
    /// behind what the photo sees, the far side.
    pub(super) fn correct(
        &self,
        photo: &Signed,
        far: &FarSide,
        depths: &RayDepths,
        layer: usize,
    ) -> Result<View, SynthError> {
        let [w, h] = photo.sides();
        let at = depths.grid().view_from_layer(layer);
        let (rx, ry) = (self.size[0] as f32 / w as f32, self.size[1] as f32 / h as f32);
        let mut rgba = vec![255; w * h * 4];
        for (y, (row, d)) in rgba.chunks_exact_mut(w * 4).zip(depths.view(at).chunks_exact(w)).enumerate() {
            let sy = center_at(y, ry);
            let from = depths.grid().offset(at);
            render_row(photo, d, [0, y], from, |x, colour| {
                let residual = match self.size == photo.size() {
                    true => self.at(layer, y * w + x),
                    false => bilinear(sides(self.size), center_at(x, rx), sy, |i| self.at(layer, i)),
                };
                let colour = far.colour(colour + residual, [x, y], from, d[x]);
                row[x * 4..x * 4 + 3].copy_from_slice(&encode(colour));
            });
        }
        Ok(View::new(depths.size(), rgba)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_cover_every_row_once_and_keep_their_halo() {
        for (height, rows) in
            [(405, 64), (64, 64), (40, 64), (65, 64), (74, 64), (118, 64), (119, 64), (1, 64), (1000, 20)]
        {
            let strips = Strips::new(height, rows);
            let mut next = 0;
            for strip in strips.iter() {
                assert_eq!(strip.keep.start, next);
                assert!(strip.keep.start == 0 || strip.keep.start >= strip.first + HALO);
                assert!(strip.keep.end == height || strip.keep.end + HALO <= strip.first + strips.rows);
                assert!(strip.first + strips.rows <= height);
                next = strip.keep.end;
            }
            assert_eq!(next, height, "{height} rows in strips of {rows}");
        }
    }
}
