//! Both nets and the warp between them at one exact size, as the pipeline runs them. Without an occlusion net its stage
//! takes no time.

use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec4;
use rayon::prelude::*;

use super::{BenchError, Options, Seconds, timed};
use crate::field::{ViewGrid, size_from};
use crate::job::{Cancelled, Job};
use crate::kernel::winograd::{Columns, VolumeChain};
use crate::synth::lambertian::{fill_row, render_row};
use crate::synth::tract::{self, Output, Runnable, Wiring, pool, prepare_file};
use crate::synth::{ModelFile, ModelSource, Signed, Task};

/// Rows that the occlusion net sees beyond a strip.
const HALO: usize = 5;
/// Memory of the widest activation of a strip (8 channels), as the pipeline has it.
const STRIP_BYTES: usize = 96 << 20;

/// Nets made ready for a size.
#[cfg_attr(not(feature = "onnxruntime"), allow(dead_code, reason = "only the other engine reads the files again"))]
pub(super) struct Nets {
    pub(super) depth_file: ModelFile,
    pub(super) occlusion_file: Option<ModelFile>,
    grid: ViewGrid,
    size: [usize; 2],
    photo: Signed,
    depth: Runnable,
    occlusion: Option<Runnable>,
    strip_rows: usize,
    threads: usize,
}

impl Nets {
    pub(super) fn new(models: &ModelSource, options: &Options, size: [usize; 2]) -> Result<Self, BenchError> {
        let index = models.index()?;
        let depth_file = models.model(&index.depth, Task::RayDepth)?;
        let occlusion_file = index.occlusion.map(|id| models.model(&id, Task::Occlusion)).transpose()?;
        let grid = depth_file.manifest.grid()?;
        let size @ [width, height] = size.map(|side| side.max(1));
        let engine = options.engine();
        let multiple = depth_file.manifest.multiple_of as usize;
        let padded = [height, width].map(|side| side.next_multiple_of(multiple));
        let shape = [1, depth_file.manifest.input_channels(), padded[0], padded[1]];
        let depth = prepare_file(&depth_file.onnx(&Wiring::FIRST), &shape, &engine)?;
        let ready = |rows: usize| {
            let shape = [1, 4, grid.count(), rows, width];
            let file = occlusion_file.as_ref();
            file.map(|file| prepare_file(&file.onnx(&Wiring::FIRST), &shape, &engine)).transpose()
        };
        let fitting = STRIP_BYTES / (8 * grid.count() * width * size_of::<f32>());
        let (mut occlusion, mut strip_rows) = (ready(height)?, height);
        if occlusion.as_ref().is_some_and(|net| net.volume_chain().is_none()) {
            strip_rows = fitting.max(4 * HALO).min(height);
            occlusion = ready(strip_rows)?;
        }
        let photo = picture(size);
        let threads = options.threads;
        Ok(Self { depth_file, occlusion_file, grid, size, photo, depth, occlusion, strip_rows, threads })
    }

    pub(super) fn views(&self) -> [usize; 2] {
        [self.grid.rows(), self.grid.cols()]
    }

    /// Useful operations of the depth net.
    pub(super) fn depth_flop(&self) -> f64 {
        self.depth.flop()
    }

    /// Useful operations of both nets over the whole picture; the halo of the strips does not count.
    pub(super) fn flop(&self) -> f64 {
        let strip = self.occlusion.as_ref().map_or(0.0, Runnable::flop);
        self.depth_flop() + strip * self.size[1] as f64 / self.strip_rows as f64
    }

    /// The input shape of the depth net, and of the occlusion net over the whole picture.
    #[cfg_attr(not(feature = "onnxruntime"), allow(dead_code, reason = "only the other engine asks"))]
    pub(super) fn shapes(&self) -> [Vec<usize>; 2] {
        let [width, height] = self.size;
        [self.depth.input_shape().to_vec(), vec![1, 4, self.grid.count(), height, width]]
    }

    /// One pass, timed by stages.
    pub(super) fn run(&self, job: &Job) -> Result<Seconds, BenchError> {
        let input = numbers(self.depth.input_shape().iter().product());
        let (depth, maps) = timed(|| self.depth.run(&input, job.cancel));
        let maps = maps?;
        let mut seconds = Seconds { depth, ..Seconds::default() };
        let pool = pool(self.threads)?;
        if let Some(chain) = self.occlusion.as_ref().and_then(Runnable::volume_chain) {
            pool.install(|| self.stream(chain, &maps, &mut seconds, job))?;
        } else {
            self.run_strips(&pool, &maps, &mut seconds, job)?;
        }
        seconds.total = seconds.depth + seconds.warp + seconds.occlusion;
        Ok(seconds)
    }

    /// The warp straight into an occlusion net that goes down the picture row by row. The warp's seconds are those of
    /// all threads by their number.
    fn stream(&self, chain: &VolumeChain, maps: &Output, seconds: &mut Seconds, job: &Job) -> Result<(), Cancelled> {
        let [width, height] = self.size;
        let nanos = AtomicU64::new(0);
        let fill = |at: Columns, rows: &mut [f32], step: usize| {
            let (took, ()) = timed(|| {
                let from = self.grid.offset(self.grid.view_from_layer(at.view));
                let disparity_px = &map_row(maps, at.view, at.y)[at.x.clone()];
                fill_row(&self.photo, disparity_px, [at.x.start, at.y], from, rows, step);
            });
            nanos.fetch_add((took * 1e9) as u64, Ordering::Relaxed);
        };
        let size = [self.grid.count(), height, width];
        let (took, done) = timed(|| {
            chain.run(size, fill, |rows| _ = black_box(rows.row(0, 0, rows.y.start)[0]), Some(job.cancel.flag()))
        });
        seconds.warp = nanos.into_inner() as f64 / 1e9 / rayon::current_num_threads() as f64;
        seconds.occlusion = took - seconds.warp;
        done
    }

    fn run_strips(
        &self,
        pool: &tract::Pool,
        maps: &Output,
        seconds: &mut Seconds,
        job: &Job,
    ) -> Result<(), BenchError> {
        for first in self.strips() {
            job.check()?;
            let (warp, input) = timed(|| pool.install(|| self.warp(maps, first)));
            seconds.warp += warp;
            let Some(net) = &self.occlusion else { continue };
            let (occlusion, answer) = timed(|| net.run(&input, job.cancel));
            answer?;
            seconds.occlusion += occlusion;
        }
        Ok(())
    }

    /// First rows of the strips.
    fn strips(&self) -> impl Iterator<Item = usize> + use<> {
        let (height, rows) = (self.size[1], self.strip_rows);
        let count = if rows == height { 1 } else { (height - 2 * HALO).div_ceil(rows - 2 * HALO) };
        (0..count).map(move |strip| (strip * (rows - 2 * HALO)).min(height - rows))
    }

    /// The occlusion net's input of one strip, `[c, v, u, y, x]`.
    fn warp(&self, maps: &Output, first: usize) -> Vec<f32> {
        let ([width, _], rows) = (self.size, self.strip_rows);
        let mut input = vec![0.0; 4 * self.grid.count() * rows * width];
        let (colour, disparity) = input.split_at_mut(3 * self.grid.count() * rows * width);
        let (red, rest) = colour.split_at_mut(self.grid.count() * rows * width);
        let (green, blue) = rest.split_at_mut(self.grid.count() * rows * width);
        let planes = red.par_chunks_exact_mut(width).zip(green.par_chunks_exact_mut(width));
        let planes = planes.zip(blue.par_chunks_exact_mut(width)).zip(disparity.par_chunks_exact_mut(width));
        planes.enumerate().for_each(|(row, (((r, g), b), d))| {
            let (view, y) = (row / rows, first + row % rows);
            d.copy_from_slice(&map_row(maps, view, y)[..width]);
            let from = self.grid.offset(self.grid.view_from_layer(view));
            render_row(&self.photo, d, [0, y], from, |x, colour| (r[x], g[x], b[x]) = (colour.x, colour.y, colour.z));
        });
        input
    }
}

/// One row of one view's map, `[1, v, y, x]`.
fn map_row(maps: &Output, view: usize, y: usize) -> &[f32] {
    let [.., rows, columns] = *maps.shape() else { return &[] };
    &maps[(view * rows + y) * columns..][..columns]
}

/// A picture with something in it everywhere.
fn picture(size: [usize; 2]) -> Signed {
    let numbers = numbers(3 * size[0] * size[1]);
    Signed::from_fn(size_from(size), |x, y| {
        let [r, g, b] = [0, 1, 2].map(|c| numbers[3 * (y * size[0] + x) + c]);
        Vec4::new(r, g, b, 0.0)
    })
}

/// Repeatable numbers in −1 … 1.
pub(super) fn numbers(n: usize) -> Vec<f32> {
    (0..n).map(|i| ((i as u32).wrapping_mul(2_654_435_769) >> 8) as f32 / (1u32 << 23) as f32 - 1.0).collect()
}
