// The twin of `src/splats/raster.rs`: one workgroup a tile, one invocation a pixel, ellipses from the near side on.

struct Params {
    size: vec2u,
    across: u32,
    most_opaque: f32,
    done: f32,
    least: f32,
}

// As in `mod.rs`: `at`, opacity and variances at most; `[a, b, c]` and nearness; colour.
struct Ellipse {
    at: vec2f,
    opacity: f32,
    most: f32,
    shape: vec3f,
    nearness: f32,
    color: vec4f,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> ellipses: array<Ellipse>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> numbers: array<u32>;
// Light and how much is covered, and the expected nearness of each ray.
@group(0) @binding(4) var<storage, read_write> light: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> nearness: array<f32>;

@compute @workgroup_size(16, 16)
fn blend(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.size) {
        return;
    }
    let tile = group.y * params.across + group.x;
    let pixel = vec2f(id.xy);
    var left = 1.0;
    var sum = vec4f(0.0);
    for (var i = starts[tile]; i < starts[tile + 1u] && left > params.done; i++) {
        let ellipse = ellipses[numbers[i]];
        let d = pixel - ellipse.at;
        let away = dot(ellipse.shape, vec3f(d.x * d.x, 2.0 * d.x * d.y, d.y * d.y));
        if away <= ellipse.most {
            let alpha = min(ellipse.opacity * exp(-0.5 * max(away, 0.0)), params.most_opaque);
            let weight = alpha * left;
            left -= weight;
            sum += weight * vec4f(ellipse.color.rgb, ellipse.nearness);
        }
    }
    let at = id.y * params.size.x + id.x;
    let covered = 1.0 - left;
    light[at] = vec4f(sum.rgb, covered);
    nearness[at] = select(0.0, sum.a / covered, covered > params.least);
}
