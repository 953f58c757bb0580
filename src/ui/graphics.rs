//! What could draw the window here, for whoever looks for the reason why nothing does.

use serde::Serialize;

/// A device, as its driver describes it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Adapter {
    /// Its name.
    pub name: String,
    /// Discrete, integrated, or a processor.
    pub kind: String,
    /// Vulkan, Metal or DirectX 12.
    pub interface: String,
    /// The driver and its version.
    pub driver: String,
    /// Whether it is a processor that plays a graphics card.
    pub is_software: bool,
    /// Longest side of a texture, in pixels.
    pub texture_px: u32,
    /// The largest buffer, in bytes.
    pub buffer_bytes: u64,
}

/// All devices that the window could use, in the order of their drivers.
pub fn adapters() -> Vec<Adapter> {
    let backends = super::backends();
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let found = pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends));
    found.iter().map(describe).collect()
}

fn describe(adapter: &wgpu::Adapter) -> Adapter {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    Adapter {
        name: info.name,
        kind: format!("{:?}", info.device_type),
        interface: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        is_software: info.device_type == wgpu::DeviceType::Cpu,
        texture_px: limits.max_texture_dimension_2d,
        buffer_bytes: limits.max_buffer_size,
    }
}
