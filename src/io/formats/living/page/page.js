// What a person does to the picture: focus, eye, aperture; what is said about it; when it is drawn, and how finely.
(() => {
  const by = (id) => document.getElementById(id);
  const scene = JSON.parse(by("scene").textContent), root = document.documentElement;
  const [canvas, stage, slider] = [by("picture"), by("stage"), by("aperture")];
  const images = { colors: by("colors"), depths: by("depths"), behindColors: by("behind-colors"), behindDepths: by("behind-depths") };
  const [far, near] = scene.range, asked = new URLSearchParams(location.hash.slice(1));
  // The picture alone, at its own size: for frames in other pages.
  const bare = asked.has("bare");
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  const number = (name, otherwise) => (asked.has(name) && isFinite(asked.get(name)) ? Number(asked.get(name)) : otherwise);

  // The lens as it was left; `wanted` is where it goes, `lens` where it is.
  const start = { fNumber: clamp(number("f", scene.fNumber), 1, 28), focus: clamp(number("focus", scene.focus), far, near), eye: [0, 0] };
  start.eye = ["x", "y"].map((name, a) => clamp(number(name, scene.eye[a]), -scene.reach, scene.reach));
  const copy = (lens) => ({ ...lens, eye: [...lens.eye] });
  let wanted = copy(start), lens = copy(start), render = null, depths = null, asking = 0, rested = 0, part = 0.3, last = 0, whole = [1, 1];
  // The picture that is being made, and how many of its slices a frame.
  let refining = null, slices = 1;

  // f/28 … f/1 evenly in stops.
  const stopAt = (share) => 28 ** (1 - share / 100);
  const shareAt = (fNumber) => 100 * (1 - Math.log(fNumber) / Math.log(28));
  const stopName = () => "f/" + (wanted.fNumber < 9.95 ? wanted.fNumber.toFixed(1) : wanted.fNumber.toFixed(0));
  const layerName = (d) => ["far away", "in the back", "in the middle", "in front", "very near"][clamp(Math.floor((d - far) / (near - far || 1) * 5), 0, 4)];
  const say = (text) => { by("spoken").textContent = text; };
  const shown = () => {
    slider.value = shareAt(wanted.fNumber);
    by("stop").textContent = stopName();
    slider.setAttribute("aria-valuetext", stopName());
  };

  // Disparities as numbers, to know what was clicked on.
  const read = () => {
    const flat = document.createElement("canvas");
    [flat.width, flat.height] = scene.size;
    const context = flat.getContext("2d", { willReadFrequently: true });
    context.drawImage(images.depths, 0, 0);
    depths = context.getImageData(0, 0, ...scene.size).data;
  };
  const disparityAt = (x, y) => {
    if (!depths) read();
    const [w, h] = scene.size;
    const at = 4 * (clamp(Math.floor(y * h), 0, h - 1) * w + clamp(Math.floor(x * w), 0, w - 1));
    const share = depths[at + 2] < 128 ? depths[at] : depths[at] - depths[at + 1];
    return far + (near - far) * share / 255;
  };
  const seenAt = (x, y) => {
    const shift = wanted.eye.map((eye, a) => eye * scene.scale / scene.size[a]);
    for (let i = 0; i <= 64; i++) {
      const ray = near - (near - far) * i / 64;
      const away = ray - scene.pivot;
      if (disparityAt(x + shift[0] * away, y + shift[1] * away) >= ray) return ray;
    }
    return far;
  };
  const focusAt = (x, y) => {
    const tilt = scene.tilt[0] * (x - 0.5) + scene.tilt[1] * (y - 0.5);
    const d = seenAt(x, y);
    wanted.focus = clamp(d - tilt, 2 * far - near, 2 * near - far);
    say(`Sharp ${layerName(d)}, at ${Math.round(x * 100)} % from the left, ${Math.round(y * 100)} % from the top`);
    moved();
  };

  // A draft while something moves, as coarse as the device needs; the whole picture when the hand rests.
  const frame = (now) => {
    cancelAnimationFrame(asking);
    asking = 0;
    const speed = matchMedia("(prefers-reduced-motion: reduce)").matches ? 1 : 0.35;
    const towards = (from, to) => (Math.abs(to - from) < 1e-3 * (near - far || 1) ? to : from + (to - from) * speed);
    lens.focus = towards(lens.focus, wanted.focus);
    lens.fNumber = wanted.fNumber;
    lens.eye = [...wanted.eye];
    if (bare || (lens.focus === wanted.focus && now - rested > 200)) {
      refine(now);
      return;
    }
    // Time goes with the pixels; a frame is to take 45 ms. However slow the first ones are, a few more are as they should be.
    if (last && !refining) part = clamp(part * clamp(Math.sqrt(45 / Math.max(now - last, 1)), 0.6, 1.15), 0.1, 1);
    refining = null;
    last = now;
    // In few sizes, so that the memory of the device stays.
    const step = Math.min(1, 1.25 ** Math.round(Math.log(part) / Math.log(1.25)));
    render.draft(lens, whole.map((side) => Math.max(16, Math.round(side * step))));
    asking = requestAnimationFrame(frame);
  };
  // The whole picture, a few slices a frame, so that a device that is slow hears the hand meanwhile.
  const refine = (now) => {
    if (!refining) [refining, slices] = [render.picture(copy(lens), whole), part < 1 ? 1 : 8];
    else slices = now - last < 30 ? 2 * slices : Math.max(1, slices >> 1);
    last = now;
    for (let i = 0; i < slices || bare; i++) {
      if (!refining.next().done) continue;
      [refining, last] = [null, 0];
      return;
    }
    asking = requestAnimationFrame(frame);
  };
  const ask = () => { if (!asking && render) asking = requestAnimationFrame(frame); };
  const moved = () => { rested = performance.now(); shown(); ask(); };

  const fitted = () => {
    const [w, h] = scene.size, dots = window.devicePixelRatio || 1;
    const room = bare ? [w / dots, h / dots] : [stage.clientWidth, stage.clientHeight];
    const scale = Math.min(room[0] / w, room[1] / h);
    [canvas.style.width, canvas.style.height] = [w * scale + "px", h * scale + "px"];
    whole = [w, h].map((side) => Math.max(1, Math.min(side, Math.round(side * scale * dots))));
    moved();
  };
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  const look = (dx, dy) => {
    wanted.eye = [wanted.eye[0] + dx, wanted.eye[1] + dy].map((at) => clamp(at, -scene.reach, scene.reach));
    moved();
  };
  const open = (fNumber) => {
    wanted.fNumber = clamp(fNumber, 1, 28);
    moved();
  };

  const pointers = new Map();
  let dragged = 0, pinched = 0;
  const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (pointers.size === 1) dragged = 0;
    if (pointers.size === 2) [pinched, dragged] = [spread(), 99];
  });
  stage.addEventListener("pointermove", (event) => {
    const from = pointers.get(event.pointerId);
    if (!from) return;
    const by_ = [event.clientX - from[0], event.clientY - from[1]];
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (pointers.size === 2) {
      open(wanted.fNumber * pinched / Math.max(spread(), 1));
      pinched = Math.max(spread(), 1);
      return;
    }
    dragged += Math.abs(by_[0]) + Math.abs(by_[1]);
    if (dragged < 5) return;
    stage.classList.add("dragged");
    const step = 2.5 * scene.reach / Math.max(canvas.clientWidth, canvas.clientHeight, 1);
    look(-by_[0] * step, -by_[1] * step);
  });
  const up = (event) => {
    const known = pointers.delete(event.pointerId);
    if (known && event.type === "pointerup" && dragged < 5 && pointers.size === 0) {
      const [x, y] = place(event);
      if (x >= 0 && x <= 1 && y >= 0 && y <= 1) focusAt(x, y);
    }
    if (!pointers.size) stage.classList.remove("dragged");
  };
  stage.addEventListener("pointerup", up);
  stage.addEventListener("pointercancel", up);
  slider.addEventListener("input", () => open(stopAt(Number(slider.value))));

  const reset = () => { wanted = copy(start); say("As it was"); moved(); };
  const nearer = (share) => {
    wanted.focus = clamp(wanted.focus + share * (near - far), far, near);
    say(`Sharp ${layerName(wanted.focus)}`);
    moved();
  };
  const stop = (by_) => { open(wanted.fNumber * by_); say(`Aperture ${stopName()}`); };
  const turn = (dx, dy) => {
    look(dx * scene.reach / 8, dy * scene.reach / 8);
    const [x, y] = wanted.eye.map((at) => Math.round(100 * at / scene.reach));
    say(`Eye ${Math.abs(x)} % ${x < 0 ? "left" : "right"}, ${Math.abs(y)} % ${y < 0 ? "up" : "down"}`);
  };
  const keys = {
    ArrowLeft: () => turn(-1, 0), ArrowRight: () => turn(1, 0), ArrowUp: () => turn(0, -1), ArrowDown: () => turn(0, 1),
    PageUp: () => nearer(0.1), PageDown: () => nearer(-0.1), "+": () => stop(1 / Math.SQRT2), "=": () => stop(1 / Math.SQRT2),
    "-": () => stop(Math.SQRT2), 0: reset, Home: reset, Enter: () => focusAt(0.5, 0.5), " ": () => focusAt(0.5, 0.5),
  };
  stage.addEventListener("keydown", (event) => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    act();
  });
  by("reset").addEventListener("click", reset);

  // Telephones: the way they are held is the way one looks.
  const tilt = by("tilt");
  let held = null;
  const tilted = (event) => {
    if (event.gamma === null || event.beta === null) return;
    held = held || [event.gamma, event.beta];
    wanted.eye = [event.gamma - held[0], event.beta - held[1]].map((at) => clamp(at / 15, -1, 1) * scene.reach);
    moved();
  };
  if ("DeviceOrientationEvent" in window && matchMedia("(pointer: coarse)").matches) tilt.hidden = false;
  tilt.addEventListener("click", async () => {
    const on = tilt.getAttribute("aria-pressed") !== "true";
    const asks = DeviceOrientationEvent.requestPermission;
    if (on && asks && (await asks.call(DeviceOrientationEvent).catch(() => "denied")) !== "granted") return;
    tilt.setAttribute("aria-pressed", on);
    held = null;
    window[on ? "addEventListener" : "removeEventListener"]("deviceorientation", tilted);
  });

  const begin = () => {
    const whole = Object.values(images).every((image) => image.naturalWidth > 0);
    try {
      render = whole ? renderer(canvas, images, scene) : null;
    } catch (error) {
      console.warn(error);
    }
    if (!render) {
      root.classList.add("still");
      say("This browser shows the picture as a strip, focused from far to near");
      return;
    }
    root.classList.add("alive");
    root.classList.toggle("bare", bare);
    fitted();
    if (bare) frame(0);
    window.addEventListener("resize", fitted);
  };
  canvas.addEventListener("webglcontextlost", () => { render = null; root.classList.replace("alive", "still"); });
  if (document.readyState === "complete") begin(); else window.addEventListener("load", begin);
})();
