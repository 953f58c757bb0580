//! The lens renderer on a device, for looking: the same picture as [`Prepared::render`] makes, to 2/255.
//!
//! What does not depend on the lens is found out on the CPU once (what each pixel sees, and what is behind it) and kept
//! on the device; turning the lens costs the device's time only.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use wgpu::util::DeviceExt;

use super::kernel::{Kernels, index_of};
use super::rays::slice_of;
use super::tile::Optics;
use super::{LensError, Prepared, Region};
use crate::field::{Lens, LensShape};
use crate::job::Job;
use crate::render::Picture;

/// The passes of a device, with the surroundings of the last region.
pub struct LensGpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pieces: wgpu::ComputePipeline,
    spread: wgpu::ComputePipeline,
    cover: wgpu::ComputePipeline,
    kept: Option<Kept>,
}

/// What does not depend on the lens.
struct Kept {
    prepared: Arc<Prepared>,
    region: Region,
    /// Pixels around the region.
    margin: u32,
    buffers: [wgpu::Buffer; 5],
}

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Params {
    gather_size: [u32; 2],
    gather_at: [i32; 2],
    size: [u32; 2],
    inset: [i32; 2],
    picture_size: [u32; 2],
    gain: f32,
    highlights: f32,
    focus: [f32; 4],
    keep_sharp: [f32; 2],
    padding: [f32; 2],
}

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Span {
    dy: i32,
    begin: i32,
    end: i32,
    padding: i32,
    begin_parts: [f32; 2],
    end_parts: [f32; 2],
}

/// Slices lie this far apart in their buffer, as devices ask for.
const SLICE_BYTES: usize = 256;
/// Margins grow in these steps, so that turning the lens a little keeps the surroundings.
const MARGIN: u32 = 64;

impl LensGpu {
    /// Builds the passes.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("lens.wgsl"));
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let [pieces, spread, cover] = ["pieces", "spread", "cover"].map(pipeline);
        Self { device: device.clone(), queue: queue.clone(), pieces, spread, cover, kept: None }
    }

    /// Renders a region; none where the device cannot: for a lens that changes over the picture (the cat's eye), added
    /// grain, or more pixels than it takes at once. Then [`Prepared::render`] does it.
    ///
    /// Waits for the device, so it is not for the window's thread.
    pub fn render(
        &mut self,
        prepared: &Arc<Prepared>,
        lens: &Lens,
        region: Region,
        job: &Job,
    ) -> Result<Option<Picture>, LensError> {
        let optics = prepared.optics(lens);
        if optics.gain == 0.0
            || lens.grain > 0.0
            || !lens.glass.is_plain()
            || matches!(lens.shape, LensShape::CatEye { .. })
        {
            return Ok(None);
        }
        let margin = (optics.reach as u32).next_multiple_of(MARGIN);
        if !self.takes(region, margin) {
            return Ok(None);
        }
        if !self.kept.as_ref().is_some_and(|kept| kept.serves(prepared, region, margin)) {
            self.kept = None;
            self.kept = Some(self.keep(prepared, region, margin));
        }
        job.check()?;
        let Some(kept) = &self.kept else { return Ok(None) };
        let front = self.run(kept, &optics);
        job.check()?;
        Ok(self.read(&front).map(|front| picture(region, &front)))
    }

    /// Whether the buffers are small enough for the device.
    fn takes(&self, region: Region, margin: u32) -> bool {
        let limits = self.device.limits();
        let [width, height] = region.size.map(|side| u64::from(side + 2 * margin));
        let groups = limits.max_compute_workgroups_per_dimension;
        2 * 16 * width * height <= limits.max_storage_buffer_binding_size && region.size[1] <= groups
    }

    /// Finds out what every pixel of a region and around it sees, and brings it to the device.
    fn keep(&self, prepared: &Arc<Prepared>, region: Region, margin: u32) -> Kept {
        let gathered = gathered(prepared, region, margin);
        let column = |part: fn(&Gathered) -> [f32; 4]| -> wgpu::Buffer {
            let values: Vec<[f32; 4]> = gathered.iter().map(part).collect();
            self.storage(bytemuck::cast_slice(&values))
        };
        let parts: [fn(&Gathered) -> [f32; 4]; 5] = [|g| g.color, |g| g.sides, |g| g.hidden, |g| g.near, |g| g.far];
        let buffers = parts.map(column);
        Kept { prepared: Arc::clone(prepared), region, margin, buffers }
    }

    /// Puts all passes into the queue; returns light and what is left to cover, `[y, x]` of four.
    fn run(&self, kept: &Kept, optics: &Optics) -> wgpu::Buffer {
        let Region { size: [width, height], .. } = kept.region;
        let gather = kept.region.size.map(|side| side + 2 * kept.margin);
        let count = u64::from(gather[0]) * u64::from(gather[1]);
        let params = kept.params(optics);
        let params = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("lens"),
            contents: bytemuck::bytes_of(&params),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let (kernels, spans) = kernel_table(&optics.kernels, kept.widest(optics));
        let [kernels, spans] = [bytemuck::cast_slice(&kernels), bytemuck::cast_slice(&spans)].map(|b| self.storage(b));
        let [lights, blurs, seen] = [32 * count, 8 * count, 8 * count].map(|bytes| self.empty(bytes));
        let pixels = u64::from(width) * u64::from(height);
        let steps = self.empty(16 * u64::from(width + 2) * u64::from(height));
        let still = self.empty(16 * pixels);
        let front = self.storage(bytemuck::cast_slice(&vec![[0.0f32, 0.0, 0.0, 1.0]; pixels as usize]));
        let open = self.storage(bytemuck::cast_slice(&vec![1.0f32; pixels as usize]));
        let [colors, sides, hidden, nears, fars] = &kept.buffers;
        let bind = |pipeline: &wgpu::ComputePipeline, buffers: &[(u32, &wgpu::Buffer)]| self.bind(pipeline, buffers);
        let own = [(0, &params), (5, &lights), (6, &blurs)];
        let gathered = [(1, colors), (2, sides), (3, hidden), (4, nears), (14, fars)];
        let pieces = bind(&self.pieces, &[&own[..], &gathered[..], &[(13, &seen)]].concat());
        let spread = bind(&self.spread, &[&own[..], &[(7, &kernels), (8, &spans), (9, &steps), (10, &still)]].concat());
        let cover =
            bind(&self.cover, &[(0, &params), (9, &steps), (10, &still), (11, &front), (12, &open), (13, &seen)]);
        let slices = self.slices(kept.slices(optics));
        let groups = gather.map(|side| side.div_ceil(8));
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pieces);
            pass.set_bind_group(0, &pieces, &[]);
            pass.dispatch_workgroups(groups[0], groups[1], 1);
            for [to_spread, to_cover] in &slices {
                pass.set_pipeline(&self.spread);
                pass.set_bind_group(0, &spread, &[]);
                pass.set_bind_group(1, to_spread, &[]);
                pass.dispatch_workgroups(groups[0], groups[1], 1);
                pass.set_pipeline(&self.cover);
                pass.set_bind_group(0, &cover, &[]);
                pass.set_bind_group(1, to_cover, &[]);
                pass.dispatch_workgroups(height, 1, 1);
            }
        }
        self.queue.submit([encoder.finish()]);
        front
    }

    /// Groups of bindings for every slice, to spread it and to put it behind; from the near side to the far one.
    fn slices(&self, [far, near]: [i32; 2]) -> Vec<[wgpu::BindGroup; 2]> {
        let numbers: Vec<i32> = (far..=near).rev().collect();
        let mut bytes = vec![0u8; SLICE_BYTES * numbers.len()];
        for (slot, number) in bytes.chunks_exact_mut(SLICE_BYTES).zip(&numbers) {
            slot[..4].copy_from_slice(&number.to_le_bytes());
        }
        let buffer = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("slices"),
            contents: &bytes,
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let layouts = [&self.spread, &self.cover].map(|pipeline| pipeline.get_bind_group_layout(1));
        let group = |i: usize, layout: &wgpu::BindGroupLayout| {
            let offset = (i * SLICE_BYTES) as u64;
            let binding = wgpu::BufferBinding { buffer: &buffer, offset, size: std::num::NonZeroU64::new(16) };
            let entry = wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::Buffer(binding) };
            self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("slice"),
                layout,
                entries: &[entry],
            })
        };
        (0..numbers.len()).map(|i| layouts.each_ref().map(|layout| group(i, layout))).collect()
    }

    fn bind(&self, pipeline: &wgpu::ComputePipeline, buffers: &[(u32, &wgpu::Buffer)]) -> wgpu::BindGroup {
        let entry = |&(binding, buffer)| {
            let buffer: &wgpu::Buffer = buffer;
            wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
        };
        let entries: Vec<_> = buffers.iter().map(entry).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("lens"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        })
    }

    fn storage(&self, contents: &[u8]) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("lens"),
            contents,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        })
    }

    /// A buffer of zeros.
    fn empty(&self, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("lens"),
            size,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        })
    }

    fn read(&self, buffer: &wgpu::Buffer) -> Option<Vec<[f32; 4]>> {
        let copy = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        copy.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        // A device that is lost gives no picture; the CPU makes it then.
        self.device.poll(wgpu::PollType::wait_indefinitely()).ok()?;
        let bytes = copy.slice(..).get_mapped_range().ok()?;
        Some(bytemuck::pod_collect_to_vec(&bytes))
    }
}

/// Light over coverage.
fn picture(region: Region, front: &[[f32; 4]]) -> Picture {
    let over = |&[r, g, b, left]: &[f32; 4]| {
        let covered = 1.0 - left;
        let share = if covered > 0.0 { 1.0 / covered } else { 0.0 };
        [r * share, g * share, b * share]
    };
    Picture { size: region.size, rgb_linear: front.iter().flat_map(over).collect() }
}

impl Kept {
    fn serves(&self, prepared: &Arc<Prepared>, region: Region, margin: u32) -> bool {
        Arc::ptr_eq(&self.prepared, prepared) && self.region == region && self.margin == margin
    }

    fn params(&self, optics: &Optics) -> Params {
        let Lens { focus, keep_sharp_px: [low, high], highlights, .. } = *optics.lens;
        Params {
            gather_size: self.region.size.map(|side| side + 2 * self.margin),
            gather_at: self.region.at.map(|at| at as i32 - self.margin as i32),
            size: self.region.size,
            inset: [self.margin as i32; 2],
            picture_size: self.prepared.size,
            gain: optics.gain,
            highlights,
            focus: [focus.disparity_px, focus.tilt_px[0], focus.tilt_px[1], 0.0],
            keep_sharp: [low.min(0.0), high.max(0.0)],
            padding: [0.0; 2],
        }
    }

    /// Least and greatest blur of anything in the picture, pixels.
    fn blurs(&self, optics: &Optics) -> [f32; 2] {
        let [width, height] = self.prepared.size.map(|side| side as i32);
        let corners = [[0, 0], [width, 0], [0, height], [width, height]];
        let disparities = self.prepared.surfaces.range_px();
        let blurs = disparities.into_iter().flat_map(|d| corners.map(|[x, y]| optics.blur(d, x, y)));
        blurs.fold([f32::MAX, f32::MIN], |[low, high], b| [low.min(b), high.max(b)])
    }

    fn widest(&self, optics: &Optics) -> f32 {
        let [low, high] = self.blurs(optics);
        low.abs().max(high.abs())
    }

    /// The slices that anything can be in, far and near.
    fn slices(&self, optics: &Optics) -> [i32; 2] {
        let [low, high] = self.blurs(optics);
        [slice_of(low).floor() as i32 - 1, slice_of(high).ceil() as i32 + 1]
    }
}

/// What one pixel sees, as in the shader.
#[derive(Clone, Copy)]
struct Gathered {
    color: [f32; 4],
    sides: [f32; 4],
    hidden: [f32; 4],
    near: [f32; 4],
    far: [f32; 4],
}

fn gathered(prepared: &Prepared, region: Region, margin: u32) -> Vec<Gathered> {
    let [x0, y0] = region.at.map(|at| at as i32 - margin as i32);
    let [width, height] = region.size.map(|side| (side + 2 * margin) as usize);
    let reader = prepared.reader(x0, width);
    let row = |y: usize| {
        let y = y0 + y as i32;
        let mut colors = vec![[0.0; 3]; width];
        prepared.light.row(x0, y, &mut colors);
        let row = reader.at_row(y);
        let pixel = |(i, [r, g, b]): (usize, [f32; 3])| {
            let (seen, hidden) = reader.at(&row, i, &[r, g, b]);
            let [hr, hg, hb] = hidden.map_or([0.0; 3], |h| h.rgb);
            let [[nr, ng, nb], [fr, fg, fb]] = [seen.near_rgb, seen.far_rgb];
            Gathered {
                color: [r, g, b, seen.near_px],
                sides: [seen.far_px, seen.cover, seen.edge, hidden.map_or(0.0, |h| h.share)],
                hidden: [hr, hg, hb, hidden.map_or(0.0, |h| h.disparity_px)],
                near: [nr, ng, nb, hidden.map_or(0.0, |h| h.distance_px)],
                far: [fr, fg, fb, seen.stained],
            }
        };
        colors.into_iter().enumerate().map(pixel).collect::<Vec<_>>()
    };
    (0..height).into_par_iter().flat_map_iter(row).collect()
}

/// All kernels up to a diameter: where each one's spans are, upright and flipped, and the spans.
fn kernel_table(kernels: &Kernels, widest: f32) -> (Vec<[u32; 2]>, Vec<Span>) {
    let (mut table, mut spans) = (Vec::new(), Vec::new());
    for index in 0..=index_of(widest) + 1 {
        for flipped in [false, true] {
            let kernel = kernels.get(index, flipped, 0, 0);
            table.push([spans.len() as u32, kernel.spans.len() as u32]);
            spans.extend(kernel.spans.iter().map(|span| Span {
                dy: span.dy,
                begin: span.begin.0,
                end: span.end.0,
                padding: 0,
                begin_parts: span.begin.1,
                end_parts: span.end.1,
            }));
        }
    }
    (table, spans)
}
