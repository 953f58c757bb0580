// An epipolar image: one picture line in all views of a row or column. Twin: src/render/cpu/epi.rs.
// Keep in sync with `Epi` in src/render/gpu/uniforms.rs.

struct Epi {
    column: u32, // 0: a picture row, drawn [u, x]; 1: a picture column, drawn [y, v]
    line: f32, // the row's y or the column's x
    first_layer: u32, // layer of the first view of the cut
    layer_step: u32, // layers from one view of the cut to the next
    scale: u32, // pixels that a view is thick
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}

@group(0) @binding(4) var<uniform> epi: Epi;

@fragment
fn main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = vec2u(floor(position.xy));
    if epi.column == 0u {
        let layer = epi.first_layer + here.y / epi.scale * epi.layer_step;
        return vec4f(tap(layer, vec2f(f32(here.x), epi.line)), 1.0);
    }
    let layer = epi.first_layer + here.x / epi.scale * epi.layer_step;
    return vec4f(tap(layer, vec2f(epi.line, f32(here.y))), 1.0);
}
