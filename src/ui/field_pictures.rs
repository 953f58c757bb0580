//! The light field on the device, and the pictures of it that the window shows.

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui_wgpu::RenderState;
use egui::TextureId;

use super::finals::Devices;
use crate::field::{LightField, RayDepths, View, ViewGrid, ViewIndex};
use crate::render::gpu::{Budget, Draw, FieldTexture, Gpu, Target};
use crate::render::lens::LensGpu;
use crate::splats::SplatGpu;

/// Which picture of the light field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The canvas.
    Picture,
    /// The epipolar image under it.
    EpiRow,
    /// The epipolar image beside it.
    EpiColumn,
    /// Ray depths in canvas and inspector.
    Depth,
    /// The right eye's picture in the canvas.
    RightEye,
}

/// A picture that egui can draw.
struct Shown {
    target: Target,
    id: TextureId,
    drawn_at: Instant,
}

/// Where the processor draws, layers that arrive are not worth a picture each.
const STREAM_FRAMES: Duration = Duration::from_millis(500);

/// The light field on the device.
pub struct FieldPictures {
    render: RenderState,
    gpu: Gpu,
    field: Option<FieldTexture>,
    shown: [Option<Shown>; 5],
    views: Vec<TextureId>,
    /// More layers are to come.
    pub is_streaming: bool,
    /// What draws: the adapter's name.
    pub adapter: String,
}

impl FieldPictures {
    /// Builds the passes on egui's device.
    pub fn new(render: &RenderState) -> Self {
        let info = render.adapter.get_info();
        let is_software = info.device_type == wgpu::DeviceType::Cpu;
        let gpu = Gpu::new(&render.device, &render.queue, is_software);
        Self {
            render: render.clone(),
            gpu,
            field: None,
            shown: Default::default(),
            views: Vec::new(),
            is_streaming: false,
            adapter: info.name,
        }
    }

    /// Whether heavy pictures are thinned while something moves.
    pub fn is_software(&self) -> bool {
        self.gpu.is_software()
    }

    /// Pictures at rest on this device; none where the processor draws, which is quicker at them without a detour.
    pub fn at_rest(&self) -> Option<Devices> {
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        let made = || Devices { lens: LensGpu::new(device, queue), splats: SplatGpu::new(device, queue) };
        (!self.is_software()).then(made)
    }

    /// Forgets the light field.
    pub fn clear(&mut self) {
        let mut renderer = self.render.renderer.write();
        self.views.drain(..).for_each(|id| renderer.free_texture(&id));
        self.shown.iter_mut().filter_map(Option::take).for_each(|shown| renderer.free_texture(&shown.id));
        self.field = None;
    }

    /// Room for a light field of this shape; what was there goes, unless the shape is the same.
    fn make_room(&mut self, grid: ViewGrid, size: [u32; 2]) {
        let fits = |field: &FieldTexture| field.grid() == grid && field.size() == size;
        if self.field.as_ref().is_some_and(fits) {
            return;
        }
        self.clear();
        self.field = FieldTexture::new(&self.gpu, grid, size);
        let Some(field) = &self.field else { return };
        let mut renderer = self.render.renderer.write();
        self.views = grid
            .views()
            .map(|at| {
                let view = field.encoded_view(at);
                renderer.register_native_texture(&self.render.device, &view, wgpu::FilterMode::Linear)
            })
            .collect();
    }

    /// Queues one view.
    pub fn push_view(&mut self, grid: ViewGrid, at: ViewIndex, view: &Arc<View>) {
        self.make_room(grid, view.size());
        if let Some(field) = &mut self.field {
            field.push_view(at, view);
        }
    }

    /// Queues a whole light field; views that are there already are replaced.
    pub fn push_field(&mut self, light_field: &LightField) {
        self.make_room(light_field.grid(), light_field.size());
        if let Some(field) = &mut self.field {
            field.push_field(light_field);
        }
    }

    /// Queues ray depths.
    pub fn push_depths(&mut self, depths: &Arc<RayDepths>) {
        self.make_room(depths.grid(), depths.size());
        if let Some(field) = &mut self.field {
            field.push_depths(depths);
        }
    }

    /// Uploads a frame's share; true while more waits. `frame` is how long the last frame took.
    pub fn upload_some(&mut self, frame: Duration) -> bool {
        self.field.as_mut().is_some_and(|field| field.upload_some(&self.gpu, Budget::of_frame(frame)))
    }

    /// Whether something waits to be uploaded.
    pub fn is_uploading(&self) -> bool {
        self.field.as_ref().is_some_and(FieldTexture::is_waiting)
    }

    /// Grid and size of the views, once some are there.
    pub fn shape(&self) -> Option<(ViewGrid, [u32; 2])> {
        self.field.as_ref().filter(|field| field.views_arrived() > 0).map(|field| (field.grid(), field.size()))
    }

    /// Views that are on the device, and all of them.
    pub fn arrived(&self) -> Option<(usize, usize)> {
        self.field.as_ref().map(|field| (field.views_arrived(), field.grid().count()))
    }

    /// One view as egui draws it, if it has arrived.
    pub fn view(&self, grid: ViewGrid, at: ViewIndex) -> Option<TextureId> {
        let field = self.field.as_ref().filter(|field| field.has_view(at))?;
        (field.grid() == grid).then(|| self.views.get(grid.layer_from_view(at)).copied())?
    }

    /// A picture of the light field, drawn again if what it shows has changed; `None` while nothing has arrived.
    pub fn show(&mut self, slot: Slot, draw: Draw) -> Option<TextureId> {
        let field = self.field.as_ref()?;
        let has_content = match draw {
            Draw::Depth { view, .. } => field.has_depth(view),
            _ => field.views_arrived() > 0,
        };
        if !has_content {
            return None;
        }
        let size = draw.size(field.grid(), field.size());
        let shown = &mut self.shown[slot as usize];
        if shown.as_ref().is_none_or(|shown| shown.target.size() != size) {
            let target = Target::new(&self.gpu, size);
            let mut renderer = self.render.renderer.write();
            if let Some(old) = shown.take() {
                renderer.free_texture(&old.id);
            }
            let filter = wgpu::FilterMode::Linear;
            let id = renderer.register_native_texture(&self.render.device, target.encoded_view(), filter);
            *shown = Some(Shown { target, id, drawn_at: Instant::now() });
        }
        let shown = shown.as_mut()?;
        let waits = self.gpu.is_software() && (self.is_streaming || field.is_waiting());
        if waits && shown.target.has_drawn(&draw) && shown.drawn_at.elapsed() < STREAM_FRAMES {
            return Some(shown.id);
        }
        if shown.target.update(&self.gpu, field, &draw) {
            shown.drawn_at = Instant::now();
        }
        Some(shown.id)
    }
}
