// Shift and add at light-field size. Twin: src/render/cpu/refocus.rs.
// Keep in sync with `Refocus` in src/render/gpu/uniforms.rs.

struct Refocus {
    focus: vec3f, // disparity in the middle, and its growth from left to right and from top to bottom
    count: u32, // of taps
    keep_sharp: vec2f, // disparities around the focal plane that stay sharp too
    depth_layer: u32,
    has_depths: u32,
    taps: array<Tap, 289>,
}

@group(0) @binding(4) var<uniform> refocus: Refocus;

@fragment
fn main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = floor(position.xy);
    let size = vec2f(textureDimensions(views_low));
    let n = (here + 0.5) / size;
    var focus = refocus.focus.x + refocus.focus.y * (n.x - 0.5) + refocus.focus.z * (n.y - 0.5);
    if refocus.has_depths != 0u {
        let away = depth_tap(refocus.depth_layer, here) - focus;
        focus += clamp(away, refocus.keep_sharp.x, refocus.keep_sharp.y);
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < refocus.count; i++) {
        let part = refocus.taps[i];
        sum += tap(part.layer, here - part.offset * focus) * part.weight;
    }
    return vec4f(sum, 1.0);
}
