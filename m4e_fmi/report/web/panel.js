// An element with attributes, a text, or children.
function made(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

// The unit in which values up to `largest` are shown, and the factor to it: kN for N, degrees for radians.
function shownUnit(unit, largest) {
  if (unit === "rad") return { unit: "°", scale: 180 / Math.PI };
  if (!["N", "W", "J", "Pa", "N.m"].includes(unit)) return { unit, scale: 1 };
  const [factor, prefix] = [[1e9, "G"], [1e6, "M"], [1e3, "k"]].find(([size]) => largest >= size) || [1, ""];
  return { unit: prefix + unit, scale: 1 / factor };
}

function digits(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(5))) : String(value);
}

// One plot over time of the variables `names`; `plots` is what histories.js returns.
function panelOf(store, names, plots) {
  const plot = made("div", { class: "plot", tabindex: 0, role: "slider", "aria-valuemin": store.time[0], "aria-valuemax": store.time.at(-1) });
  const cursor = made("div", { class: "cursor", hidden: true }), readout = made("ul", { class: "readout" }), title = made("strong");
  const close = made("button", { type: "button", onclick: () => plots.close(panel) }, "Remove plot");
  const element = made("section", { class: "panel" }, made("div", { class: "head" }, title, close), plot, readout);
  const panel = { element, names, draw, dress, show, curves: [], unit: { unit: "", scale: 1 } };
  let turn = 0, drawnOnce = false;

  plot.addEventListener("keydown", event => plots.key(event));

  // Decodes what is shown, and draws it; only the last of several calls does.
  async function draw() {
    const mine = ++turn, numbers = await Promise.all(panel.names.map(name => store.numbers(name)));
    if (mine !== turn || !element.isConnected) return;
    const shown = panel.names.map(name => store.variables.get(name));
    const sizes = shown.flatMap(one => [Math.abs(one.low), Math.abs(one.high)]), units = new Set(shown.map(one => one.unit));
    panel.unit = units.size === 1 ? shownUnit(shown[0].unit, Math.max(...sizes)) : { unit: [...units].join(", "), scale: 1 };
    panel.curves = shown.map((variable, k) => ({ variable, values: numbers[k] }));
    list();
    await dress();
  }

  // Draws what was decoded, in the colours and the times that are shown now.
  async function dress() {
    const { colours, range } = plots, { unit, scale } = panel.unit, columns = Math.max(200, plot.clientWidth);
    const traces = panel.curves.map(({ variable, values }, k) => {
      const places = drawn(store.time, values, range[0], range[1], columns);
      return {
        type: "scatter", mode: "lines", name: plain(variable.name), x: places.map(p => store.time[p]),
        y: places.map(p => Number.isFinite(values[p]) ? scale * values[p] : null),
        line: { color: colours.curves[k % colours.curves.length], width: 1.4, shape: variable.steps ? "hv" : "linear" },
        hovertemplate: `%{y:.6~g} ${plain(unit)}`,
      };
    });
    const items = panel.curves.length === 1 && panel.curves[0].variable.items;
    const layout = plotLayout(colours, {
      height: 210, dragmode: "zoom", hovermode: "x unified", hoverdistance: -1,
      xaxis: { range: [...range], ticksuffix: " s", hoverformat: ".6~g", showspikes: false },
      yaxis: {
        fixedrange: true, title: { text: plain(unit) },
        ...(items ? { tickvals: Object.values(items), ticktext: Object.keys(items).map(plain) } : {}),
      },
    });
    await Plotly.react(plot, traces, layout, PLOT_SETTINGS);
    readout.querySelectorAll(".chip").forEach((chip, k) => chip.style.background = colours.curves[k % colours.curves.length]);
    if (!drawnOnce) {
      drawnOnce = true;
      plot.append(cursor);
      plot.on("plotly_relayout", moved => {
        if ("xaxis.range[0]" in moved) plots.range = [moved["xaxis.range[0]"], moved["xaxis.range[1]"]];
      });
      plot.on("plotly_doubleclick", () => plots.range = plots.whole);
      plot.on("plotly_click", told => {
        const axis = plot._fullLayout.xaxis;
        plots.choose(axis.p2l(told.event.clientX - plot.getBoundingClientRect().left - axis._offset));
      });
    }
    show();
  }

  // The list of what is shown, with values at the cursor.
  function list() {
    readout.replaceChildren(...panel.curves.map(({ variable }) => made("li", { title: variable.description },
      made("span", { class: "chip" }), made("span", {}, variable.name), made("output"),
      made("button", { type: "button", "aria-label": `remove ${variable.name} from this plot`, onclick: () => plots.remove(panel, variable.name) }, "×"))));
  }

  // The cursor, and the values where it is.
  function show() {
    const { now } = plots, layout = plot._fullLayout, { unit, scale } = panel.unit, number = plots.panels.indexOf(panel) + 1;
    title.textContent = `Plot ${number}${unit ? " · " + unit : ""}`;
    close.setAttribute("aria-label", `remove plot ${number}`);
    element.setAttribute("aria-label", `Plot ${number}`);
    readout.querySelectorAll("output").forEach((output, k) => {
      const { variable, values } = panel.curves[k], value = valueAt(store.time, values, now, variable.steps);
      const item = variable.items && Object.keys(variable.items).find(name => variable.items[name] === value);
      output.textContent = item ?? `${digits(scale * value)} ${unit}`;
    });
    const told = panel.curves.map(({ variable }, k) => `${variable.name} ${readout.querySelectorAll("output")[k].textContent}`);
    plot.setAttribute("aria-label", `time in plot ${number}: arrow keys move the cursor`);
    plot.setAttribute("aria-valuenow", now);
    plot.setAttribute("aria-valuetext", `${digits(now)} s: ${told.join(", ")}`);
    if (!layout || !layout.xaxis) return;
    cursor.hidden = now < plots.range[0] || now > plots.range[1];
    cursor.style.left = layout.xaxis._offset + layout.xaxis.l2p(now) + "px";
    cursor.style.top = layout.yaxis._offset + "px";
    cursor.style.height = layout.yaxis._length + "px";
  }

  return panel;
}
