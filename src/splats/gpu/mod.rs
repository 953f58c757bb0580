//! The splats' pictures on a device: the same as the processor's, to a thousandth.
//!
//! Which ellipses a tile shows is found out on the processor, which sorts well; the device puts them together.

use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;

use super::project::{Ellipse, LEAST};
use super::raster::{DONE, MOST_OPAQUE, Painter, Shown};
use super::tiles::{TILE, Tiles};
use crate::job::{Cancelled, Job};

/// The pass of a device.
pub struct SplatGpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    blend: wgpu::ComputePipeline,
}

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Params {
    size: [u32; 2],
    across: u32,
    most_opaque: f32,
    done: f32,
    least: f32,
    padding: [f32; 2],
}

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Packed {
    at: [f32; 2],
    opacity: f32,
    most: f32,
    shape: [f32; 3],
    nearness: f32,
    color: [f32; 4],
}

impl From<&Ellipse> for Packed {
    fn from(ellipse: &Ellipse) -> Self {
        let Ellipse { at, shape, most, opacity, color: [r, g, b], nearness, .. } = *ellipse;
        Self { at: at.to_array(), opacity, most, shape, nearness, color: [r, g, b, 0.0] }
    }
}

impl SplatGpu {
    /// Builds the pass.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("blend.wgsl"));
        let blend = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("splats"),
            layout: None,
            module: &module,
            entry_point: Some("blend"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { device: device.clone(), queue: queue.clone(), blend }
    }

    /// Whether all of it has room on the device.
    fn takes(&self, tiles: &Tiles) -> bool {
        let most = self.device.limits().max_storage_buffer_binding_size;
        let bytes = [
            tiles.ellipses.len() * size_of::<Packed>(),
            tiles.numbers.len() * size_of::<u32>(),
            crate::field::pixels(tiles.size) * size_of::<[f32; 4]>(),
        ];
        bytes.iter().all(|bytes| *bytes as u64 <= most)
    }

    /// Puts the pass into the queue; light with coverage, and nearness, come one after the other.
    fn run(&self, tiles: &Tiles) -> wgpu::Buffer {
        let (params, padding) = (wgpu::BufferUsages::UNIFORM, [0.0; 2]);
        let Tiles { size, across, .. } = *tiles;
        let across = across as u32;
        let values = Params { size, across, most_opaque: MOST_OPAQUE, done: DONE, least: LEAST, padding };
        let ellipses: Vec<Packed> = tiles.ellipses.iter().map(Packed::from).collect();
        let count = crate::field::pixels(size) as u64;
        let [light, nearness] = [16, 4].map(|bytes| self.empty(bytes * count));
        let buffers = [
            self.filled(bytemuck::bytes_of(&values), params),
            self.stored(bytemuck::cast_slice(&ellipses)),
            self.stored(bytemuck::cast_slice(&tiles.starts)),
            self.stored(bytemuck::cast_slice(&tiles.numbers)),
            light.clone(),
            nearness.clone(),
        ];
        let entry =
            |(at, buffer)| wgpu::BindGroupEntry { binding: at, resource: wgpu::Buffer::as_entire_binding(buffer) };
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("splats"),
            layout: &self.blend.get_bind_group_layout(0),
            entries: &(0..).zip(&buffers).map(entry).collect::<Vec<_>>(),
        });
        let copy = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("splats shown"),
            size: 20 * count,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.blend);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(across, size[1].div_ceil(TILE as u32), 1);
        }
        encoder.copy_buffer_to_buffer(&light, 0, &copy, 0, 16 * count);
        encoder.copy_buffer_to_buffer(&nearness, 0, &copy, 16 * count, 4 * count);
        self.queue.submit([encoder.finish()]);
        copy
    }

    /// A buffer that the device reads; one of nothing holds a zero, as devices refuse empty ones.
    fn stored(&self, contents: &[u8]) -> wgpu::Buffer {
        const NOTHING: [u8; size_of::<Packed>()] = [0; size_of::<Packed>()];
        self.filled(if contents.is_empty() { &NOTHING } else { contents }, wgpu::BufferUsages::STORAGE)
    }

    fn filled(&self, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("splats"), contents, usage })
    }

    fn empty(&self, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("splats"),
            size,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        })
    }

    fn read(&self, copy: &wgpu::Buffer) -> Option<Shown> {
        copy.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        // A device that is lost gives no picture; the processor makes it then.
        self.device.poll(wgpu::PollType::wait_indefinitely()).ok()?;
        let bytes = copy.slice(..).get_mapped_range().ok()?;
        let (light, nearness) = bytes.split_at(bytes.len() / 5 * 4);
        let light: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(light);
        Some(Shown {
            rgb: light.iter().map(|&[r, g, b, _]| [r, g, b]).collect(),
            cover: light.iter().map(|light| light[3]).collect(),
            nearness: bytemuck::pod_collect_to_vec(nearness),
        })
    }
}

impl Painter for SplatGpu {
    /// Waits for the device, so it is not for the window's thread.
    fn paint(&self, tiles: &Tiles, job: &Job) -> Result<Option<Shown>, Cancelled> {
        if !self.takes(tiles) {
            return Ok(None);
        }
        let copy = self.run(tiles);
        job.check()?;
        let shown = self.read(&copy);
        job.check()?;
        Ok(shown)
    }
}
