//! A picture on the device, drawn again only when what it shows has changed.

use super::pass::{self, ENCODED_FORMAT, LINEAR_FORMAT};
use super::uniforms::{Depth, Epi, MAX_TAPS, Refocus, Tap, Viewpoint};
use super::{FieldTexture, Gpu};
use crate::field::{EpiLine, Lens, ViewGrid, ViewIndex, ViewPoint};
use crate::render::aperture;
use crate::render::cpu::{Colormap, STREWN_PIECES};

/// What a picture shows; also the key by which it is drawn again.
#[derive(Clone, Debug, PartialEq)]
pub enum Draw {
    /// Twin of [`cpu::refocus_with_depths`](crate::render::cpu::refocus_with_depths), strewn of
    /// [`cpu::refocus_strewn`](crate::render::cpu::refocus_strewn).
    Refocus {
        /// The lens.
        lens: Lens,
        /// Where it stands.
        center: ViewPoint,
        /// Takes every second view only: a draft while something moves on a slow device.
        is_draft: bool,
        /// Whether eyes between the views count too, by the ray depths: a draft whose copies would be seen.
        is_strewn: bool,
    },
    /// Twin of [`cpu::view_with_depths`](crate::render::cpu::view_with_depths).
    View(ViewPoint),
    /// Twin of [`cpu::epi`](crate::render::cpu::epi).
    Epi {
        /// The cut.
        line: EpiLine,
        /// Pixels that a view is thick.
        scale: u32,
    },
    /// Twin of [`cpu::depth`](crate::render::cpu::depth).
    Depth {
        /// Whose ray depths.
        view: ViewIndex,
        /// Disparities at the ends of the colour map, far and near.
        range: [f32; 2],
        /// The colour map.
        map: Colormap,
    },
}

impl Draw {
    /// Size of the picture for a light field of views of `size`.
    pub fn size(&self, grid: ViewGrid, size: [u32; 2]) -> [u32; 2] {
        match *self {
            Self::Epi { line: EpiLine::Row { .. }, scale } => [size[0], grid.cols() as u32 * scale.max(1)],
            Self::Epi { line: EpiLine::Column { .. }, scale } => [grid.rows() as u32 * scale.max(1), size[1]],
            _ => size,
        }
    }
}

/// A picture in linear light and its sRGB copy for egui.
#[derive(Debug)]
pub struct Target {
    size: [u32; 2],
    linear: wgpu::Texture,
    linear_view: wgpu::TextureView,
    encoded_view: wgpu::TextureView,
    present_bindings: wgpu::BindGroup,
    uniform: wgpu::Buffer,
    drawn: Option<(Draw, u64)>,
}

impl Target {
    /// A picture of `size` pixels, black until it is drawn.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let [linear, encoded] = [LINEAR_FORMAT, ENCODED_FORMAT].map(|format| texture(gpu, size, format));
        let linear_view = linear.create_view(&Default::default());
        let present_bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("present"),
            layout: &gpu.present.layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&linear_view) }],
        });
        let uniform = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniform"),
            size: size_of::<Refocus>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let encoded_view = encoded.create_view(&Default::default());
        Self { size, linear, linear_view, encoded_view, present_bindings, uniform, drawn: None }
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What egui draws: sRGB-encoded values.
    pub fn encoded_view(&self) -> &wgpu::TextureView {
        &self.encoded_view
    }

    /// The linear picture, to be read back by tests.
    pub fn linear_texture(&self) -> &wgpu::Texture {
        &self.linear
    }

    /// Whether this is what was drawn last, of the layers that had arrived then.
    pub fn has_drawn(&self, draw: &Draw) -> bool {
        self.drawn.as_ref().is_some_and(|(drawn, _)| drawn == draw)
    }

    /// Puts the picture into the device's queue if it is not the one that is there already; true if it was drawn.
    pub fn update(&mut self, gpu: &Gpu, field: &FieldTexture, draw: &Draw) -> bool {
        let changes = field.changes();
        if self.drawn.as_ref().is_some_and(|(drawn, then)| drawn == draw && *then == changes) {
            return false;
        }
        let Some(pass) = self.write_uniform(gpu, field, draw) else { return false };
        let bindings = self.bindings(gpu, field);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        pass::run(&mut encoder, &pass.pipeline, &bindings, &self.linear_view);
        pass::run(&mut encoder, &gpu.present.pipeline, &self.present_bindings, &self.encoded_view);
        gpu.queue.submit([encoder.finish()]);
        self.drawn = Some((draw.clone(), changes));
        true
    }

    /// Writes the uniform and tells its pass; `None` where nothing has arrived that could be drawn.
    fn write_uniform<'a>(&self, gpu: &'a Gpu, field: &FieldTexture, draw: &Draw) -> Option<&'a pass::Pass> {
        let write = |bytes: &[u8]| gpu.queue.write_buffer(&self.uniform, 0, bytes);
        match *draw {
            Draw::Refocus { ref lens, center, is_draft, is_strewn } => {
                let uniform = refocus_uniform(field, lens, center, [is_draft, is_strewn])?;
                write(bytemuck::bytes_of(&uniform));
                Some(&gpu.refocus)
            }
            Draw::View(point) => {
                write(bytemuck::bytes_of(&view_uniform(field, point)?));
                Some(&gpu.view)
            }
            Draw::Epi { line, scale } => {
                write(bytemuck::bytes_of(&epi_uniform(field.grid(), line, scale)));
                Some(&gpu.epi)
            }
            Draw::Depth { view, range, map } => {
                let layer = field.grid().layer_from_view(view) as u32;
                write(bytemuck::bytes_of(&Depth::new(range, layer, map)));
                field.has_depth(view).then_some(&gpu.depth)
            }
        }
    }

    fn bindings(&self, gpu: &Gpu, field: &FieldTexture) -> wgpu::BindGroup {
        let views = field.array_views();
        let mut entries: Vec<_> = (0..)
            .zip(&views)
            .map(|(binding, view)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) })
            .collect();
        entries.push(wgpu::BindGroupEntry { binding: 4, resource: self.uniform.as_entire_binding() });
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("light field"),
            layout: &gpu.layout,
            entries: &entries,
        })
    }
}

fn refocus_uniform(field: &FieldTexture, lens: &Lens, center: ViewPoint, draft: [bool; 2]) -> Option<Refocus> {
    let [is_draft, is_strewn] = draft;
    let grid = field.grid();
    let zero = grid.reference();
    let in_draft = |at: ViewIndex| (at.u + zero.u).is_multiple_of(2) && (at.v + zero.v).is_multiple_of(2);
    let mut parts = aperture::taps(lens, grid, center, |at| field.has_view(at) && (!is_draft || in_draft(at)));
    if parts.is_empty() {
        parts = aperture::nearest_views(grid, center, |at| field.has_view(at));
    }
    if parts.is_empty() {
        return None;
    }
    let mut taps = [Tap::default(); MAX_TAPS];
    taps.iter_mut().zip(&parts).for_each(|(tap, part)| *tap = Tap::new(part, grid));
    let nearest = grid.nearest(center.0);
    let can_be_strewn = is_strewn && parts.iter().all(|part| field.has_depth(part.view));
    Some(Refocus {
        focus: [lens.focus.disparity_px, lens.focus.tilt_px[0], lens.focus.tilt_px[1]],
        count: parts.len() as u32,
        keep_sharp: [lens.keep_sharp_px[0].min(0.0), lens.keep_sharp_px[1].max(0.0)],
        depth_layer: grid.layer_from_view(nearest) as u32,
        has_depths: u32::from(field.has_depth(nearest)),
        strewn: if !can_be_strewn {
            0.0
        } else if is_draft {
            2.0
        } else {
            1.0
        },
        pieces: if is_draft { 1 } else { STREWN_PIECES },
        pad: [0; 2],
        taps,
    })
}

fn view_uniform(field: &FieldTexture, point: ViewPoint) -> Option<Viewpoint> {
    let parts = aperture::nearest_views(field.grid(), point, |at| field.has_view(at));
    let has_depths = u32::from(parts.iter().all(|part| field.has_depth(part.view)));
    let mut uniform = Viewpoint { count: parts.len() as u32, has_depths, ..Viewpoint::default() };
    uniform.taps.iter_mut().zip(&parts).for_each(|(tap, part)| *tap = Tap::new(part, field.grid()));
    (!parts.is_empty()).then_some(uniform)
}

fn epi_uniform(grid: ViewGrid, line: EpiLine, scale: u32) -> Epi {
    let layer = |v: u8, u: u8| grid.layer_from_view(ViewIndex { v, u }) as u32;
    let scale = scale.max(1);
    match line {
        EpiLine::Row { y, v } => {
            let first_layer = layer(v.min(grid.rows() as u8 - 1), 0);
            Epi { column: 0, line: y as f32, first_layer, layer_step: 1, scale, ..Epi::default() }
        }
        EpiLine::Column { x, u } => {
            let first_layer = layer(0, u.min(grid.cols() as u8 - 1));
            let layer_step = grid.cols() as u32;
            Epi { column: 1, line: x as f32, first_layer, layer_step, scale, ..Epi::default() }
        }
    }
}

fn texture(gpu: &Gpu, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
    let usage =
        wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}
