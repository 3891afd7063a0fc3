// An animation in `root`, the element of part.html, of `data`. Keys are heard on `keys` (an element, or the document).
// Returns: `time()` [s], `seek(time)`, `play(true or false)`, `onTime(action)`, which is called with each time shown,
// `dress()`, which takes the colours of the page anew; of models in space also the `eye`, and what is at a time: `elevation(x, y, t)`, `posesAt(t)`, `cablesAt(t)`.
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

"@painter@"

function draw() {
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, view.width, view.height);
  paint(posesAt(time));
  clock.textContent = time.toFixed(2) + " s";
  for (const action of listeners) action(time);
}

function resize() {
  const wide = view.clientWidth, most = parseFloat(getComputedStyle(view).maxHeight) || Infinity;  // NaN of "none"
  const tall = Math.min(Math.max(heightOver(wide), 240), 0.68 * window.innerHeight, most);
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
return Object.assign(shown(), { time: () => time, seek, play, dress, onTime(action) { listeners.push(action); } });
}
