//! Pictures from a light field with wgpu, for looking: one pass a picture kind, each with a twin in [`super::cpu`].
//!
//! A pass draws into a [`Target`] at light-field size, and only when what it depends on has changed; egui then draws the
//! target's sRGB copy with pan and zoom like any other texture.

mod field_texture;
mod pass;
mod target;
mod uniforms;

pub use field_texture::{Budget, FieldTexture};
pub use target::{Draw, Target};

use pass::{Pass, Present};

/// All passes of a device.
#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    layout: wgpu::BindGroupLayout,
    refocus: Pass,
    view: Pass,
    epi: Pass,
    depth: Pass,
    present: Present,
    /// Whether the device is a processor, so that heavy passes are thinned while something moves.
    is_software: bool,
}

impl Gpu {
    /// Builds the passes; `is_software` where the adapter is a processor.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, is_software: bool) -> Self {
        let layout = pass::field_layout(device);
        let pass = |name, source| Pass::new(device, &layout, name, source);
        Self {
            refocus: pass("refocus", include_str!("shaders/refocus.wgsl")),
            view: pass("view", include_str!("shaders/view.wgsl")),
            epi: pass("epi", include_str!("shaders/epi.wgsl")),
            depth: pass("depth", include_str!("shaders/depth.wgsl")),
            present: Present::new(device),
            device: device.clone(),
            queue: queue.clone(),
            layout,
            is_software,
        }
    }

    /// The device that the passes run on.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue that they are put into.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Whether the device is a processor.
    pub fn is_software(&self) -> bool {
        self.is_software
    }

    /// The longest side of a texture.
    pub fn max_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }
}

/// All shaders with their names, for validation without a device.
pub fn shader_sources() -> Vec<(&'static str, String)> {
    let common = include_str!("shaders/common.wgsl");
    let with_common = |source: &str| format!("{common}\n{source}");
    vec![
        ("refocus", with_common(include_str!("shaders/refocus.wgsl"))),
        ("view", with_common(include_str!("shaders/view.wgsl"))),
        ("epi", with_common(include_str!("shaders/epi.wgsl"))),
        ("depth", with_common(include_str!("shaders/depth.wgsl"))),
        ("present", include_str!("shaders/present.wgsl").to_owned()),
        ("lens", include_str!("../lens/gpu/lens.wgsl").to_owned()),
        ("splats", include_str!("../../splats/gpu/blend.wgsl").to_owned()),
    ]
}
