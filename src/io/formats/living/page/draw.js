// The scene through a lens, by WebGL2: the view from beside, its pieces, their slices, each spread and put behind the nearer ones.
const HEAD = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D;
`;
const CORNERS = HEAD + `
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;

// Along the line on which the points of a pixel's ray lie, the first surface from the near side is what the eye sees.
const VIEW = HEAD + `
uniform sampler2D colors, depths, behindColors, behindDepths;
uniform vec2 size, shift, range;
uniform float coarse, pivot, isDraft;
layout(location = 0) out vec4 seen;
layout(location = 1) out vec4 sides;
layout(location = 2) out vec4 hidden;
layout(location = 3) out vec4 hiddenAt;
vec3 sidesAt(vec2 uv) {
  ivec2 full = textureSize(depths, 0);
  return texelFetch(depths, clamp(ivec2(uv * vec2(full)), ivec2(0), full - 1), 0).rgb;
}
float surface(vec2 uv) {
  vec3 s = sidesAt(uv);
  return mix(range.x, range.y, s.b < 0.5 ? s.r : s.r - s.g);
}
// Colour, share; disparity and distance from the edge.
void behind(vec2 uv, out vec4 light, out vec2 at) {
  vec2 full = vec2(textureSize(behindDepths, 0)), place = uv * full - 0.5, t = fract(place);
  ivec2 first = ivec2(floor(place)), last = ivec2(full) - 1;
  light = vec4(0.0); at = vec2(0.0);
  for (int i = 0; i < 4; i++) {
    ivec2 step_ = ivec2(i & 1, i >> 1), cell = clamp(first + step_, ivec2(0), last);
    vec2 w = mix(1.0 - t, t, vec2(step_));
    vec3 known = texelFetch(behindDepths, cell, 0).rgb;
    float share = w.x * w.y * known.g;
    light += vec4(texelFetch(behindColors, cell, 0).rgb, 1.0) * share;
    at += vec2(known.r * share, known.b * w.x * w.y);
  }
  light.rgb /= max(light.a, 1e-4); at.x /= max(light.a, 1e-4);
}
void main() {
  // What has the pivot's disparity stays.
  vec2 uv = gl_FragCoord.xy / size - shift * pivot, at = uv;
  vec3 s = sidesAt(uv);
  vec4 back; vec2 backAt;
  float moved = length(shift * size);
  if (moved > 0.0) {
    float steps = max(ceil((range.y - range.x) * moved / 0.7), 1.0), step_ = (range.y - range.x) / steps;
    float before = range.y, ray = range.y;
    at = uv + shift * range.x;
    bool bared = false;
    float found = range.x;
    for (float i = 0.0; i <= steps; i++) {
      ray = range.y - step_ * i;
      vec2 place = uv + shift * ray;
      float d = surface(place);
      if (d < ray) { before = ray; continue; }
      if (d - ray > 0.06 + step_) {
        behind(place, back, backAt);
        float far = mix(range.x, range.y, backAt.x);
        if (back.a > 0.5 && far + step_ >= ray) { bared = true; at = place; found = far; break; }
        continue;
      }
      for (int n = 0; n < 4; n++) {
        float middle = (before + ray) / 2.0;
        if (surface(uv + shift * middle) < middle) before = middle; else ray = middle;
      }
      found = (before + ray) / 2.0;
      at = uv + shift * found;
      break;
    }
    seen = bared ? vec4(back.rgb, 1.0) : vec4(textureLod(colors, at, coarse).rgb, 1.0);
    float share = (found - range.x) / max(range.y - range.x, 1e-9);
    s = sidesAt(at);
    // A pixel of the far side keeps what lies before it, which may have stained it: so the last two steps of b say. Where it
    // covers a quarter it surely has, if the two are well apart.
    float covered = min(8.0 * (1.0 - s.b), 2.0) * min(8.0 * s.g, 1.0) / 255.0;
    sides = vec4(share, 0.0, 0.0, 1.0);
    if (!bared && s.b > 0.5) {
      sides = vec4(min(share + s.g, 1.0), min(s.g, 1.0 - share), s.b > 0.99 ? s.b : 1.0 - covered, 1.0);
    }
  } else {
    seen = vec4(textureLod(colors, uv, coarse).rgb, 1.0);
    sides = vec4(s, 1.0);
  }
  if (isDraft > 0.5) { hidden = hiddenAt = vec4(0.0); return; }
  behind(at, back, backAt);
  hidden = back;
  hiddenAt = vec4(backAt, 0.0, 1.0);
}`;

const BLUR = `
uniform vec2 size, range, keepSharp;
uniform vec3 focus;
uniform float gain, curve, highlights;
float ramp(float a, float b, float v) { return smoothstep(a, b, v); }
float blurOf(float share) {
  vec2 place = gl_FragCoord.xy / size - 0.5;
  float away = mix(range.x, range.y, share) - focus.x - dot(focus.yz, place) - curve * dot(place, place) / 0.5;
  return gain * (away - clamp(away, keepSharp.x, keepSharp.y));
}
vec3 recovered(vec3 rgb, float blur) {
  float clipped = ramp(0.85, 1.0, max(rgb.r, max(rgb.g, rgb.b)));
  return rgb * (1.0 + 9.0 * highlights * clipped * ramp(1.0, 8.0, abs(blur)));
}`;

const ENCODED = `
vec4 encoded(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return vec4(mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)), 1.0);
}`;

// Light of each pixel, from its near side and from what goes on behind that: premultiplied, with the slice it lies in.
const PIECES = HEAD + BLUR + `
uniform sampler2D seen, sides, hidden, hiddenAt;
uniform float cells;
const float NEVER = -1000.0;
layout(location = 0) out vec4 near;
layout(location = 1) out vec4 far;
layout(location = 2) out vec4 slices;
float sliceOf(float blur) {
  float b = abs(blur), at = b <= 2.0 ? b : 2.0 + log(b / 2.0) / log(1.3);
  return blur < 0.0 ? -at : at;
}
// The part of a disc that is not the near side's; never less than of the pixel itself.
float beyond(ivec2 at, float blur) {
  float radius = abs(blur) / 2.0;
  int reach = int(ceil(radius + 0.5)) - 1;
  ivec2 last = textureSize(sides, 0) - 1;
  float all = 0.0, part = 0.0;
  for (int y = -reach; y <= reach; y++) for (int x = -reach; x <= reach; x++) {
    float w = clamp(radius + 0.5 - length(vec2(x, y)), 0.0, 1.0);
    vec3 s = texelFetch(sides, clamp(at + ivec2(x, y), ivec2(0), last), 0).rgb;
    all += w;
    part += w * (1.0 - (1.0 - s.b) * (1.0 - ramp(2.5, 5.5, blur - blurOf(s.r))));
  }
  return max(part / max(all, 1e-6), texelFetch(sides, at, 0).b);
}
// The slice before which a pixel's own surface is put, and the most that may be left open then; 1 where all of the lens
// sees it, spread widely.
vec2 ownBefore(ivec2 at, float cover, bool known, float distance_, float blur) {
  bool isRim = known && distance_ <= abs(blur) / 2.0 + 1.5;
  float slice = floor(sliceOf(blur)) - 2.0;
  if (!isRim && (cover <= 0.01 || cover >= 0.99)) return vec2(slice, abs(blur) < 5.7 ? 0.0 : 1.0);
  if (cover <= 0.01 || abs(blur) >= 5.7) return vec2(NEVER, 1.0);
  return vec2(slice, min(beyond(at, blur) + 0.03, 0.99));
}
void put(vec4 n, float nBlur, vec4 f, float fBlur, vec2 own) {
  near = n; far = f; slices = vec4(sliceOf(nBlur), sliceOf(fBlur), own);
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 color = texelFetch(seen, at, 0).rgb, s = texelFetch(sides, at, 0).rgb;
  vec4 back = texelFetch(hidden, at, 0);
  vec2 backAt = texelFetch(hiddenAt, at, 0).rg;
  float cover = 1.0 - s.b, share = back.a;
  bool known = share > 0.02;
  float farOwn = blurOf(s.r - s.g), n = blurOf(s.r), distance_ = (backAt.y * 255.0 - 1.0) * cells;
  vec2 own = ownBefore(at, cover, known, distance_, cover <= 0.01 ? farOwn : n);
  if (cover <= 0.01) {
    // What a blurred near side has left on the far one would stay behind as an outline.
    if (known) color = mix(color, back.rgb, min(cover * 127.5, 1.0) * ramp(1.5, 6.0, abs(n)));
    n = farOwn;
  }
  bool mixed = cover > 0.01 && cover < 0.99;
  float f = mixed ? farOwn : blurOf(backAt.x);
  float apart = ramp(0.4, 1.2, sliceOf(n) - sliceOf(f));
  bool alone = apart <= 0.0 && (!mixed || max(abs(n), abs(f)) < 0.3 || !known);
  if (alone || (!mixed && !known)) { put(vec4(recovered(color, n), 1.0), n, vec4(0.0), 0.0, own); return; }
  if (!mixed) {
    float reach = max(abs(n), abs(f)) / 2.0 + 1.5;
    float part = share * apart * (1.0 - ramp(reach, 1.5 * reach + 4.0, distance_));
    put(vec4(recovered(color, n), 1.0), n, vec4(recovered(back.rgb, f) * part, part), f, own);
    return;
  }
  float sure = known ? share * apart : 0.0;
  vec3 rgb = known ? back.rgb : vec3(0.0), part = (color + 0.004) / (rgb + 0.004);
  cover = max(cover, sure * max(1.0 - 1.5 * min(part.r, min(part.g, part.b)), 0.0));
  vec3 unmixed = clamp(color - (1.0 - cover) * rgb, vec3(0.0), min(vec3(cover), color));
  vec3 lit = cover * color + (unmixed - cover * color) * sure;
  put(vec4(lit, cover), n, vec4(color - lit + cover * sure * rgb, 1.0 - cover + cover * sure), f, own);
}`;

const SLICE = HEAD + `
uniform sampler2D near, far, slices;
uniform float slice;
out vec4 light;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec2 share = clamp(1.0 - abs(texelFetch(slices, at, 0).rg - slice), 0.0, 1.0);
  light = vec4(0.0);
  if (share.x > 0.0) light += share.x * texelFetch(near, at, 0);
  if (share.y > 0.0) light += share.y * texelFetch(far, at, 0);
}`;

// A slice through the round lens, on a coarser level where it is spread widely, put behind what is nearer.
const SPREAD = HEAD + `
uniform sampler2D light, front, slices;
uniform vec2 size;
uniform float radius, level, empty, slice;
out vec4 result;
// Covers a pixel up to what may be left open, or where its own surface has left next to nothing.
vec4 closed(vec4 before, float open) {
  if (before.a <= 0.0 || before.a >= (open < 1.0 ? 1.0 : 0.2)) return before;
  float kept = open < 1.0 ? min(before.a, open) : before.a * smoothstep(0.05, 0.2, before.a);
  return vec4(before.rgb * (1.0 - kept) / (1.0 - before.a), kept);
}
void main() {
  vec4 before = texelFetch(front, ivec2(gl_FragCoord.xy), 0), sum = vec4(0.0);
  vec2 own = texelFetch(slices, ivec2(gl_FragCoord.xy), 0).ba;
  if (own.x == slice) before = closed(before, own.y);
  vec2 uv = gl_FragCoord.xy / size;
  result = before;
  if (before.a <= 0.0 || textureLod(light, uv, empty).a <= 0.0) return;
  if (radius <= 0.0) {
    sum = texelFetch(light, ivec2(gl_FragCoord.xy), 0);
  } else {
    float whole = 0.0, reach = ceil(radius), cell = exp2(level);
    for (float y = -reach; y <= reach; y++) for (float x = -reach; x <= reach; x++) {
      float w = clamp(radius + 0.5 - length(vec2(x, y)), 0.0, 1.0);
      if (w <= 0.0) continue;
      whole += w;
      sum += w * textureLod(light, uv + vec2(x, y) * cell / size, level);
    }
    sum /= whole;
  }
  if (sum.a <= 1e-5) return;
  float closed = sum.a < 0.8 ? sum.a : min(sum.a + 0.015 * min((sum.a - 0.8) * 10.0, 1.0), 1.0);
  float share = min(closed, before.a);
  result = before + vec4(max(sum.rgb, 0.0) * share / sum.a, -share);
}`;

// For drafts: light and blur of each pixel's own surface,
const SPOTS = HEAD + BLUR + `
uniform sampler2D seen, sides;
uniform float widest;
out vec4 spot;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 s = texelFetch(sides, at, 0).rgb;
  float blur = blurOf(s.b < 0.5 ? s.r : s.r - s.g);
  spot = vec4(sqrt(recovered(texelFetch(seen, at, 0).rgb, blur) / (1.0 + 9.0 * highlights)), 0.5 + 0.5 * blur / widest);
}`;

// gathered at once from where discs may come from; what lies behind does not spread over what is nearer.
const GATHER = HEAD + ENCODED + `
uniform sampler2D spots;
uniform vec2 size;
uniform float widest, brightest;
out vec4 shown;
const float TAPS = 14.0;
vec4 spot(vec2 uv, float level) {
  vec4 s = textureLod(spots, uv, level);
  return vec4(s.rgb * s.rgb, abs(s.a - 0.5) < 0.003 ? 0.0 : (s.a - 0.5) * 2.0 * widest);
}
void main() {
  vec2 uv = vec2(gl_FragCoord.x, size.y - gl_FragCoord.y) / size;
  vec4 own = spot(uv, 0.0);
  float around = abs(own.a), level = max(log2(widest) - 1.0, 0.0);
  for (int i = 0; i < 4; i++) {
    vec2 away = vec2(i & 1, i >> 1) - 0.5;
    around = max(around, spot(uv + away * widest * 0.7 / size, level).a);
  }
  float reach = around / 2.0, apart = 1.8 * reach / sqrt(TAPS);
  float self = max(abs(own.a) / 2.0, 0.5), part = reach * reach / TAPS, whole = min(part / (self * self), 1.0);
  if (reach <= 0.5) whole = 1.0;
  vec3 sum = own.rgb * whole;
  vec2 turn = vec2(1.0, 0.0);
  if (reach > 0.5) for (float i = 0.5; i < TAPS; i++) {
    // By the golden angle.
    turn = mat2(-0.73737, 0.67549, -0.67549, -0.73737) * turn;
    float r = reach * sqrt(i / TAPS);
    vec4 tap = spot(uv + r * turn / size, log2(max(apart, 1.0)));
    float disc = max((tap.a > own.a ? abs(tap.a) : min(abs(tap.a), abs(own.a))) / 2.0, 0.5);
    float w = clamp((disc - r) / apart + 0.5, 0.0, 1.0) * min(part / (disc * disc), 1.0);
    sum += w * tap.rgb;
    whole += w;
  }
  shown = encoded(brightest * sum / whole);
}`;

const SHOW = HEAD + ENCODED + `
uniform sampler2D front;
uniform vec2 size;
uniform float isLight;
out vec4 shown;
void main() {
  vec2 uv = gl_FragCoord.xy / size;
  vec4 p = textureLod(front, vec2(uv.x, 1.0 - uv.y), 0.0);
  vec3 c = isLight > 0.5 ? p.rgb : p.rgb / max(1.0 - p.a, 1e-4);
  shown = encoded(c);
}`;

function renderer(canvas, images, scene) {
  const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true });
  if (!gl) return null;
  if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float")) return null;
  const LIGHT = gl.RGBA16F;
  const compiled = (fragment) => {
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, CORNERS], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "shader");
    return { program, at: (name) => gl.getUniformLocation(program, name) };
  };
  const [view, pieces, slice, spread, show, spots, gather] = [VIEW, PIECES, SLICE, SPREAD, SHOW, SPOTS, GATHER].map(compiled);
  const texture = (filter) => {
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter === gl.NEAREST ? gl.NEAREST : gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return made;
  };
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
  const loaded = (image, format, filter) => {
    const made = texture(filter);
    gl.texImage2D(gl.TEXTURE_2D, 0, format, gl.RGBA, gl.UNSIGNED_BYTE, image);
    if (filter === gl.LINEAR_MIPMAP_LINEAR) gl.generateMipmap(gl.TEXTURE_2D);
    return made;
  };
  const source = [
    loaded(images.colors, gl.SRGB8_ALPHA8, gl.LINEAR_MIPMAP_LINEAR), loaded(images.depths, gl.RGBA8, gl.NEAREST),
    loaded(images.behindColors, gl.SRGB8_ALPHA8, gl.NEAREST), loaded(images.behindDepths, gl.RGBA8, gl.NEAREST),
  ];
  gl.bindVertexArray(gl.createVertexArray());
  const target = (size, formats) => {
    const textures = formats.map(([format, filter]) => {
      const made = texture(filter);
      const levels = filter === gl.LINEAR_MIPMAP_LINEAR || filter === gl.LINEAR_MIPMAP_NEAREST ? Math.floor(Math.log2(Math.max(...size))) + 1 : 1;
      gl.texStorage2D(gl.TEXTURE_2D, levels, format, size[0], size[1]);
      return made;
    });
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    textures.forEach((made, i) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, made, 0));
    gl.drawBuffers(textures.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
    return { frame, textures, size };
  };
  const dropped = (made) => { made.textures.forEach((t) => gl.deleteTexture(t)); gl.deleteFramebuffer(made.frame); };
  // The targets of two sizes at most: at rest, and while something moves.
  const kept = new Map();
  const targets = (size) => {
    const key = size.join();
    if (!kept.has(key)) {
      if (kept.size > 1) { const [old] = kept.keys(); Object.values(kept.get(old)).forEach(dropped); kept.delete(old); }
      const plain = (format, count) => Array(count).fill([format, gl.NEAREST]);
      kept.set(key, {
        view: target(size, [[gl.SRGB8_ALPHA8, gl.LINEAR], ...plain(gl.RGBA8, 1), ...plain(gl.SRGB8_ALPHA8, 1), ...plain(gl.RGBA8, 1)]),
        pieces: target(size, plain(LIGHT, 3)),
        slice: target(size, [[LIGHT, gl.LINEAR_MIPMAP_LINEAR]]), spots: target(size, [[gl.RGBA8, gl.LINEAR_MIPMAP_NEAREST]]),
        front: target(size, [[LIGHT, gl.LINEAR]]), other: target(size, [[LIGHT, gl.LINEAR]]),
      });
    }
    return kept.get(key);
  };
  const draw = (what, to, inputs, values) => {
    gl.bindFramebuffer(gl.FRAMEBUFFER, to ? to.frame : null);
    const size = to ? to.size : [canvas.width, canvas.height];
    gl.viewport(0, 0, size[0], size[1]);
    gl.useProgram(what.program);
    inputs.forEach(([name, made], i) => {
      gl.activeTexture(gl.TEXTURE0 + i);
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.uniform1i(what.at(name), i);
    });
    for (const [name, value] of Object.entries({ size, ...values })) {
      const at = what.at(name);
      if (typeof value === "number") gl.uniform1f(at, value);
      else if (value.length === 2) gl.uniform2fv(at, value);
      else gl.uniform3fv(at, value);
    }
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  };
  const sliceOf = (blur) => Math.sign(blur) * (Math.abs(blur) <= 2 ? Math.abs(blur) : 2 + Math.log(Math.abs(blur) / 2) / Math.log(1.3));
  const diameterAt = (at) => (Math.abs(at) <= 2 ? Math.abs(at) : 2 * 1.3 ** (Math.abs(at) - 2));
  const named = (names, made) => names.map((name, i) => [name, made[i]]);

  // What all pictures begin with: the view from beside, and how it is blurred. Null where nothing is.
  const begun = (lens, size, isDraft) => {
    const to = targets(size), full = scene.size, range = scene.range, scale = scene.scale * size[0] / full[0];
    const shift = [lens.eye[0] * scale / size[0], lens.eye[1] * scale / size[1]];
    draw(view, to.view, named(["colors", "depths", "behindColors", "behindDepths"], source), {
      shift, range, pivot: scene.pivot, coarse: Math.max(0, Math.log2(full[0] / size[0])), isDraft: Number(isDraft),
    });
    const gain = scale * Math.sqrt(Math.max((28 / lens.fNumber) ** 2 - 1, 0));
    const far = [-0.5, 0.5].flatMap((x) => [-0.5, 0.5].map((y) => scene.tilt[0] * x + scene.tilt[1] * y));
    const ends = far.flatMap((t) => [0, scene.curve].flatMap((c) => range.map((d) => gain * (d - lens.focus - t - c))));
    const lensValues = { range, focus: [lens.focus, ...scene.tilt], gain, keepSharp: scene.keepSharp, curve: scene.curve, highlights: scene.highlights };
    return { to, gain, lensValues, ends: [Math.min(...ends, 0), Math.max(...ends, 0)] };
  };
  const sized = (size) => { if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size; };
  const asSeen = (size, to) => { sized(size); draw(show, null, [["front", to.view.textures[0]]], { isLight: 1 }); };

  // `lens`: fNumber, focus, eye. A draft is drawn at once.
  const draft = (lens, size) => {
    const { to, gain, lensValues, ends } = begun(lens, size, true);
    if (gain === 0) return asSeen(size, to);
    const widest = Math.max(-ends[0], ends[1], 1);
    draw(spots, to.spots, named(["seen", "sides"], to.view.textures), { ...lensValues, widest });
    gl.bindTexture(gl.TEXTURE_2D, to.spots.textures[0]);
    gl.generateMipmap(gl.TEXTURE_2D);
    sized(size);
    draw(gather, null, [["spots", to.spots.textures[0]]], { widest, brightest: 1 + 9 * scene.highlights });
  };

  // The whole picture, slice by slice: the canvas changes when all are there. `ACROSS`: cells of the widest discs.
  const ACROSS = 10;
  function* picture(lens, size) {
    const { to, gain, lensValues, ends } = begun(lens, size, false);
    if (gain === 0) return asSeen(size, to);
    draw(pieces, to.pieces, named(["seen", "sides", "hidden", "hiddenAt"], to.view.textures), { ...lensValues, cells: size[0] / scene.behindSize[0] });
    const [first, last] = [Math.floor(sliceOf(ends[0])), Math.ceil(sliceOf(ends[1]))];
    let [front, other] = [to.front, to.other];
    gl.bindFramebuffer(gl.FRAMEBUFFER, front.frame);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    for (let i = last; i >= first; i--) {
      yield;
      const diameter = diameterAt(i);
      draw(slice, to.slice, named(["near", "far", "slices"], to.pieces.textures), { slice: i });
      gl.bindTexture(gl.TEXTURE_2D, to.slice.textures[0]);
      gl.generateMipmap(gl.TEXTURE_2D);
      const level = Math.max(0, Math.ceil(Math.log2(diameter / ACROSS))), cell = 2 ** level;
      const own = Math.sqrt(Math.max(diameter ** 2 - 4 * (cell * cell - 1), 0)) / cell;
      draw(spread, other, [["light", to.slice.textures[0]], ["front", front.textures[0]], ["slices", to.pieces.textures[2]]], {
        slice: i,
        radius: diameter < 0.3 ? 0 : own / 2, level, empty: Math.ceil(Math.log2(Math.max(diameter, 1))),
      });
      [front, other] = [other, front];
    }
    sized(size);
    draw(show, null, [["front", front.textures[0]]], { isLight: 0 });
  }
  return { draft, picture };
}
