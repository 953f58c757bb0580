// Shift and add at light-field size. Twin: src/render/cpu/refocus.rs.
// Keep in sync with `Refocus` in src/render/gpu/uniforms.rs.

struct Refocus {
    focus: vec3f, // disparity in the middle, and its growth from left to right and from top to bottom
    count: u32, // of taps
    keep_sharp: vec2f, // disparities around the focal plane that stay sharp too
    depth_layer: u32,
    has_depths: u32,
    strewn: f32, // steps between the views that each tap is strewn over, 0: none
    pieces: u32, // of a tap that is strewn, along each axis
    pad_0: u32,
    pad_1: u32,
    taps: array<Tap, 289>,
}

@group(0) @binding(4) var<uniform> refocus: Refocus;

// A number that looks random (PCG).
fn scramble(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// The nth place of a pixel's sequence in a square of side 1, evenly spread over it.
fn strewn(seed: vec2u, n: u32) -> vec2f {
    let turn = seed + n * vec2u(3242174889u, 2447445415u);
    return vec2f(turn >> vec2u(8u)) / 16777216.0;
}

// The mean of what eyes beside a view see: the same things, displaced by their disparity.
fn tap_around(layer: u32, place: vec2f, reach: f32, at: vec2f) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < refocus.pieces * refocus.pieces; i++) {
        let piece = vec2f(vec2u(i % refocus.pieces, i / refocus.pieces));
        sum += tap(layer, place + ((piece + at) / f32(refocus.pieces) - 0.5) * reach);
    }
    return sum / f32(refocus.pieces * refocus.pieces);
}

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
    let pixel = vec2u(here);
    let first = scramble(pixel.x + scramble(pixel.y));
    let seed = vec2u(first, scramble(first));
    var sum = vec3f(0.0);
    for (var i = 0u; i < refocus.count; i++) {
        let part = refocus.taps[i];
        let place = here - part.offset * focus;
        if refocus.strewn > 0.0 {
            let reach = refocus.strewn * (depth_tap(part.layer, place) - focus);
            sum += tap_around(part.layer, place, reach, strewn(seed, i)) * part.weight;
        } else {
            sum += tap(part.layer, place) * part.weight;
        }
    }
    return vec4f(sum, 1.0);
}
