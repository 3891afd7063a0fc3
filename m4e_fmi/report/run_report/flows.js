// Power between components as a Sankey diagram in `root`, for the times shown in `plots` or the whole run. Each of
// data.flows is { name, source, target, power or energy (names of variables), whole [J] }; an energy is one since the
// start. data.stored are variables with energies that `data.owner` keeps.
function flowsOf(root, store, plots, theme, data) {
  const [diagram, note, shown, rows, caption] = [".sankey", ".told", ".shown", "tbody", "caption"].map(name => root.querySelector(name));
  let seen = false, turn = 0;

  // The integral of values between two times [unit·s], by trapezoids between the rows.
  function integral(values, from, to) {
    const time = store.time, first = placeOf(time, from), last = placeOf(time, to);
    const points = [[from, valueAt(time, values, from)]];
    for (let k = first; k < Math.min(last, time.length); k++) if (time[k] > from) points.push([time[k], values[k]]);
    points.push([to, valueAt(time, values, to)]);
    let sum = 0;
    for (let k = 1; k < points.length; k++) sum += (points[k][0] - points[k - 1][0]) * (points[k][1] + points[k - 1][1]) / 2;
    return sum;
  }

  // Energies [J] of the flows between two times, NaN for one that the rows do not tell.
  async function energies(from, to, whole) {
    return Promise.all(data.flows.map(async flow => {
      if (whole && flow.whole !== null) return flow.whole;
      if (flow.power) return integral(await store.numbers(flow.power), from, to);
      if (!flow.energy) return NaN;
      const values = await store.numbers(flow.energy);
      return valueAt(store.time, values, to) - valueAt(store.time, values, from);
    }));
  }

  async function draw() {
    if (!seen) return;
    const mine = ++turn, [from, to] = shown.checked ? plots.range : plots.whole, span = to - from;
    const whole = from === plots.whole[0] && to === plots.whole[1], found = await energies(from, to, whole);
    if (mine !== turn) return;
    const known = data.flows.map((flow, k) => ({ ...flow, energy: found[k] })).filter(flow => Number.isFinite(flow.energy));
    const links = known.map(flow => ({
      from: flow.energy < 0 ? flow.target : flow.source, to: flow.energy < 0 ? flow.source : flow.target,
      name: flow.name, power: Math.abs(flow.energy) / span,
    }));
    table(links, span);
    const { nodes, more } = remainders(links);
    const source = more.filter(link => link.made).reduce((sum, link) => sum + link.power, 0);
    const sink = more.filter(link => !link.made).reduce((sum, link) => sum + link.power, 0);
    caption.textContent = `Mean power from t = ${digits(from)} to ${digits(to)} s`;
    note.textContent = [
      `Widths are mean powers from t = ${digits(from)} to ${digits(to)} s; each flow points where its mean does.`,
      `Components with one side only are sources (left) or take up power (right); what others give more than they get is released from store or made by a source inside, what they give less is stored or lost. Made or released in all: ${watts(source)}; taken up, stored or lost: ${watts(sink)}.`,
      known.length < data.flows.length ? `${data.flows.length - known.length} connections are left out: forces or velocities were not recorded.` : "",
      whole ? data.balance : `Between rows by trapezoids. ${data.rows}`,
    ].filter(Boolean).join(" ");
    paint(nodes, [...links, ...more]);
  }

  // Nodes of the diagram, and links to what components store or lose, or from what they release or make.
  function remainders(links) {
    const net = new Map(), given = new Set(), taken = new Set(), more = [];
    for (const { from, to, power } of links) {
      net.set(from, (net.get(from) || 0) - power);
      net.set(to, (net.get(to) || 0) + power);
      if (power > 0) given.add(from), taken.add(to);
    }
    const largest = Math.max(0, ...links.map(link => link.power)), nodes = [];
    for (const [name, left] of net) {
      const through = given.has(name) && taken.has(name), size = Math.abs(left);
      const kind = left < 0 ? "gives" : "takes up";
      nodes.push({ name, label: through || !size ? name : `${name}: ${kind} ${watts(size)}` });
      if (!through) more.push({ made: left < 0, power: size, shown: false });
      else if (size > 1e-9 * largest) {
        const other = left < 0 ? `released or made in ${name}` : `stored or lost in ${name}`;
        nodes.push({ name: "remainder " + name, label: `${other}: ${watts(size)}`, pale: true });
        const [from, to] = left < 0 ? ["remainder " + name, name] : [name, "remainder " + name];
        more.push({ made: left < 0, from, to, name: other, power: size, shown: true });
      }
    }
    return { nodes, more };
  }

  function paint(nodes, links) {
    const { colours } = plots, number = new Map(nodes.map((node, k) => [node.name, k]));
    const drawnOnes = links.filter(link => link.shown !== false && link.power > 0);
    diagram.hidden = !drawnOnes.length;
    if (!drawnOnes.length) {
      note.textContent = "No power flows over the connections.";
      return;
    }
    const curves = colours.curves, hue = k => nodes[k].pale ? colours.grey : curves[k % curves.length];
    const half = colour => colour.replace(/^#(..)(..)(..)$/, (_, r, g, b) => `rgba(${[r, g, b].map(c => parseInt(c, 16))},0.4)`);
    Plotly.react(diagram, [{
      type: "sankey", arrangement: "snap", valueformat: ".4~s", valuesuffix: "W",
      node: {
        label: nodes.map(node => plain(node.label)), color: nodes.map((_, k) => hue(k)), pad: 22, thickness: 16,
        line: { width: 0 }, hovertemplate: "%{label}<extra></extra>",
      },
      link: {
        source: drawnOnes.map(link => number.get(link.from)), target: drawnOnes.map(link => number.get(link.to)),
        value: drawnOnes.map(link => link.power), label: drawnOnes.map(link => plain(link.name)),
        color: drawnOnes.map(link => half(hue(number.get(link.from)))),
        hovertemplate: "%{label}<br>%{value}<extra></extra>",
      },
    }], plotLayout(colours, { height: 300, margin: { l: 10, r: 10, t: 16, b: 16 } }), PLOT_SETTINGS);
  }

  function table(links, span) {
    rows.replaceChildren(...links.map(link => made("tr", {}, made("td", {}, link.name), made("td", {}, link.from), made("td", {}, link.to),
      made("td", { class: "number" }, watts(link.power)), made("td", { class: "number" }, shownAs(link.power * span, "J")))));
  }

  function shownAs(value, unit) {
    const { unit: prefixed, scale } = shownUnit(unit, value);
    return `${Number((scale * value).toPrecision(4))} ${prefixed}`;
  }

  function watts(power) { return shownAs(power, "W"); }

  let waiting = 0;
  const soon = () => {
    clearTimeout(waiting);
    waiting = setTimeout(draw, 120);
  };
  shown.addEventListener("change", draw);
  plots.onRange(() => shown.checked && soon());
  theme.onChange(soon);
  new IntersectionObserver((entries, observer) => {
    if (!entries.some(entry => entry.isIntersecting)) return;
    seen = true;
    observer.disconnect();
    draw();
  }, { rootMargin: "200px" }).observe(root);
  return { draw() { seen = true; return draw(); } };
}
