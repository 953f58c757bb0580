// The lens renderer on a device: twin of tile.rs (pieces), rays.rs (slices) and spread.rs (spans, cover).
//
// Light is spread as whole numbers, so that the order in which the threads add is of no matter: a unit is 2^-24, and
// differences along a row may wrap round, as their sum does not.

struct Params {
    // Pixels around the region whose light may reach it: how many, and where they begin in the picture.
    gather_size: vec2u,
    gather_at: vec2i,
    // The region: how many pixels, and where it begins in the gathered ones.
    size: vec2u,
    inset: vec2i,
    picture_size: vec2u,
    // Pixels of blur per pixel of disparity.
    gain: f32,
    highlights: f32,
    // Disparity of what is sharp, its growth to the right and down; then what is kept sharp beside it.
    focus: vec4f,
    keep_sharp: vec2f,
    padding: vec2f,
}

struct Span {
    dy: i32,
    begin: i32,
    end: i32,
    padding: i32,
    begin_parts: vec2f,
    end_parts: vec2f,
}

const UNIT: f32 = 16777216.0;
const MIDDLE: i32 = 28;
const SHARP_PX: f32 = 0.3;
const NEARLY_SHARP: i32 = 6;
const NEVER: f32 = -1000.0;
const NEARLY_SHARP_PX: f32 = 5.7;
const SLACK: f32 = 0.03;
const FARTHER_PX: vec2f = vec2f(2.5, 5.5);
const LOOSE = vec2f(0.05, 0.2);
const DARK: f32 = 0.004;
const FAR_SPREAD: f32 = 1.5;
const NEAR_SPREAD: f32 = 4.0;
const STAIN_PX = vec2f(1.5, 6.0);
const ROW_LANES: u32 = 64u;

@group(0) @binding(0) var<uniform> params: Params;
// What each gathered pixel sees: colour and near disparity; far disparity, coverage, edge, share of what is behind;
// colour and disparity of that; colour of the near side on the whole, and the distance from the edge; colour of the far
// side on the whole, and how far the pixel's own is stained.
@group(0) @binding(1) var<storage, read> colors: array<vec4f>;
@group(0) @binding(2) var<storage, read> sides: array<vec4f>;
@group(0) @binding(3) var<storage, read> hidden: array<vec4f>;
@group(0) @binding(4) var<storage, read> nears: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> lights: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> blurs: array<f32>;

// The lens's kernels: first span and number of spans of each diameter, upright and flipped.
@group(0) @binding(7) var<storage, read> kernels: array<vec2u>;
@group(0) @binding(8) var<storage, read> spans: array<Span>;
@group(0) @binding(9) var<storage, read_write> steps: array<atomic<i32>>;
@group(0) @binding(10) var<storage, read_write> still: array<vec4f>;
@group(0) @binding(11) var<storage, read_write> front: array<vec4f>;
// What is left to cover before anything nearly sharp is put.
@group(0) @binding(12) var<storage, read_write> open: array<f32>;
// The slice of each gathered pixel before which its own surface is put, and the most that may then be left open; below 0
// all of the lens sees it, spread widely.
@group(0) @binding(13) var<storage, read_write> seen: array<vec2f>;
@group(0) @binding(14) var<storage, read> fars: array<vec4f>;

@group(1) @binding(0) var<uniform> slice: vec4i;

fn ramp(from_: f32, to: f32, value: f32) -> f32 {
    let t = clamp((value - from_) / (to - from_), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

fn blur_of(disparity: f32, pixel: vec2i) -> f32 {
    let place = (vec2f(pixel) + 0.5) / vec2f(params.picture_size) - 0.5;
    let away = disparity - (params.focus.x + dot(params.focus.yz, place));
    return params.gain * (away - clamp(away, params.keep_sharp.x, params.keep_sharp.y));
}

fn slice_of(blur: f32) -> f32 {
    let size = abs(blur);
    var at = size;
    if size > 2.0 {
        at = 2.0 + log(size / 2.0) / log(1.3);
    }
    at = min(at, f32(MIDDLE) - 1.0);
    return select(at, -at, blur < 0.0);
}

fn recovered(rgb: vec3f, blur: f32) -> vec3f {
    let clipped = ramp(0.85, 1.0, max(rgb.r, max(rgb.g, rgb.b)));
    return rgb * (1.0 + 9.0 * params.highlights * clipped * ramp(1.0, 8.0, abs(blur)));
}

fn store(i: u32, near: vec4f, near_blur: f32, far: vec4f, far_blur: f32) {
    lights[2u * i] = near;
    lights[2u * i + 1u] = far;
    blurs[2u * i] = near_blur;
    blurs[2u * i + 1u] = far_blur;
}

// The part of a disc around a gathered pixel that is not its own surface; never less than of the pixel itself.
fn beyond(at: vec2i, blur: f32) -> f32 {
    let radius = abs(blur) / 2.0;
    var all = 0.0;
    var beyond = 0.0;
    let reach = i32(ceil(radius + 0.5)) - 1;
    for (var dy = -reach; dy <= reach; dy++) {
        for (var dx = -reach; dx <= reach; dx++) {
            let weight = clamp(radius + 0.5 - length(vec2f(f32(dx), f32(dy))), 0.0, 1.0);
            let place = clamp(at + vec2i(dx, dy), vec2i(0), vec2i(params.gather_size) - 1);
            let i = u32(place.y) * params.gather_size.x + u32(place.x);
            let farther = blur - blur_of(colors[i].w, params.gather_at + place);
            all += weight;
            beyond += weight * (1.0 - sides[i].y * (1.0 - ramp(FARTHER_PX.x, FARTHER_PX.y, farther)));
        }
    }
    let own = sides[u32(at.y) * params.gather_size.x + u32(at.x)].y;
    return max(beyond / max(all, 1e-6), 1.0 - own);
}

fn seen_before(i: u32, id: vec2u, pixel: vec2i) -> vec2f {
    let cover = sides[i].y;
    let blur = blur_of(select(colors[i].w, sides[i].x, cover <= 0.01), pixel);
    let is_rim = sides[i].w > 0.0 && nears[i].w <= abs(blur) / 2.0 + 1.5;
    let slice = floor(slice_of(blur)) - 2.0;
    if !is_rim && (cover <= 0.01 || cover >= 0.99) {
        return vec2f(slice, select(-1.0, 0.0, abs(blur) < NEARLY_SHARP_PX));
    }
    if cover <= 0.01 || abs(blur) >= NEARLY_SHARP_PX {
        return vec2f(NEVER, 0.0);
    }
    return vec2f(slice, beyond(vec2i(id), blur) + SLACK);
}

// Light of each pixel: from its near side, and from what goes on behind that.
@compute @workgroup_size(8, 8)
fn pieces(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.gather_size) {
        return;
    }
    let i = id.y * params.gather_size.x + id.x;
    let pixel = params.gather_at + vec2i(id.xy);
    seen[i] = seen_before(i, id.xy, pixel);
    var color = colors[i].rgb;
    var cover = sides[i].y;
    let share = sides[i].w;
    let nothing = vec4f(0.0);
    let far_own = blur_of(sides[i].x, pixel);
    var near = blur_of(colors[i].w, pixel);
    let stained = fars[i].w * ramp(STAIN_PX.x, STAIN_PX.y, abs(near));
    if cover <= 0.01 {
        color = mix(color, fars[i].rgb, stained);
        near = far_own;
    }
    let mixed = cover > 0.01 && cover < 0.99;
    let known_behind = share > 0.0;
    let far = select(blur_of(hidden[i].w, pixel), far_own, mixed);
    let apart = ramp(0.4, 1.2, slice_of(near) - slice_of(far));
    let alone = apart <= 0.0 && (!mixed || max(abs(near), abs(far)) < SHARP_PX || !known_behind);
    if alone || (!mixed && !known_behind) {
        store(i, vec4f(recovered(color, near), 1.0), near, nothing, 0.0);
        return;
    }
    if !mixed {
        let reach = max(abs(near), abs(far)) / 2.0 + 1.5;
        let part = share * apart * (1.0 - ramp(reach, 1.5 * reach + 4.0, nears[i].w));
        let behind = vec4f(recovered(hidden[i].rgb, far) * part, part);
        store(i, vec4f(recovered(color, near), 1.0), near, behind, far);
        return;
    }
    let known = share * apart * sides[i].z;
    let back = select(vec3f(0.0), hidden[i].rgb, known_behind);
    let part = (color + DARK) / (back + DARK);
    cover = max(cover, known * max(1.0 - FAR_SPREAD * min(part.r, min(part.g, part.b)), 0.0));
    let low = min(color, nears[i].rgb / NEAR_SPREAD);
    let high = max(color, nears[i].rgb * NEAR_SPREAD);
    let unmixed = min(cover * clamp((color - (1.0 - cover) * back) / cover, low, high), color);
    let own = cover * color + (unmixed - cover * color) * known;
    let rest = mix(color - own, (1.0 - cover) * fars[i].rgb, stained) + cover * known * back;
    store(i, vec4f(own, cover), near, vec4f(rest, 1.0 - cover + cover * known), far);
}

fn index_of(diameter: f32) -> u32 {
    var at = 320.0 + (diameter - 32.0) * 4.0;
    if diameter < 8.0 {
        at = diameter * 16.0;
    } else if diameter < 32.0 {
        at = 128.0 + (diameter - 8.0) * 8.0;
    }
    return u32(at + 0.5);
}

fn add_step(row: u32, column: i32, light: vec4f) {
    let last = i32(params.size.x) + 1;
    let at = 4u * (row * (params.size.x + 2u) + u32(clamp(column, 0, last)));
    let units = vec4i(round(light * UNIT));
    for (var c = 0u; c < 4u; c++) {
        if units[c] != 0 {
            atomicAdd(&steps[at + c], units[c]);
        }
    }
}

// The part of each pixel's light that belongs to the slice, spread over the region.
@compute @workgroup_size(8, 8)
fn spread(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= params.gather_size) {
        return;
    }
    let i = id.y * params.gather_size.x + id.x;
    let at = vec2i(id.xy) - params.inset;
    for (var k = 0u; k < 2u; k++) {
        let whole = lights[2u * i + k];
        if whole.w <= 0.0 {
            continue;
        }
        let blur = blurs[2u * i + k];
        let position = slice_of(blur);
        let first = i32(floor(position));
        let upper = clamp((position - floor(position) - 0.3) / 0.4, 0.0, 1.0);
        var share = 0.0;
        if first == slice.x {
            share = 1.0 - upper;
        } else if first + 1 == slice.x {
            share = upper;
        }
        let size = abs(blur);
        if share <= 0.0 {
            continue;
        }
        let light = whole * share;
        if size < SHARP_PX {
            if all(at >= vec2i(0)) && all(at < vec2i(params.size)) {
                still[u32(at.y) * params.size.x + u32(at.x)] += light;
            }
            continue;
        }
        let outside = max(-at, at - vec2i(params.size) + 1);
        if f32(max(outside.x, outside.y)) > size / 2.0 + 2.0 {
            continue;
        }
        let kernel = kernels[2u * index_of(size) + select(0u, 1u, blur < 0.0)];
        for (var s = kernel.x; s < kernel.x + kernel.y; s++) {
            let span = spans[s];
            let y = at.y + span.dy;
            if y < 0 || y >= i32(params.size.y) {
                continue;
            }
            add_step(u32(y), at.x + span.begin, light * span.begin_parts.x);
            add_step(u32(y), at.x + span.begin + 1, light * span.begin_parts.y);
            add_step(u32(y), at.x + span.end, -light * span.end_parts.x);
            add_step(u32(y), at.x + span.end + 1, -light * span.end_parts.y);
        }
    }
}

var<workgroup> sums: array<vec4i, ROW_LANES>;

// Sums the differences of a row up and puts the slice behind what is there.
@compute @workgroup_size(ROW_LANES)
fn cover(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let row = group.x;
    let wide = params.size.x + 2u;
    var before = vec4i(0);
    for (var from_ = 0u; from_ < wide; from_ += ROW_LANES) {
        let x = from_ + lane;
        var own = vec4i(0);
        if x < wide {
            let at = 4u * (row * wide + x);
            for (var c = 0u; c < 4u; c++) {
                own[c] = atomicExchange(&steps[at + c], 0);
            }
        }
        sums[lane] = own;
        workgroupBarrier();
        for (var reach = 1u; reach < ROW_LANES; reach *= 2u) {
            var other = vec4i(0);
            if lane >= reach {
                other = sums[lane - reach];
            }
            workgroupBarrier();
            sums[lane] += other;
            workgroupBarrier();
        }
        let sum = before + sums[lane];
        before += sums[ROW_LANES - 1u];
        workgroupBarrier();
        if x < params.size.x {
            let gathered = vec2u(vec2i(vec2u(x, row)) + params.inset);
            let own = seen[gathered.y * params.gather_size.x + gathered.x];
            put_behind(row * params.size.x + x, vec4f(sum) / UNIT, own);
        }
    }
}

fn narrow(i: u32, opened: f32) {
    let left = front[i].w;
    if left > opened && left < 1.0 {
        front[i] = vec4f(front[i].rgb * ((1.0 - opened) / (1.0 - left)), opened);
    }
}

fn close(i: u32, opened: f32) {
    let left = front[i].w;
    if left > 0.0 && left < LOOSE.y * opened {
        narrow(i, left * ramp(LOOSE.x, LOOSE.y, left / opened));
    }
}

fn put_behind(i: u32, spread_light: vec4f, own: vec2f) {
    let light = spread_light + still[i];
    still[i] = vec4f(0.0);
    if slice.x == NEARLY_SHARP {
        open[i] = front[i].w;
    } else if slice.x == -NEARLY_SHARP - 1 {
        close(i, open[i]);
    }
    if f32(slice.x) == own.x {
        if own.y < 0.0 {
            close(i, 1.0);
        } else {
            narrow(i, own.y);
        }
    }
    if light.w <= 1e-5 {
        return;
    }
    var closed = light.w;
    if closed >= 0.8 {
        closed = min(closed + 0.015 * min((closed - 0.8) * 10.0, 1.0), 1.0);
    }
    let share = min(closed, front[i].w);
    front[i] += vec4f(max(light.rgb, vec3f(0.0)) * (share / light.w), -share);
}
