// Runs the script of an animation's page on a canvas that only notes what is drawn.
// Arguments: the page, a time [s]. Prints JSON: what the page holds, and all polygons in the world.
"use strict";
const fs = require("fs");
const text = fs.readFileSync(process.argv[2], "utf8");
const script = text.match(/<script>([\s\S]*)<\/script>/)[1];
const notes = [];
let path = [], frames = [];
const pen = {
  setTransform() {}, setLineDash() {}, rect(x, z) { path = [[x, z]]; }, stroke() {}, save() {}, restore() {}, translate() {}, scale() {}, fillText() {}, clearRect() { notes.length = 0; },
  beginPath() { path = []; }, moveTo(x, z) { path.push([x, z]); }, lineTo(x, z) { path.push([x, z]); },
  closePath() {}, arc(x, z) { path = [[x, z]]; }, fill() { notes.push(path); },
};
const elements = {};
function element(name) {
  elements[name] ??= {
    style: {}, value: "0", checked: true, textContent: "", clientWidth: 900, append() {},
    options: [], add(option) { this.options.push(option); if (option.chosen) this.value = option.value; },
    setAttribute() {}, setPointerCapture() {},
    addEventListener(event, action) { this[event] = action; }, getContext: () => pen,
  };
  return elements[name];
}
const root = { querySelector: name => element(name.slice(1)), documentElement: {} };
global.document = { ...root, querySelector: () => root, createElement: () => element("new"), addEventListener() {} };
global.window = { devicePixelRatio: 1, innerHeight: 800, addEventListener() {}, matchMedia: () => ({ matches: false, addEventListener() {} }) };
global.getComputedStyle = () => ({ getPropertyValue: () => "#ffffff" });
global.Option = class { constructor(label, value, _, chosen) { this.value = value; this.chosen = chosen; } };
global.requestAnimationFrame = action => { frames.push(action); };
global.atob = packed => Buffer.from(packed, "base64").toString("binary");
const wrapped = script.replace(/const player = animation\((.*?), /, "globalThis.page = ").replace(/, document\);\s*$/, "; globalThis.player = animation(document.querySelector(\"\"), page, document);");
(0, eval)(wrapped);
frames[0](0);
frames[0](80); // 80 ms later: it plays
const played = player.time();
elements.slider.value = process.argv[3];
elements.slider.input();
frames[0](1000); // it stands still once the slider was moved
const { poses, ...rest } = page;
console.log(JSON.stringify({ page: rest, polygons: notes, played, time: player.time(),
  button: elements.play.textContent, clock: elements.clock.textContent }));
