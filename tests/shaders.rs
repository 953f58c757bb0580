//! Every shader parses and validates, without a device.

#![cfg(feature = "ui")]

#[test]
fn shaders_are_valid() {
    for (name, source) in plenoscope::render::gpu::shader_sources() {
        let module =
            naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&source)));
        let mut validator =
            naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&source)));
    }
}
