// Shared by all passes: light field access with explicit bilinear taps, and the full-screen triangle.
// Twins: `tap` and `nearest` in src/render/cpu/mod.rs. Conventions: src/field/mod.rs.

// Views as layers of two array textures: the second holds what is above the adapter's limit of layers.
@group(0) @binding(0) var views_low: texture_2d_array<f32>;
@group(0) @binding(1) var views_high: texture_2d_array<f32>;
// Disparity of each ray, px per view step, in the same layers.
@group(0) @binding(2) var depths_low: texture_2d_array<f32>;
@group(0) @binding(3) var depths_high: texture_2d_array<f32>;

// One view's part in a picture. Keep in sync with `Tap` in src/render/gpu/uniforms.rs.
struct Tap {
    offset: vec2f, // steps from the viewpoint, x = du, y = dv
    weight: f32,
    layer: u32,
}

@vertex
fn full_screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

fn linear_texel(layer: u32, at: vec2i) -> vec3f {
    let split = textureNumLayers(views_low);
    if layer < split {
        return textureLoad(views_low, at, layer, 0).rgb;
    }
    return textureLoad(views_high, at, layer - split, 0).rgb;
}

// A colour in linear light between pixel centres; the edge pixel goes on.
fn tap(layer: u32, place: vec2f) -> vec3f {
    let last = vec2f(textureDimensions(views_low)) - 1.0;
    let inside = clamp(place, vec2f(0.0), last);
    let low = floor(inside);
    let part = inside - low;
    let p0 = vec2i(low);
    let p1 = min(p0 + 1, vec2i(last));
    let a = linear_texel(layer, p0);
    let b = linear_texel(layer, vec2i(p1.x, p0.y));
    let c = linear_texel(layer, vec2i(p0.x, p1.y));
    let d = linear_texel(layer, p1);
    let top = a + (b - a) * part.x;
    let bottom = c + (d - c) * part.x;
    return top + (bottom - top) * part.y;
}

// Disparity nearest to a place.
fn depth_tap(layer: u32, place: vec2f) -> f32 {
    let last = vec2f(textureDimensions(depths_low)) - 1.0;
    let at = vec2i(clamp(floor(place + 0.5), vec2f(0.0), last));
    let split = textureNumLayers(depths_low);
    if layer < split {
        return textureLoad(depths_low, at, layer, 0).r;
    }
    return textureLoad(depths_high, at, layer - split, 0).r;
}
