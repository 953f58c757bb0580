//! A light field on the device: one layer a view, uploaded a little each frame.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Gpu;
use crate::field::{LightField, RayDepths, View, ViewGrid, ViewIndex};

/// How much may be uploaded in one frame; at least one layer goes in any case.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Bytes.
    pub bytes: usize,
    /// Time on the thread that uploads.
    pub time: Duration,
}

impl Default for Budget {
    fn default() -> Self {
        Self { bytes: 4 << 20, time: Duration::from_millis(3) }
    }
}

impl Budget {
    /// Everything at once, for tests.
    pub const ALL: Self = Self { bytes: usize::MAX, time: Duration::MAX };
}

impl Budget {
    /// A share of a frame that took so long: where frames are slow anyway, waiting for layers is what is felt.
    pub fn of_frame(frame: Duration) -> Self {
        let usual = Self::default();
        let time = usual.time.max(frame / 4);
        let growth = time.as_secs_f32() / usual.time.as_secs_f32();
        Self { bytes: (usual.bytes as f32 * growth) as usize, time }
    }
}

#[derive(Debug)]
enum Layer {
    View(ViewIndex, Arc<View>),
    Depth(ViewIndex, Arc<RayDepths>),
}

impl Layer {
    fn is_same_place(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::View(a, _), Self::View(b, _)) | (Self::Depth(a, _), Self::Depth(b, _)) => a == b,
            _ => false,
        }
    }
}

/// Views (sRGB) and ray depths as texture layers, `layer = v · cols + u`, split in two where there are more layers than
/// the adapter takes.
#[derive(Debug)]
pub struct FieldTexture {
    grid: ViewGrid,
    size: [u32; 2],
    split: u32,
    views: [wgpu::Texture; 2],
    depths: [wgpu::Texture; 2],
    views_arrived: Vec<bool>,
    depths_arrived: Vec<bool>,
    /// What is seen at once: views, and the ray depths of the reference view.
    waiting: VecDeque<Layer>,
    /// What can wait: the other ray depths.
    later: VecDeque<Layer>,
    changes: u64,
}

impl FieldTexture {
    /// Room for a light field; `None` where its views are larger than the adapter's textures.
    pub fn new(gpu: &Gpu, grid: ViewGrid, size: [u32; 2]) -> Option<Self> {
        let limits = gpu.device.limits();
        if size[0].max(size[1]) > limits.max_texture_dimension_2d {
            return None;
        }
        let layers = grid.count() as u32;
        let split = layers.min(limits.max_texture_array_layers);
        let pair = |format, view_format| {
            [split, (layers - split).max(1)].map(|layers| texture(gpu, size, layers, format, view_format))
        };
        Some(Self {
            views: pair(wgpu::TextureFormat::Rgba8UnormSrgb, Some(wgpu::TextureFormat::Rgba8Unorm)),
            depths: pair(wgpu::TextureFormat::R32Float, None),
            views_arrived: vec![false; grid.count()],
            depths_arrived: vec![false; grid.count()],
            waiting: VecDeque::new(),
            later: VecDeque::new(),
            changes: 0,
            grid,
            size,
            split,
        })
    }

    /// A whole light field with its ray depths, uploaded at once (for tests and tools).
    pub fn whole(gpu: &Gpu, field: &LightField, depths: Option<&Arc<RayDepths>>) -> Option<Self> {
        let mut texture = Self::new(gpu, field.grid(), field.size())?;
        texture.push_field(field);
        if let Some(depths) = depths {
            texture.push_depths(depths);
        }
        texture.upload_some(gpu, Budget::ALL);
        Some(texture)
    }

    /// Rows and columns of views.
    pub fn grid(&self) -> ViewGrid {
        self.grid
    }

    /// Width and height of a view.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Queues one view; a view that comes again replaces the older one, in its place of the queue if it still waits.
    pub fn push_view(&mut self, at: ViewIndex, view: &Arc<View>) {
        if view.size() == self.size {
            queue(&mut self.waiting, Layer::View(at, Arc::clone(view)));
        }
    }

    /// Queues all views, from the middle outward.
    pub fn push_field(&mut self, field: &LightField) {
        for at in field.grid().spiral() {
            self.push_view(at, field.view(at));
        }
    }

    /// Queues all ray depths, from the middle outward; those of the reference view go first, the others after the views.
    pub fn push_depths(&mut self, depths: &Arc<RayDepths>) {
        if depths.size() != self.size || depths.grid() != self.grid {
            return;
        }
        self.later.clear();
        for at in self.grid.spiral() {
            let layer = Layer::Depth(at, Arc::clone(depths));
            if at == self.grid.reference() {
                self.waiting.retain(|waiting| !waiting.is_same_place(&layer));
                self.waiting.push_front(layer);
            } else {
                self.later.push_back(layer);
            }
        }
    }

    /// Uploads what the budget allows; true while more is waiting.
    pub fn upload_some(&mut self, gpu: &Gpu, budget: Budget) -> bool {
        let start = Instant::now();
        let mut bytes = 0;
        while let Some(layer) = self.waiting.pop_front().or_else(|| self.later.pop_front()) {
            bytes += self.upload(gpu, &layer);
            self.changes += 1;
            if bytes >= budget.bytes || start.elapsed() >= budget.time {
                break;
            }
        }
        self.is_waiting()
    }

    /// Whether layers wait to be uploaded.
    pub fn is_waiting(&self) -> bool {
        !self.waiting.is_empty() || !self.later.is_empty()
    }

    fn upload(&mut self, gpu: &Gpu, layer: &Layer) -> usize {
        match layer {
            Layer::View(at, view) => {
                let index = self.grid.layer_from_view(*at);
                self.write(gpu, &self.views, index, view.rgba());
                self.views_arrived[index] = true;
                view.rgba().len()
            }
            Layer::Depth(at, depths) => {
                let index = self.grid.layer_from_view(*at);
                let bytes = bytemuck::cast_slice(depths.view(*at));
                self.write(gpu, &self.depths, index, bytes);
                self.depths_arrived[index] = true;
                bytes.len()
            }
        }
    }

    fn write(&self, gpu: &Gpu, halves: &[wgpu::Texture; 2], layer: usize, bytes: &[u8]) {
        let (half, z) = if (layer as u32) < self.split { (0, layer as u32) } else { (1, layer as u32 - self.split) };
        let [width, height] = self.size;
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &halves[half],
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: 0, z },
                aspect: wgpu::TextureAspect::All,
            },
            bytes,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: Some(height) },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }

    /// Whether a view's pixels are there.
    pub fn has_view(&self, at: ViewIndex) -> bool {
        self.views_arrived[self.grid.layer_from_view(at)]
    }

    /// Whether a view's ray depths are there.
    pub fn has_depth(&self, at: ViewIndex) -> bool {
        self.depths_arrived[self.grid.layer_from_view(at)]
    }

    /// Views that are there.
    pub fn views_arrived(&self) -> usize {
        self.views_arrived.iter().filter(|&&arrived| arrived).count()
    }

    /// Grows with each layer that arrives: part of the key of every picture.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// One view as egui draws textures: encoded values, one layer.
    pub fn encoded_view(&self, at: ViewIndex) -> wgpu::TextureView {
        let layer = self.grid.layer_from_view(at) as u32;
        let (half, base) = if layer < self.split { (0, layer) } else { (1, layer - self.split) };
        self.views[half].create_view(&wgpu::TextureViewDescriptor {
            format: Some(wgpu::TextureFormat::Rgba8Unorm),
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: base,
            array_layer_count: Some(1),
            ..Default::default()
        })
    }

    /// The four array views in the order of the bindings.
    pub(super) fn array_views(&self) -> [wgpu::TextureView; 4] {
        let array = |texture: &wgpu::Texture| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            })
        };
        [&self.views[0], &self.views[1], &self.depths[0], &self.depths[1]].map(array)
    }
}

/// Puts a layer behind those that wait, or in the place of its older self.
fn queue(waiting: &mut VecDeque<Layer>, layer: Layer) {
    match waiting.iter_mut().find(|waiting| waiting.is_same_place(&layer)) {
        Some(older) => *older = layer,
        None => waiting.push_back(layer),
    }
}

fn texture(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    layers: u32,
    format: wgpu::TextureFormat,
    view_format: Option<wgpu::TextureFormat>,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("light field"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: view_format.as_slice(),
    })
}
