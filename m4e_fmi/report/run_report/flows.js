// Power between components as a Sankey diagram in `root`, for the times shown in `plots` or the whole run. Each of
// data.flows is { name, source, target, power or energy (names of variables), whole [J] }; an energy is one since the
// start. data.stored are names of variables with the kinetic and potential energy of components, by their names.
function flowsOf(root, store, plots, theme, data) {
  const [diagram, note, shown, over, of] = [".sankey", ".told", ".shown", ".over", ".of"].map(name => root.querySelector(name));
  let turn = 0;

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
    const mine = ++turn, [from, to] = shown.checked ? plots.range : plots.whole, span = to - from;
    const whole = from === plots.whole[0] && to === plots.whole[1], found = await energies(from, to, whole);
    const grown = new Map(await Promise.all(Object.entries(data.stored).map(async ([name, variable]) => {
      const values = await store.numbers(variable);
      return [name, valueAt(store.time, values, to) - valueAt(store.time, values, from)];
    })));
    if (mine !== turn) return;
    const known = data.flows.map((flow, k) => ({ ...flow, energy: found[k] })).filter(flow => Number.isFinite(flow.energy));
    const links = known.map(flow => ({
      from: flow.energy < 0 ? flow.target : flow.source, to: flow.energy < 0 ? flow.source : flow.target,
      name: flow.name, power: Math.abs(flow.energy) / span,
    }));
    const { nodes, more, sums } = remainders(links);
    tables(links, sums, grown, span);
    const source = more.filter(link => link.made).reduce((sum, link) => sum + link.power, 0);
    const sink = more.filter(link => !link.made).reduce((sum, link) => sum + link.power, 0);
    note.textContent = [
      `Widths are mean powers from t = ${digits(from)} to ${digits(to)} s; each flow points where its mean does.`,
      `Components that only give or only take are its ends; between them, what a component gives more than it gets is released from store or made in it, what it gives less is stored or lost. In all ${watts(source)} are made or released, and ${watts(sink)} taken up, stored or lost.`,
      known.length < data.flows.length ? `${data.flows.length - known.length} connections are left out: forces or velocities were not recorded.` : "",
      ...changes(sums, grown, source * span),
      whole ? data.balance : `Between rows by trapezoids. ${data.rows}`,
    ].filter(Boolean).join(" ");
    paint(nodes, [...links, ...more]);
  }

  // What is said of energies that components hold at the end and did not at the start, or the other way, if much [J].
  function changes(sums, grown, given) {
    return Array.from(grown).filter(([name, energy]) => sums.has(name) && Math.abs(energy) > 0.02 * given).map(([name, energy]) =>
      `The kinetic and potential energy of ${name} is ${shownAs(Math.abs(energy), "J")} ${energy < 0 ? "lower" : "higher"} at the end of these times than at their start, as it is in another place or at another speed; of longer times this is a smaller share.`);
  }

  // Nodes of the diagram, and links to what components store or lose, or from what they release or make.
  function remainders(links) {
    const sums = new Map(), more = [], nodes = [], largest = Math.max(0, ...links.map(link => link.power));
    for (const { from, to, power } of links) {
      for (const name of [from, to]) if (!sums.has(name)) sums.set(name, { gets: 0, gives: 0 });
      sums.get(from).gives += power;
      sums.get(to).gets += power;
    }
    for (const [name, { gets, gives }] of sums) {
      const through = gets > 0 && gives > 0, left = gets - gives, size = Math.abs(left);
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
    return { nodes, more, sums };
  }

  // A label in three lines where the diagram is narrow, so that those of neighbours stay apart.
  function lines(label) {
    if (diagram.clientWidth >= 640) return plain(label);
    return label.replace(/( in |: )/, "$1\n").replace(/ (?=[\d.]+ \S+$)/, "\n").split("\n").map(plain).join("<br>");
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
        label: nodes.map(node => lines(node.label)), color: nodes.map((_, k) => hue(k)), pad: 22, thickness: 16,
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

  function tables(links, sums, grown, span) {
    const number = text => made("td", { class: "number" }, text);
    over.replaceChildren(...links.map(link => made("tr", {}, made("td", {}, link.name), made("td", {}, link.from), made("td", {}, link.to),
      number(watts(link.power)), number(shownAs(link.power * span, "J")))));
    of.replaceChildren(...Array.from(sums, ([name, { gets, gives }]) => {
      const kept = grown.has(name) ? grown.get(name) / span : NaN;
      const powers = [gets, gives, gets - gives, ...(grown.size ? [kept, gets - gives - kept] : [])];
      return made("tr", {}, made("td", {}, name), ...powers.map(power =>
        number(Number.isFinite(power) ? watts(power) : "not recorded")));
    }));
    for (const head of root.querySelectorAll("th.stored")) head.hidden = !grown.size;
    for (const table of root.querySelectorAll(".table")) table.hidden = !links.length;
  }

  function shownAs(value, unit) {
    const { unit: prefixed, scale } = shownUnit(unit, Math.abs(value));
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
  setTimeout(draw, 0);
  return { draw };
}
