// Heat maps, curves or histograms of the quantities `names` in `root` (the element of maps.html), with one choice of
// dimensions. The chosen design of `study` is that of all of them.
function mapsOf(root, study, theme, names) {
  const [form, across, up, turn, others, ticked, stack] = [".form", ".across", ".up", ".turn", ".others", ".quantities", ".panels"].map(name => root.querySelector(name));
  const FIRST = 4, MOST_CURVES = 8, MOST_WRITTEN = 150, CHOSEN = "#ff9f1c", { axes } = study;
  const long = axes.filter(dim => dim.count > 1), grids = long.filter(dim => dim.numbers || study.data.dims[dim.k].labels);
  const states = grids.filter(dim => dim.state);  // of a scatter diagram: first, as maps of each design
  const chosen = states.length > 1 ? states : grids.length ? grids : long, panels = new Map();

  const forms = [];
  if (long.length > 1) forms.push(["map", "heat maps"]);
  forms.push(["curves", "curves"]);
  if (study.designCount > 1) forms.push(["histogram", "histograms of all designs"]);
  const sampled = grids.length < long.length;  // one point of a sample tells little
  filled(form, forms, sampled ? "histogram" : grids.length > 1 ? "map" : "curves");
  const options = axes.map((dim, k) => [k, dim.name]);
  const rows = chosen.length > 1 ? chosen[0] : null, columns = chosen.length > 1 ? chosen[1] : chosen[0] || axes[0];
  filled(across, options, columns ? axes.indexOf(columns) : "");
  filled(up, [...options, ["", "–"]], rows ? axes.indexOf(rows) : "");

  const view = () => {
    const x = axes[across.value], y = up.value === "" || up.value === across.value ? null : axes[up.value];
    return { kind: form.value === "map" && !y ? "curves" : form.value, x, y };
  };

  // Sliders for dimensions that are not shown.
  function sliders() {
    const { kind, x, y } = view(), histogram = kind === "histogram";
    for (const part of root.querySelectorAll(".along")) part.hidden = histogram || !long.length;
    others.hidden = histogram;
    others.replaceChildren(...axes.map((dim, k) => {
      if (dim === x || dim === y || dim.count < 2) return "";
      const told = made("output"), slider = made("input", { type: "range", min: 0, max: dim.count - 1, step: 1, value: study.at[k], "data-axis": k });
      slider.addEventListener("input", () => study.choose(study.at.map((n, other) => other === k ? Number(slider.value) : n)));
      return made("label", {}, `${dim.name} `, slider, told);
    }));
    root.querySelector(".second").textContent = kind === "curves" ? "A curve for each" : "Up";
    tell();
  }

  // Sliders as the chosen design is now.
  function tell() {
    for (const slider of others.querySelectorAll("input")) {
      const dim = axes[slider.dataset.axis], text = `${dim.labels[study.at[slider.dataset.axis]]} ${dim.unit}`.trim();
      slider.value = study.at[slider.dataset.axis];
      slider.setAttribute("aria-valuetext", text);
      slider.nextElementSibling.textContent = text;
    }
  }

  function open(name) {
    const quantity = study.quantities.find(one => one.name === name);
    const plot = made("div", { class: "chart", tabindex: 0, role: "group" }), readout = made("ul", { class: "readout" });
    const cell = made("p", { class: "cell", role: "status" });
    const title = made("strong", {}, name);
    const element = made("section", { class: "panel", "aria-label": name }, made("div", { class: "head" }, title, made("span", { class: "unit" }, quantity.text)), plot, readout, cell);
    const panel = { quantity, plot, title, readout, cell, element, values: null, drawnOnce: false };
    panels.set(name, panel);
    plot.addEventListener("keydown", key);
    return panel;
  }

  // The panels in the order of the quantities, each as wide as it is now.
  function order() {
    stack.append(...names.filter(name => panels.has(name)).map(name => panels.get(name).element));
    for (const { plot, drawnOnce } of panels.values()) if (drawnOnce) Plotly.Plots.resize(plot);
  }

  async function draw(panel) {
    panel.values ??= await study.design(panel.quantity.name, panel.quantity.of);
    const { kind, x, y } = view(), colours = theme.colours();
    panel.unit = shownUnit(panel.quantity.unit, largestOf(panel.values.mean));
    panel.title.textContent = panel.unit.unit ? `${panel.quantity.name} [${panel.unit.unit}]` : panel.quantity.name;
    const { traces, layout, list } = kind === "histogram" ? histogram(panel, colours) : kind === "map" ? map(panel, x, y, colours) : curves(panel, x, y, colours);
    const what = { map: "heat map", curves: "curves", histogram: "histogram" }[kind];
    const over = kind === "histogram" ? "" : ` over ${[x, y].filter(Boolean).map(dim => dim.name).join(" and ")}`;
    panel.plot.setAttribute("aria-label", `${what} of ${panel.quantity.name}${over}: arrow keys choose a design; the table of numbers has all values`);
    panel.plot.style.height = `${layout.height}px`;
    await Plotly.react(panel.plot, traces, plotLayout(colours, layout), PLOT_SETTINGS);
    performance.mark("plot drawn");
    panel.readout.replaceChildren(...list.map(({ colour, text }) => {
      const chip = made("span", { class: "chip" });
      chip.style.background = colour;
      return made("li", {}, chip, made("span", {}, text));
    }));
    if (!panel.drawnOnce) {
      panel.drawnOnce = true;
      panel.plot.on("plotly_click", ({ points: [point] }) => point.customdata && pick(point.customdata[1]));
    }
    told(panel);
  }

  function pick(points) {
    if (points) study.choose([...points]);
  }

  // The points of the chosen design, with others along the dimensions shown.
  function pointsAt(x, i, y, j) {
    return study.at.map((n, k) => axes[k] === x ? i : axes[k] === y ? j : n);
  }

  // What is known of a design: its value, seeds, failures.
  function state(panel, points) {
    const place = study.place(points), { mean, width, missing } = panel.values, value = mean[place];
    if (!study.isMade(points)) return { value: NaN, width: NaN, failed: 0, lacking: 0, absent: true, text: "not run: it does not occur", points };
    const failed = study.failuresAt(points), lacking = missing ? missing[place] : 0;
    const runs = study.copies > 1 ? `, ${study.copies - lacking} of ${study.copies} runs` : "";
    const why = failed.count ? `; ${failed.count > 1 || study.copies > 1 ? `${failed.count} failed` : "failed"}: ${failed.why}` : "";
    const text = Number.isFinite(value) ? valueText(value, width ? width[place] : NaN, panel.unit) + runs + why : `no value${why || runs && "; not defined"}`;
    return { value, width: width ? width[place] : NaN, failed: failed.count, lacking, text, points };
  }

  function told(panel) {
    const one = state(panel, study.at), { kind, x, y } = view();
    panel.cell.hidden = kind === "histogram";
    panel.cell.textContent = axes.length ? `${study.told(axes, study.at)}: ${one.text}` : one.text;
    if (kind !== "map" || !panel.plot._fullLayout) return;
    const [i, j] = [study.at[axes.indexOf(x)], study.at[axes.indexOf(y)]];
    Plotly.relayout(panel.plot, { shapes: [{ type: "rect", x0: i - 0.5, x1: i + 0.5, y0: j - 0.5, y1: j + 0.5, line: { color: CHOSEN, width: 3 } }] });
  }

  function map(panel, x, y, colours) {
    const cells = [], { scale, unit } = panel.unit, written = x.count * y.count <= MOST_WRITTEN;
    for (let j = 0; j < y.count; j++) cells.push(Array.from({ length: x.count }, (_, i) => state(panel, pointsAt(x, i, y, j))));
    const hover = one => [plain(`${study.told(axes, one.points)}: ${one.text}`), one.points];
    const text = one => Number.isFinite(one.value) ? `${Number((scale * one.value).toPrecision(3))}${one.lacking ? "*" : ""}` : "";
    const empty = cells.flatMap((row, j) => row.map((one, i) => ({ ...one, i, j }))).filter(one => !Number.isFinite(one.value) && !one.absent);
    const marks = (list, symbol, color, name) => ({
      type: "scatter", mode: "markers", name, x: list.map(one => one.i), y: list.map(one => one.j), customdata: list.map(hover),
      hovertemplate: "%{customdata[0]}<extra></extra>", marker: { symbol, color, size: 10, line: { color, width: 2 } },
    });
    const traces = [{
      type: "heatmap", x: Array.from({ length: x.count }, (_, i) => i), y: Array.from({ length: y.count }, (_, j) => j),
      z: cells.map(row => row.map(one => Number.isFinite(one.value) ? scale * one.value : null)), customdata: cells.map(row => row.map(hover)),
      hovertemplate: "%{customdata[0]}<extra></extra>",
      hoverongaps: false, colorscale: "Viridis", xgap: 1, ygap: 1, colorbar: { title: { text: plain(unit) }, thickness: 14, outlinewidth: 0 },
    }];
    if (written) traces.push(writtenOn(cells.flatMap((row, j) => row.map((one, i) => ({ x: i, y: j, value: one.value, text: text(one) })))));
    const partly = cells.flatMap((row, j) => row.map((one, i) => ({ ...one, i, j }))).filter(one => one.lacking && Number.isFinite(one.value));
    if (!written && partly.length) traces.push(marks(partly, "asterisk-open", "#ffffff", "without some seeds"));
    const failed = empty.filter(one => one.failed), undefinedOnes = empty.filter(one => !one.failed);
    if (failed.length) traces.push(marks(failed, "x-thin", colours.failed, "failed"));
    if (undefinedOnes.length) traces.push(marks(undefinedOnes, "circle-open", colours.grey, "not defined"));
    return {
      traces, list: [], layout: {
        height: Math.min(640, Math.max(260, 110 + 30 * y.count)), hovermode: "closest", dragmode: false, margin: { l: 60, r: 10, t: 8, b: 44 },
        xaxis: { title: { text: titleOf(x) }, ...ticksOf(x), range: [-0.5, x.count - 0.5], showgrid: false, zeroline: false, fixedrange: true },
        yaxis: { title: { text: titleOf(y) }, ...ticksOf(y), range: [-0.5, y.count - 0.5], showgrid: false, zeroline: false, fixedrange: true },
      },
    };
  }

  // A curve with its confidence band for each of the first points of `y`.
  function curves(panel, x, y, colours) {
    const { scale, unit } = panel.unit, places = x ? Array.from({ length: x.count }, (_, i) => i) : [0];
    const at = i => x && x.numbers ? x.numbers[i] : i, count = y ? Math.min(y.count, MOST_CURVES) : 1;
    const traces = [], list = [], lost = [];
    for (let j = 0; j < count; j++) {
      const colour = colours.curves[j % colours.curves.length], cells = places.map(i => ({ ...state(panel, pointsAt(x, i, y, j)), i }));
      lost.push(...cells.filter(one => !Number.isFinite(one.value) && !one.absent));
      for (const part of bands(cells)) traces.push({
        type: "scatter", mode: "lines", fill: "toself", line: { width: 0 }, hoverinfo: "skip", fillcolor: faint(colour),
        x: [...part, ...[...part].reverse()].map(one => at(one.i)),
        y: [...part.map(one => scale * (one.value + one.width)), ...[...part].reverse().map(one => scale * (one.value - one.width))],
      });
      const isolated = x && !x.numbers;
      traces.push({
        type: "scatter", mode: isolated ? "markers" : "lines+markers", x: places.map(at), y: cells.map(one => Number.isFinite(one.value) ? scale * one.value : null),
        customdata: cells.map(one => [plain(`${study.told(axes, one.points)}: ${one.text}`), one.points]), hovertemplate: "%{customdata[0]}<extra></extra>",
        line: { color: colour, width: 1.6 }, marker: { color: colour, size: 6, symbol: cells.map(one => one.lacking ? "asterisk-open" : "circle") },
        ...(isolated ? { error_y: { array: cells.map(one => scale * one.width), color: colour } } : {}),
      });
      if (y) list.push({ colour, text: `${y.name} ${y.labels[j]} ${y.unit}` });
    }
    if (y && y.count > count) list.push({ colour: "none", text: `the first ${count} of ${y.count} are shown` });
    if (lost.length) traces.push(lostMarks(lost.map(one => ({ x: at(one.i), failed: one.failed, text: `${study.told(axes, one.points)}: ${one.text}`, points: one.points })), colours));
    return {
      traces, list, layout: {
        height: 320, hovermode: "closest", dragmode: false, margin: { l: 60, r: 16, t: 12, b: 44 },
        xaxis: { title: { text: x ? titleOf(x) : "" }, ...(x && !x.numbers ? ticksOf(x) : {}), fixedrange: true },
        yaxis: { title: { text: plain(unit || panel.quantity.name) }, fixedrange: true }, yaxis2: LOST_AXIS,
      },
    };
  }

  // Stretches of a curve that have a confidence.
  function bands(cells) {
    const found = [[]];
    for (const one of cells) {
      if (Number.isFinite(one.width) && Number.isFinite(one.value)) found.at(-1).push(one);
      else if (found.at(-1).length) found.push([]);
    }
    return found.filter(part => part.length > 1);
  }

  function histogram(panel, colours) {
    const { scale, unit } = panel.unit, values = Array.from(panel.values.mean).filter(Number.isFinite), designs = study.madeCount, lost = designs - values.length;
    return {
      traces: [{
        type: "histogram", x: values.map(value => scale * value), nbinsx: Math.min(60, Math.max(5, Math.round(Math.sqrt(values.length)))),
        marker: { color: colours.curves[0] }, hovertemplate: `%{x} ${plain(unit)}: %{y} designs<extra></extra>`,
      }],
      list: lost ? [{ colour: colours.failed, text: `${lost} of ${designs} designs have no value` }] : [],
      layout: { height: 320, dragmode: false, bargap: 0.04, xaxis: { title: { text: titleOf(panel.quantity, unit) }, fixedrange: true }, yaxis: { title: { text: "designs" }, fixedrange: true } },
    };
  }

  // Keys of a plot: the chosen design along the dimensions shown; Enter shows its first run.
  function key(event) {
    const { kind, x, y } = view();
    if (event.ctrlKey || event.metaKey || event.altKey || kind === "histogram") return;
    const move = (dim, step) => dim && pick(study.at.map((n, k) => axes[k] === dim ? Math.min(Math.max(n + step, 0), dim.count - 1) : n));
    const actions = {
      ArrowLeft: () => move(x, -1), ArrowRight: () => move(x, 1), ArrowUp: () => move(y, 1), ArrowDown: () => move(y, -1),
      Enter: () => study.show(study.runsAt(study.at)[0]),
    };
    if (!(event.key in actions)) return;
    event.preventDefault();
    actions[event.key]();
  }

  const all = () => Promise.all([...panels.values()].map(draw));
  for (const choice of [form, across, up]) choice.addEventListener("change", () => {
    sliders();
    all();
  });
  turn.addEventListener("click", () => {
    if (up.value === "") return;
    [across.value, up.value] = [up.value, across.value];
    all();
  });
  let before = "";
  study.onChoice(() => {
    const { kind, x, y } = view(), fixed = JSON.stringify(study.at.filter((_, k) => axes[k] !== x && axes[k] !== y));
    tell();
    if (fixed === before || kind === "histogram") for (const panel of panels.values()) panel.values && told(panel);
    else all();
    before = fixed;
  });
  ticked.hidden = names.length < 2;
  ticked.append(...names.map((name, k) => {
    const box = made("input", { type: "checkbox", value: name });
    box.checked = k < FIRST;
    box.addEventListener("change", () => {
      if (box.checked) {
        const panel = open(name);
        order();
        return draw(panel);
      }
      const { element, plot } = panels.get(name);
      panels.delete(name);
      element.remove();
      Plotly.purge(plot);
      return order();
    });
    return made("label", {}, box, ` ${name}`);
  }));
  sliders();
  theme.onChange(all);
  const opened = names.slice(0, FIRST).map(open);
  order();
  const ready = opened.reduce((earlier, panel) => earlier.then(() => draw(panel)), Promise.resolve());
  return { ready, draw: all, panels };
}

// Values written on the cells of a map { x, y, value, text }: white on the dark ones of Viridis, black on the others,
// which both are read with a contrast of 4.4 at least.
function writtenOn(list) {
  const known = list.filter(one => Number.isFinite(one.value)), values = known.map(one => one.value);
  const low = Math.min(...values), span = Math.max(...values) - low;
  return {
    type: "scatter", mode: "text", name: "values", hoverinfo: "skip", x: known.map(one => one.x), y: known.map(one => one.y), text: known.map(one => one.text),
    textfont: { color: known.map(one => (span ? (one.value - low) / span : 0.5) < 0.43 ? "#ffffff" : "#000000") },
  };
}

// The axis on which runs without a value are marked, at the bottom of a plot.
const LOST_AXIS = { overlaying: "y", range: [0, 1], visible: false, fixedrange: true };

// Marks at the bottom of a plot of what has no value: { x, failed, text, points }.
function lostMarks(list, colours) {
  return {
    type: "scatter", mode: "markers", name: "failed", yaxis: "y2", x: list.map(one => one.x), y: list.map(() => 0.03), cliponaxis: false,
    customdata: list.map(one => [plain(one.text), one.points]), hovertemplate: "%{customdata[0]}<extra></extra>",
    marker: {
      symbol: list.map(one => one.failed ? "x-thin" : "circle-open"), size: 9, color: list.map(one => one.failed ? colours.failed : colours.grey),
      line: { width: 2, color: list.map(one => one.failed ? colours.failed : colours.grey) },
    },
  };
}

function faint(colour) {
  return colour.replace(/^#(..)(..)(..)$/, (_, r, g, b) => `rgba(${[r, g, b].map(c => parseInt(c, 16))},0.22)`);
}
