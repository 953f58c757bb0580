// Ray depths of one view in colour. Twins: src/render/cpu/depth.rs, src/render/cpu/colormap.rs.
// Keep in sync with `Depth` in src/render/gpu/uniforms.rs.

struct Depth {
    range: vec2f, // px per view step, far to near
    layer: u32,
    gray: u32, // 1: no polynomial, near is white
    powers: array<vec4f, 7>, // the colour map's polynomial, powers 0 to 6 of rgb
}

@group(0) @binding(4) var<uniform> depth: Depth;

fn linear_from_srgb(encoded: vec3f) -> vec3f {
    let low = encoded / 12.92;
    let high = pow((encoded + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, encoded <= vec3f(0.04045));
}

@fragment
fn main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let width = max(depth.range.y - depth.range.x, 1e-6);
    let t = clamp((depth_tap(depth.layer, floor(position.xy)) - depth.range.x) / width, 0.0, 1.0);
    var color = vec3f(0.0);
    for (var i = 6; i >= 0; i--) {
        color = color * t + depth.powers[i].rgb;
    }
    color = clamp(color, vec3f(0.0), vec3f(1.0));
    if depth.gray != 0u {
        color = vec3f(t);
    }
    return vec4f(linear_from_srgb(color), 1.0);
}
