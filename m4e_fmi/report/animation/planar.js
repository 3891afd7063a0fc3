// Bodies of the plane: x, z, theta each.
function place([body, x, z], at) {
  if (body < 0) return [x, z];
  const [px, pz, angle] = at[body], c = Math.cos(angle), s = Math.sin(angle);
  return [px + c * x + s * z, pz + c * z - s * x];
}

function path(points, closed) {
  pen.beginPath();
  points.forEach(([x, z], k) => k ? pen.lineTo(x, z) : pen.moveTo(x, z));
  if (closed) pen.closePath();
}

function stroke(points, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width / scale;
  path(points, false);
  pen.stroke();
}

function between(a, b, along, across) {
  const dx = b[0] - a[0], dz = b[1] - a[1], length = Math.hypot(dx, dz) || 1;
  return [a[0] + along * dx - across * dz / length, a[1] + along * dz + across * dx / length];
}

function around(tie, centre) {
  const unit = 0.0085 * data.size, inner = (1.5 + 1.1 * tie.rank) * unit, spring = tie.kind === "torsion_spring";
  const points = [], count = 60;
  for (let k = 0; k <= count; k++) {
    const angle = spring ? 4 * Math.PI * k / count : -2.6 + 2.4 * k / count;
    const radius = spring ? inner + 1.3 * unit * k / count : inner + 0.9 * unit;
    points.push([centre[0] + radius * Math.cos(angle), centre[1] + radius * Math.sin(angle)]);
  }
  stroke(points, tie.colour, 1.5);
}

function drawTie(tie, at) {
  const ends = tie.ends.map(end => place(end, at));
  if (tie.kind.startsWith("torsion")) {
    around(tie, [(ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2]);
    return;
  }
  const width = data.width * data.size, aside = data.spacing * width * tie.rank;
  const [a, b] = [between(...ends, 0, aside), between(...ends, 1, aside)];
  stroke([ends[0], a], tie.colour, 1);
  stroke([b, ends[1]], tie.colour, 1);
  if (tie.kind === "tension_spring") {
    const points = [a, between(a, b, 0.12, 0)];
    for (let k = 0; k < 18; k++) points.push(between(a, b, 0.12 + 0.76 * (k + 0.5) / 18, (k % 2 ? 0.5 : -0.5) * width));
    stroke([...points, between(a, b, 0.88, 0), b], tie.colour, 1.5);
  } else if (tie.kind === "tension_damper") {
    const half = Math.min(0.2, 0.9 * width / (Math.hypot(b[0] - a[0], b[1] - a[1]) || 1)), w = width / 2;
    stroke([a, between(a, b, 0.5, 0)], tie.colour, 1.5);
    stroke([between(a, b, 0.5, 0.75 * w), between(a, b, 0.5, -0.75 * w)], tie.colour, 1.5);
    stroke([[0.5 - half, w], [0.5 + half, w], [0.5 + half, -w], [0.5 - half, -w]].map(p => between(a, b, ...p)), tie.colour, 1.5);
    stroke([between(a, b, 0.5 + half, 0), b], tie.colour, 1.5);
  } else stroke([a, b], tie.colour, 1.5);
}

function drawTrails() {
  const end = Math.floor((time - data.start) / (data.stop - data.start) * (data.frames - 1));
  const first = Math.max(0, end - 150);
  for (const point of data.trails) {
    const points = [];
    for (let k = first; k <= end; k++) {
      points.push(place([0, point[1], point[2]], [frame(k, point[0])]));
    }
    points.push(place(point, posesAt(time)));
    pen.globalAlpha = 0.5;
    stroke(points, data.bodies[point[0]].hue, 1.5);
    pen.globalAlpha = 1;
  }
}

function fill(points, face, edge, width) {
  path(points, true);
  pen.fillStyle = face;
  pen.fill();
  pen.strokeStyle = edge;
  pen.lineWidth = width / scale;
  pen.stroke();
}

function drawJoint(joint, at) {
  const [x, z] = place(joint.at, at), radius = 0.0085 * data.size;
  if (joint.symbol === "sleeve") {
    const turn = joint.from[0] < 0 ? 0 : at[joint.from[0]][2], c = Math.cos(turn), s = Math.sin(turn);
    const [dx, dz] = joint.direction, along = [c * dx + s * dz, c * dz - s * dx];
    fill([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => [
      x + radius * (2.1 * a * along[0] - b * along[1]), z + radius * (2.1 * a * along[1] + b * along[0])]),
      hues.paper, hues.ink, 1.5);
  } else if (joint.symbol === "circle") {
    pen.beginPath();
    pen.arc(x, z, radius, 0, 2 * Math.PI);
    pen.fillStyle = hues.paper;
    pen.fill();
    pen.strokeStyle = hues.ink;
    pen.lineWidth = 1.5 / scale;
    pen.stroke();
  }
}

const drawn = data.bodies.map((_, k) => k).sort((a, b) => data.bodies[a].depth - data.bodies[b].depth);

function paint(at) {
  const wide = data.high[0] - data.low[0], tall = data.high[1] - data.low[1];
  scale = Math.min(view.width / wide, view.height / tall);
  pen.setTransform(scale, 0, 0, -scale,
    view.width / 2 - scale * (data.low[0] + wide / 2), view.height / 2 + scale * (data.low[1] + tall / 2));
  scale /= window.devicePixelRatio || 1;
  pen.lineJoin = pen.lineCap = "round";
  data.ground.forEach(line => stroke(line, hues.grey, 1.2));
  if (trails.checked) drawTrails();
  for (const k of drawn) {
    const body = data.bodies[k];
    pen.globalAlpha = 0.9;
    fill(body.outline.map(([x, z]) => place([k, x, z], at)), body.pale, body.hue, 1.6);
    pen.globalAlpha = 1;
  }
  for (const joint of data.joints) {
    if (joint.slides && joint.from[0] >= 0) stroke([place(joint.from, at), place(joint.at, at)], hues.grey, 1);
  }
  data.ties.forEach(tie => drawTie(tie, at));
  data.joints.forEach(joint => drawJoint(joint, at));
}

function heightOver(width) {
  return (data.high[1] - data.low[1]) / (data.high[0] - data.low[0]) * width;
}

function prepare() {
  for (const body of data.bodies) body.pale = mixed(body.hue, 0.28);
}

function shown() {
  return {};
}
