// Bodies in space: x, y, z, and the quaternion of each. The mouse turns the view.
const middle = [0, 1, 2].map(c => (data.low[c] + data.high[c]) / 2);
const radius = Math.hypot(...[0, 1, 2].map(c => data.high[c] - data.low[c])) / 2 || 1;
const first = { turn: -Math.PI / 3, rise: 0.38, zoom: 1.15 };
let eye = { ...first };

function rotated([w, x, y, z], [a, b, c]) {
  const t = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * t[0] + y * t[2] - z * t[1], b + w * t[1] + z * t[0] - x * t[2], c + w * t[2] + x * t[1] - y * t[0]];
}

function place([body, ...point], at) {
  if (body < 0) return point;
  const e = at[body].slice(3), length = Math.hypot(...e) || 1;
  const turned = rotated(e.map(part => part / length), point);
  return turned.map((part, c) => part + at[body][c]);
}

// x and y on the paper, and the distance into it
function flat(point) {
  const [x, y, z] = point.map((part, c) => part - middle[c]);
  const [ct, st, cr, sr] = [Math.cos(eye.turn), Math.sin(eye.turn), Math.cos(eye.rise), Math.sin(eye.rise)];
  const out = ct * x + st * y;
  return [-st * x + ct * y, cr * z - sr * out, -(cr * out + sr * z)];
}

// the same for points of a body, which may be many
function flatOf(body, at) {
  const [o, x, y, z] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]].map(point => flat(place([body, ...point], at)));
  const [i, j, k] = [x, y, z].map(end => end.map((part, c) => part - o[c]));
  return ([a, b, c]) => [
    o[0] + a * i[0] + b * j[0] + c * k[0], o[1] + a * i[1] + b * j[1] + c * k[1], o[2] + a * i[2] + b * j[2] + c * k[2],
  ];
}

function lines(points, colour, width, closed, face) {
  pen.beginPath();
  points.forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y));
  if (closed) {
    pen.closePath();
    pen.fillStyle = face;
    pen.fill();
  }
  pen.strokeStyle = colour;
  pen.lineWidth = width / scale;
  pen.stroke();
}

function drawGround() {
  const [x, y] = middle, step = 2 * radius / 10;
  for (let k = -5; k <= 5; k++) {
    const z = data.ground;
    lines([[x + k * step, y - radius, z], [x + k * step, y + radius, z]].map(flat), "#e6eaee", 1);
    lines([[x - radius, y + k * step, z], [x + radius, y + k * step, z]].map(flat), "#e6eaee", 1);
  }
}

function drawTrails() {
  const end = Math.floor((time - data.start) / (data.stop - data.start) * (data.frames - 1));
  data.bodies.forEach((body, b) => {
    const points = [];
    for (let k = Math.max(0, end - 150); k <= end; k++) points.push(flat(frame(k, b).slice(0, 3)));
    pen.globalAlpha = 0.5;
    if (points.length > 1) lines(points, body.colour, 1.2);
    pen.globalAlpha = 1;
  });
}

function drawAxes() {
  const size = 34 / scale, corner = [-view.width / 2 / shown, -view.height / 2 / shown].map(part => part + 1.6 * size);
  pen.fillStyle = "#7b8794";
  [["X", 0], ["Y", 1], ["Z", 2]].forEach(([name, c]) => {
    const [x, y] = flat(middle.map((part, k) => part + (k === c ? size : 0)));
    lines([corner, [corner[0] + x, corner[1] + y]], "#7b8794", 1.2);
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

// from aslant to ahead
function shadesOf(colour) {
  const parts = [1, 3, 5].map(k => parseInt(colour.slice(k, k + 2), 16));
  return Array.from({ length: 33 }, (_, n) => 0.65 - 0.37 * n / 32).map(share => `rgb(${parts.map(part => Math.round(255 - share * (255 - part)))})`);
}

for (const body of data.bodies) body.shades = shadesOf(body.colour);

let shown = 1;

function paint(at) {
  shown = eye.zoom * Math.min(view.width, view.height) / (2.2 * radius);
  pen.setTransform(shown, 0, 0, -shown, view.width / 2, view.height / 2);
  scale = shown / (window.devicePixelRatio || 1);
  pen.lineJoin = pen.lineCap = "round";
  drawGround();
  if (trails.checked) drawTrails();
  const parts = [];
  data.bodies.forEach((body, b) => {
    const corners = body.vertices.map(flatOf(b, at));
    for (const face of body.faces) parts.push({ points: face.map(k => corners[k]), body, width: body.edged ? 0.8 : 0.5, closed: true });
    const middle = flat(at[b].slice(0, 3));
    for (const end of body.sticks) parts.push({ points: [middle, flat(place([b, ...end], at))], body, width: 2.4 });
  });
  for (const rope of data.ropes) parts.push({ points: rope.map(end => flat(place(end, at))), body: { colour: "#b5452c" }, width: 1.4 });
  for (const part of parts) {
    part.depth = 0;
    for (const point of part.points) part.depth += point[2] / part.points.length;
  }
  parts.sort((a, b) => b.depth - a.depth);
  for (const part of parts) {
    const shade = part.closed && shaded(part.body.shades, part.points);
    pen.globalAlpha = part.closed && part.body.edged ? 0.85 : 1;
    lines(part.points, part.closed && !part.body.edged ? shade : part.body.colour, part.width, part.closed, shade);
    pen.globalAlpha = 1;
  }
  drawJoints(at);
  drawAxes();
}

// never covered: dash-dotted lines about which they turn, lines along which they slide
function drawJoints(at) {
  for (const [start, end, turns] of data.lines) {
    pen.setLineDash(turns ? [7, 3, 2, 3].map(part => part / scale) : []);
    lines([start, end].map(spot => flat(place(spot, at))), "#22303c", 1);
  }
  pen.setLineDash([]);
  for (const [body, x, y, z, square] of data.hinges) {
    const [a, b] = flat(place([body, x, y, z], at)), size = 4 / scale;
    pen.beginPath();
    if (square) pen.rect(a - size, b - size, 2 * size, 2 * size);
    else pen.arc(a, b, size, 0, 2 * Math.PI);
    pen.fillStyle = "#fff";
    pen.fill();
    pen.strokeStyle = "#22303c";
    pen.lineWidth = 1.3 / scale;
    pen.stroke();
  }
}

function heightOver(width) {
  return 0.62 * width;
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

function turn(across, up) {
  eye.turn += across;
  eye.rise = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, eye.rise + up));
  draw();
}

function zoom(factor) {
  eye.zoom = Math.max(0.2, Math.min(20, eye.zoom * factor));
  draw();
}
