// A viewpoint between views, by backward warp of the four nearest. Twin: src/render/cpu/view.rs.
// Keep in sync with `Viewpoint` in src/render/gpu/uniforms.rs.

struct Viewpoint {
    count: u32, // of taps, 1 to 4
    has_depths: u32,
    search_steps: u32,
    half_trust: f32, // px per view step
    taps: array<Tap, 4>,
}

@group(0) @binding(4) var<uniform> viewpoint: Viewpoint;

// xy: where in the view the ray is that ends at `here`; z: trust, 0 to 1.
fn search(part: Tap, here: vec2f, near: f32) -> vec3f {
    var disparity = near;
    var change = 0.0;
    for (var i = 0u; i < viewpoint.search_steps; i++) {
        let found = depth_tap(part.layer, here - part.offset * disparity);
        change = (found - disparity) / viewpoint.half_trust;
        disparity = found;
    }
    return vec3f(here - part.offset * disparity, 1.0 / (1.0 + change * change));
}

@fragment
fn main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = floor(position.xy);
    var near = -1e30;
    if viewpoint.has_depths != 0u {
        for (var i = 0u; i < viewpoint.count; i++) {
            near = max(near, depth_tap(viewpoint.taps[i].layer, here));
        }
    }
    var sum = vec3f(0.0);
    var total = 0.0;
    for (var i = 0u; i < viewpoint.count; i++) {
        let part = viewpoint.taps[i];
        var found = vec3f(here, 1.0);
        if viewpoint.has_depths != 0u {
            found = search(part, here, near);
        }
        sum += tap(part.layer, found.xy) * part.weight * found.z;
        total += part.weight * found.z;
    }
    return vec4f(sum / total, 1.0);
}
