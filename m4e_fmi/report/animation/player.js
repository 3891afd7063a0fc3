// An animation in `root`, the element of part.html, of `data`. Keys are heard on `keys` (an element, or the document).
// Returns: `time()` [s], `seek(time)`, `play(true or false)`, `onTime(action)`, which is called with each time shown,
// `dress()`, which takes the colours of the page anew; the `eye`, and what is at a time: `elevation(x, y, t)`, `posesAt(t)`, `cablesAt(t)`.
function animation(root, data, keys) {
"use strict";
const [view, slider, clock, speed, trails, button, whole] = ["view", "slider", "clock", "speed", "trails", "play", "whole"]
  .map(name => root.querySelector("." + name));
const pen = view.getContext("2d"), width = data.constants.length, rows = unpacked(), listeners = [];
let time = data.start, playing = !calm(), last = null, scale = 1, hues = {};

// every number of every frame
function unpacked() {
  const bytes = Uint8Array.from(atob(data.poses), c => c.charCodeAt(0)), count = data.varying.length;
  const packed = new DataView(bytes.buffer), found = new Float64Array(data.frames * width);
  for (let k = 0; k < data.frames; k++) {
    found.set(data.constants, k * width);
    data.varying.forEach((column, i) => {
      found[k * width + column] = data.offsets[i] + data.scales[i] * packed.getUint16(2 * (k * count + i), true);
    });
  }
  return found;
}

// the colour of a body: on dark paper a lighter one
function hueOf(colour) {
  const dark = parseInt(hues.paper.slice(1, 3), 16) < 128;
  const parts = [1, 3, 5].map(k => parseInt(colour.slice(k, k + 2), 16)).map(part => Math.round(dark ? part + 0.45 * (255 - part) : part));
  return "#" + parts.map(part => part.toString(16).padStart(2, "0")).join("");
}

function calm() {
  return window.matchMedia("(prefers-reduced-motion: reduce)").matches;
}

// the numbers of one body in one frame
function frame(k, body) {
  const i = k * width + data.numbers * body;
  return Array.from(rows.subarray(i, i + data.numbers));
}

// all numbers at a time: a curve through the frames, whose slopes are those of their neighbours
function rowAt(t) {
  const exact = (t - data.start) / (data.stop - data.start) * (data.frames - 1);
  const k = Math.max(0, Math.min(Math.floor(exact), data.frames - 2)), s = exact - k, found = new Float64Array(width);
  const [a, b, c, d] = [Math.max(0, k - 1), k, k + 1, Math.min(data.frames - 1, k + 2)].map(n => n * width);
  for (let i = 0; i < width; i++) {
    const p = rows[b + i], q = rows[c + i], before = (q - rows[a + i]) / (a < b ? 2 : 1), after = (rows[d + i] - p) / (d > c ? 2 : 1);
    found[i] = p + s * (before + s * (3 * (q - p) - 2 * before - after + s * (2 * (p - q) + before + after)));
  }
  return found;
}

// those of every body
function posesAt(t) {
  const row = rowAt(t);
  return data.bodies.map((_, b) => Array.from(row.subarray(data.numbers * b, data.numbers * (b + 1))));
}

// a colour between that of the paper (0) and another (1)
function mixed(colour, weight) {
  const [from, to] = [hues.paper, colour].map(hue => [1, 3, 5].map(k => parseInt(hue.slice(k, k + 2), 16)));
  return `rgb(${from.map((part, k) => Math.round(part + weight * (to[k] - part)))})`;
}

// Bodies in space: x, y, z, and the quaternion of each. The mouse turns the view.
const first = { turn: data.turn, rise: data.rise, zoom: 1 };
let eye = { ...first }, middle, corners, size = 1;

function focus([low, high]) {
  middle = [0, 1, 2].map(c => (low[c] + high[c]) / 2);
  corners = [0, 1, 2, 3, 4, 5, 6, 7].map(n => [0, 1, 2].map(c => (n >> c & 1 ? high : low)[c]));
}

// pixels for a metre with which all corners are seen at first
function fitting() {
  const seen = corners.map(corner => flat(corner, first)), most = c => Math.max(...seen.map(place => Math.abs(place[c]))) || 1e-9;
  return (data.water ? 0.36 : 0.46) * Math.min(view.width / most(0), view.height / most(1));
}
focus(data.near);

// where points of a body are, by its quaternion
function placesOf(body, at) {
  const [ox, oy, oz, ...e] = at[body], length = Math.hypot(...e) || 1, [w, x, y, z] = e.map(part => part / length);
  return ([a, b, c]) => {
    const p = 2 * (y * c - z * b), q = 2 * (z * a - x * c), r = 2 * (x * b - y * a);
    return [ox + a + w * p + y * r - z * q, oy + b + w * q + z * p - x * r, oz + c + w * r + x * q - y * p];
  };
}

function place([body, ...point], at) {
  return body < 0 ? point : placesOf(body, at)(point);
}

// x and y on the paper, and the distance into it
function flat(point, from = eye) {
  const [x, y, z] = point.map((part, c) => part - middle[c]);
  const [ct, st, cr, sr] = [Math.cos(from.turn), Math.sin(from.turn), Math.cos(from.rise), Math.sin(from.rise)];
  const out = ct * x + st * y;
  return [-st * x + ct * y, cr * z - sr * out, -(cr * out + sr * z)];
}

function lines(points, colour, width, closed, face) {
  pen.beginPath();
  points.forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y));
  if (closed) {
    pen.closePath();
    pen.fillStyle = face;
    pen.fill();
  }
  if (!width) return;
  pen.strokeStyle = colour;
  pen.lineWidth = width / scale;
  pen.stroke();
}

function drawGround() {
  const [low, high] = data.ground, z = low[2], count = 12;
  const colour = data.water ? hues.bed : hues.line;
  for (let k = 0; k <= count; k++) {
    const [x, y] = [0, 1].map(c => low[c] + (high[c] - low[c]) * k / count);
    lines([[x, low[1], z], [x, high[1], z]].map(point => flat(point)), colour, 1);
    lines([[low[0], y, z], [high[0], y, z]].map(point => flat(point)), colour, 1);
  }
}

function drawTrails() {
  const end = Math.floor((time - data.start) / (data.stop - data.start) * (data.frames - 1));
  data.bodies.forEach((body, b) => {
    const points = [];
    for (let k = Math.max(0, end - 150); k <= end; k++) points.push(flat(frame(k, b).slice(0, 3)));
    pen.globalAlpha = 0.5;
    if (points.length > 1) lines(points, body.hue, 1.2);
    pen.globalAlpha = 1;
  });
}

function drawAxes() {
  const reach = 34 / scale, corner = [-view.width / 2 / size, -view.height / 2 / size].map(part => part + 1.6 * reach);
  pen.fillStyle = hues.grey;
  [["X", 0], ["Y", 1], ["Z", 2]].forEach(([name, c]) => {
    const [x, y] = flat(middle.map((part, k) => part + (k === c ? reach : 0)));
    if (Math.hypot(x, y) < 0.2 * reach) return;
    lines([corner, [corner[0] + x, corner[1] + y]], hues.grey, 1.2);
    pen.save();
    pen.translate(corner[0] + 1.2 * x, corner[1] + 1.2 * y);
    pen.scale(1 / scale, -1 / scale);
    pen.font = "11px system-ui, sans-serif";
    pen.fillText(name, -4, 4);
    pen.restore();
  });
}

// the colour of a face: pale if seen from ahead, darker aslant
function shaded(colours, points) {
  const n = points.length, [p, q, r, s] = [points[0], points[1], points[2], points[n > 3 ? n - 1 : 0]];
  const ax = r[0] - p[0], ay = r[1] - p[1], az = r[2] - p[2], bx = s[0] - q[0], by = s[1] - q[1], bz = s[2] - q[2];
  const x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
  return colours[Math.round((colours.length - 1) * Math.abs(z) / (Math.sqrt(x * x + y * y + z * z) || 1))];
}

// 33 colours from aslant to ahead, or of water from its slopes away from the light to those towards it
function prepare() {
  const shades = (colour, from, to) => Array.from({ length: 33 }, (_, n) => mixed(colour, from + (to - from) * n / 32));
  for (const body of data.bodies) body.shades = shades(body.hue, 0.65, 0.28);
  if (data.water) data.water.shades = shades(hues.water, 0.95, 0.35);
}

// The sea: Airy waves on still water at z = 0. Each is a cos(ωt + φ − k·(x, y)), all of a train times its ramp.
const sea = data.water && data.water.trains.map(train => train.waves.map(([omega, number, amplitude, phase, direction]) => ({
  omega, amplitude, phase, kx: number * Math.cos(direction), ky: number * Math.sin(direction),
})));

function ramp(train, t) {
  return train.ramp ? 0.5 - 0.5 * Math.cos(Math.PI * Math.min(t / train.ramp, 1)) : 1;
}

// height of the water at a place
function elevation(x, y, t) {
  let total = 0;
  sea.forEach((waves, k) => {
    let sum = 0;
    for (const w of waves) sum += w.amplitude * Math.cos(w.omega * t + w.phase - w.kx * x - w.ky * y);
    total += ramp(data.water.trains[k], t) * sum;
  });
  return total;
}

let grid = data.water && gridOf(...data.water.near, ...data.water.cells);

// places of the surface, and what each wave has there when ωt + φ is 0 and a quarter
function gridOf(low, high, nx, ny) {
  const places = [];
  for (let j = 0; j <= ny; j++) for (let i = 0; i <= nx; i++) places.push([0, 1].map(c => low[c] + (high[c] - low[c]) * (c ? j / ny : i / nx)));
  const parts = sea.map(waves => waves.map(w => {
    const angles = places.map(([x, y]) => w.kx * x + w.ky * y);
    return { w, cosines: Float32Array.from(angles, Math.cos), sines: Float32Array.from(angles, Math.sin) };
  }));
  return { places, parts, nx, ny, heights: new Float64Array(places.length) };
}

function raise(t) {
  const { heights, parts } = grid;
  heights.fill(0);
  parts.forEach((train, k) => {
    const factor = ramp(data.water.trains[k], t);
    for (const { w, cosines, sines } of train) {
      const a = factor * w.amplitude * Math.cos(w.omega * t + w.phase), b = factor * w.amplitude * Math.sin(w.omega * t + w.phase);
      for (let n = 0; n < heights.length; n++) heights[n] += a * cosines[n] + b * sines[n];
    }
  });
}

// pieces of the surface, and behind all the two sides of the water that are farther away
function water() {
  raise(time);
  const { places, heights, nx, ny } = grid, colours = data.water.shades, found = [];
  const points = places.map(([x, y], n) => flat([x, y, heights[n]]));
  const at = (i, j) => j * (nx + 1) + i, dx = places[1][0] - places[0][0], dy = places[nx + 1][1] - places[0][1];
  const across = Math.cos(eye.turn) > 0 ? 0 : nx, along = Math.sin(eye.turn) > 0 ? 0 : ny;
  const count = (n, of) => Array.from({ length: n + 1 }, (_, k) => of(k));
  for (const side of [count(ny, j => at(across, j)), count(nx, i => at(i, along))]) {
    const feet = [side[side.length - 1], side[0]].map(n => flat([...places[n], data.water.floor]));
    pen.globalAlpha = 0.12;
    lines([...side.map(n => points[n]), ...feet], hues.water, 0, true, hues.water);
    pen.globalAlpha = 1;
  }
  for (let j = 0; j < ny; j++) for (let i = 0; i < nx; i++) {
    const [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
    const slope = (0.8 * (heights[b] + heights[c] - heights[a] - heights[d]) / dx + 0.6 * (heights[c] + heights[d] - heights[a] - heights[b]) / dy) / 2;
    const colour = colours[Math.round(16 + 16 * Math.max(-1, Math.min(1, slope / data.water.steepest)))];
    found.push({ points: [a, b, c, d].map(n => points[n]), water: true, colour, level: SURFACE });
  }
  return found;
}

// what is drawn first: from above all that is below the surface, then the surface, then all that is above it
const BELOW = 0, SURFACE = 1, ABOVE = 2;

// height of a place above the surface, between the places of the grid
function above([x, y, z]) {
  const { places, heights, nx, ny } = grid, [low, high] = [places[0], places[places.length - 1]];
  const [u, v] = [[x, 0, nx], [y, 1, ny]].map(([part, c, n]) => Math.max(0, Math.min(n - 1e-9, (part - low[c]) / (high[c] - low[c]) * n)));
  const i = Math.floor(u), j = Math.floor(v), s = u - i, t = v - j, n = j * (nx + 1) + i;
  return z - (1 - t) * ((1 - s) * heights[n] + s * heights[n + 1]) - t * ((1 - s) * heights[n + nx + 1] + s * heights[n + nx + 2]);
}

// a polygon, or a line, in its parts below and above the surface
function cut(points, part) {
  if (!data.water) return [{ ...part, points: points.map(point => flat(point)), level: ABOVE }];
  const over = points.map(above), closed = part.closed || points.length > 2;
  const side = sign => {
    const found = [];
    points.forEach((p, k) => {
      const n = (k + 1) % points.length, a = sign * over[k], b = sign * over[n];
      if (a >= 0) found.push(p);
      if ((closed || n) && a * b < 0) found.push(p.map((c, i) => c + (points[n][i] - c) * a / (a - b)));
    });
    return found;
  };
  const least = part.closed ? 3 : 2;
  if (over.every(one => one <= 0)) return [{ ...part, points: points.map(point => flat(point)), level: BELOW }];
  if (over.every(one => one >= 0)) return [{ ...part, points: points.map(point => flat(point)), level: ABOVE }];
  return [[-1, BELOW], [1, ABOVE]].map(([sign, level]) => ({ ...part, points: side(sign).map(point => flat(point)), level })).filter(one => one.points.length >= least);
}

// a spring, a damper or a line between two places of the paper, `aside` of the straight line
function tie([from, to], kind, aside) {
  const dx = to[0] - from[0], dy = to[1] - from[1], length = Math.hypot(dx, dy) || 1, width = 9 / scale;
  const point = (along, across) => [from[0] + along * dx - (across + aside) * width * dy / length, from[1] + along * dy + (across + aside) * width * dx / length];
  const colour = kind.includes("spring") ? "#2a7f62" : kind.includes("damper") ? "#7a4fa3" : hues.rope;
  if (kind === "tension_spring") {
    const turns = Array.from({ length: 18 }, (_, k) => point(0.12 + 0.76 * (k + 0.5) / 18, k % 2 ? 0.5 : -0.5));
    lines([from, point(0, 0), point(0.12, 0), ...turns, point(0.88, 0), point(1, 0), to], colour, 1.4);
  } else if (kind === "tension_damper") {
    const half = Math.min(0.2, 0.9 * width / length);
    lines([from, point(0, 0), point(0.5, 0)], colour, 1.4);
    lines([point(0.5, 0.4), point(0.5, -0.4)], colour, 1.4);
    lines([point(0.5 - half, 0.5), point(0.5 + half, 0.5), point(0.5 + half, -0.5), point(0.5 - half, -0.5)], colour, 1.4);
    lines([point(0.5 + half, 0), point(1, 0), to], colour, 1.4);
  } else if (kind.startsWith("torsion")) around([(from[0] + to[0]) / 2, (from[1] + to[1]) / 2], kind === "torsion_spring", aside, colour);
  else lines([from, to], colour, 1.4);
}

// a spiral, or an arc, about a joint; the place is counted from the inside
function around(centre, spring, place, colour) {
  const unit = 4 / scale, inner = (1.5 + 1.1 * place) * unit, points = [];
  for (let k = 0; k <= 60; k++) {
    const angle = spring ? 4 * Math.PI * k / 60 : -2.6 + 2.4 * k / 60, radius = inner + (spring ? 1.3 * k / 60 : 0.9) * unit;
    points.push([centre[0] + radius * Math.cos(angle), centre[1] + radius * Math.sin(angle)]);
  }
  lines(points, colour, 1.4);
}

// each cable as places from end to end
function cables(row) {
  return data.cables.map(cable => {
    const points = [];
    for (let n = 0; n < cable.count; n++) points.push(Array.from(row.subarray(cable.first + 3 * n, cable.first + 3 * n + 3)));
    return { points, exact: cable.exact };
  });
}

function paint(at) {
  size = eye.zoom * fitting();
  pen.setTransform(size, 0, 0, -size, view.width / 2, view.height / 2);
  scale = size / (window.devicePixelRatio || 1);
  pen.lineJoin = pen.lineCap = "round";
  const row = rowAt(time), parts = data.water ? water() : [];
  if (data.ground) drawGround();
  if (trails.checked) drawTrails();
  data.bodies.forEach((body, b) => {
    const placed = placesOf(b, at), middle = at[b].slice(0, 3);
    for (const surface of body.surfaces) {
      const corners = surface.vertices.map(placed);
      for (const face of surface.faces) parts.push(...cut(face.map(k => corners[k]), { body, edged: surface.edged, closed: true }));
    }
    for (const end of body.sticks) parts.push(...cut([middle, placed(end)], { body, width: 2.4 }));
  });
  for (const rope of data.ropes) {
    const points = rope.ends.map(end => place(end, at)), deep = data.water && points.some(point => above(point) < 0);
    parts.push({ points: points.map(point => flat(point)), rope, level: deep ? BELOW : ABOVE });
  }
  for (const { points, exact } of cables(row)) {
    for (let n = 1; n < points.length; n++) parts.push(...cut([points[n - 1], points[n]], { cable: true, exact }));
  }
  for (const part of parts) {
    part.depth = 0;
    for (const point of part.points) part.depth += point[2] / part.points.length;
  }
  const up = eye.rise < 0 ? -1 : 1;
  parts.sort((a, b) => up * (a.level - b.level) || b.depth - a.depth);
  parts.forEach(drawPart);
  drawJoints(at);
  drawAxes();
}

function drawPart(part) {
  if (part.water) {
    pen.globalAlpha = 0.6;
    lines(part.points, part.colour, 0, true, part.colour);
  } else if (part.rope) tie(part.points, part.rope.kind, part.rope.rank);
  else if (part.cable) {
    if (!part.exact) pen.setLineDash([6 / scale, 4 / scale]);
    lines(part.points, hues.rope, 1.6);
    pen.setLineDash([]);
  } else if (part.closed) {
    const shade = shaded(part.body.shades, part.points);
    pen.globalAlpha = part.edged ? 0.85 : 1;
    lines(part.points, part.edged ? part.body.hue : shade, part.edged ? 0.8 : 0.5, true, shade);
  } else lines(part.points, part.body.hue, part.width);
  pen.globalAlpha = 1;
}

// never covered: dash-dotted lines about which they turn, lines along which they slide
function drawJoints(at) {
  for (const [start, end, turns] of data.lines) {
    pen.setLineDash(turns ? [7, 3, 2, 3].map(part => part / scale) : []);
    lines([start, end].map(spot => flat(place(spot, at))), hues.ink, 1);
  }
  pen.setLineDash([]);
  for (const [body, x, y, z, square] of data.hinges) {
    const [a, b] = flat(place([body, x, y, z], at)), half = 4 / scale;
    pen.beginPath();
    if (square) pen.rect(a - half, b - half, 2 * half, 2 * half);
    else pen.arc(a, b, half, 0, 2 * Math.PI);
    pen.fillStyle = hues.paper;
    pen.fill();
    pen.strokeStyle = hues.ink;
    pen.lineWidth = 1.3 / scale;
    pen.stroke();
  }
}

view.style.cursor = "grab";
view.style.touchAction = "none";
view.tabIndex = 0;
view.setAttribute("aria-label", "drag or arrow keys: turn the view; wheel or + and −: zoom; double click: as at first");
view.addEventListener("pointerdown", event => view.setPointerCapture(event.pointerId));
view.addEventListener("pointermove", event => {
  if (!event.buttons) return;
  turn(-0.01 * event.movementX, 0.01 * event.movementY);
});
view.addEventListener("wheel", event => {
  event.preventDefault();
  zoom(Math.exp(-0.001 * event.deltaY));
}, { passive: false });
view.addEventListener("dblclick", () => { eye = { ...first }; draw(); });
view.addEventListener("keydown", event => {
  const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
  if (event.key in turns) { event.preventDefault(); turn(...turns[event.key]); }
  if (event.key === "+") zoom(1.15);
  if (event.key === "-") zoom(1 / 1.15);
});
root.querySelector(".all").hidden = !data.far;
whole.addEventListener("change", () => {
  const shown = whole.checked ? "far" : "near";
  focus(data[shown]);
  if (data.water) grid = gridOf(...data.water[shown], ...data.water.cells);
  eye.zoom = first.zoom;
  draw();
});

function turn(across, up) {
  eye.turn += across;
  eye.rise = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, eye.rise + up));
  draw();
}

function zoom(factor) {
  eye.zoom = Math.max(0.2, Math.min(20, eye.zoom * factor));
  draw();
}

function draw() {
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, view.width, view.height);
  paint(posesAt(time));
  clock.textContent = time.toFixed(2) + " s";
  for (const action of listeners) action(time);
}

function resize() {
  const wide = view.clientWidth, most = parseFloat(getComputedStyle(view).maxHeight) || Infinity;  // NaN of "none"
  const tall = Math.min(Math.max(0.62 * wide, 240), 0.68 * window.innerHeight, most);
  const dots = window.devicePixelRatio || 1;
  view.style.height = tall + "px";
  view.width = Math.round(dots * wide);
  view.height = Math.round(dots * tall);
  draw();
}

// the colours of the page, which are others in the dark
function dress() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "grey", "line", "paper", "water", "bed", "rope"]) hues[name] = style.getPropertyValue("--" + name).trim();
  for (const body of data.bodies) body.hue = hueOf(body.colour);
  prepare();
  resize();
}

function step(now) {
  if (playing) {
    if (last !== null) time += Number(speed.value) * Math.min(0.1, (now - last) / 1000);
    if (time >= data.stop) time = data.start;
    slider.value = time;
    draw();
  }
  last = now;
  requestAnimationFrame(step);
}

function play(value) {
  playing = value;
  button.textContent = playing ? "Pause" : "Play";
}

function seek(t) {
  play(false);
  time = Math.max(data.start, Math.min(data.stop, t));
  slider.value = time;
  draw();
}

for (const factor of [...new Set([0.1, 0.25, 0.5, 1, 2, 5, 10, data.speed])].sort((a, b) => a - b)) {
  speed.add(new Option(factor + " ×", factor, false, factor === data.speed));
}
for (const body of data.bodies.filter(one => one.name)) {
  const item = document.createElement("li"), chip = document.createElement("span");
  chip.style.background = body.colour;
  item.append(chip, body.name);
  root.querySelector(".legend").append(item);
}
slider.min = data.start;
slider.max = data.stop;
slider.addEventListener("input", () => seek(Number(slider.value)));
button.addEventListener("click", () => play(!playing));
trails.addEventListener("change", draw);
keys.addEventListener("keydown", event => {
  if (event.code === "Space" && !["BUTTON", "SELECT"].includes(event.target.tagName)) { event.preventDefault(); play(!playing); }
});
window.addEventListener("resize", resize);
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", dress);
play(playing);
dress();
requestAnimationFrame(step);
return {
  time: () => time, seek, play, dress, onTime(action) { listeners.push(action); },
  get eye() { return eye; }, elevation, posesAt, cablesAt: t => cables(rowAt(t)),
};
}
