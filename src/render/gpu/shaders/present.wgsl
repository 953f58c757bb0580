// A pass's picture (linear light) for the screen: sRGB-encoded, as egui expects its textures.

@group(0) @binding(0) var picture: texture_2d<f32>;

@vertex
fn full_screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

fn srgb_from_linear(linear: vec3f) -> vec3f {
    let light = clamp(linear, vec3f(0.0), vec3f(1.0));
    let low = light * 12.92;
    let high = 1.055 * pow(light, vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, light <= vec3f(0.0031308));
}

@fragment
fn main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(srgb_from_linear(textureLoad(picture, vec2i(position.xy), 0).rgb), 1.0);
}
