// A point for each run in `root` (the element of scatter.html): a quantity over what was varied, or over another one.
function scatterOf(root, study, theme) {
  const [quantity, over, colour, plot, note, whole] = [".quantity", ".over", ".colour", ".chart", ".told", ".whole"].map(name => root.querySelector(name));
  const MOST_DRAWN = 2000, all = [...study.runs.variables.values()], columns = study.data.columns;
  const wanted = all.filter(one => one.component === "wanted"), numbers = all.filter(one => one.component !== "varied");
  const sampled = columns.find(({ dim }) => !study.dims[dim].repeats && !study.data.dims[dim].labels) || columns.find(({ dim }) => study.dims[dim].count > 1 && !study.dims[dim].repeats) || columns[0];
  const option = one => [one.name, one.unit ? `${one.name} [${one.unit}]` : one.name];
  filled(quantity, numbers.filter(one => one.name !== "start_up").map(option), wanted[0].name);
  filled(over, all.map(option), sampled ? sampled.name : wanted[0].name);
  filled(colour, [["", "–"], ...all.map(option)], "");
  let turn = 0, drawnOnce = false, seen = false;

  // A drawing kind that is fast for many points, if the browser has it: some have a part of it, which drawing tells.
  let hasWebgl;
  const fast = () => study.count > MOST_DRAWN && (hasWebgl ??= Boolean(made("canvas").getContext("webgl")));

  async function draw() {
    if (!seen) return;
    const mine = ++turn, names = [quantity.value, over.value, colour.value || over.value];
    const [y, x, c] = await Promise.all(names.map(name => study.runs.numbers(name)));
    if (mine !== turn) return;
    const [Y, X, C] = names.map(name => study.runs.variables.get(name)), colours = theme.colours();
    const [ys, xs, cs] = [Y, X, C].map(one => shownUnit(one.unit, Math.max(Math.abs(one.low), Math.abs(one.high))));
    const good = [], lost = [];
    for (let run = 0; run < study.count; run++) {
      if (Number.isFinite(y[run]) && Number.isFinite(x[run])) good.push(run);
      else if (study.isRun(run)) lost.push(run);
    }
    const points = {
      type: fast() ? "scattergl" : "scatter", mode: "markers", x: good.map(run => xs.scale * x[run]), y: good.map(run => ys.scale * y[run]),
      customdata: good.map(run => [plain(study.runTold(run)), run]),
      hovertemplate: `%{customdata[0]}<br>${titleOf(Y, ys.unit)}: %{y:.5~g}<br>${titleOf(X, xs.unit)}: %{x:.5~g}<extra></extra>`,
      marker: {
        size: good.length > 1000 ? 4 : 6, opacity: good.length > 1000 ? 0.6 : 0.85,
        ...(colour.value ? { color: good.map(run => cs.scale * c[run]), colorscale: "Viridis", showscale: true, colorbar: { title: { text: titleOf(C, cs.unit), side: "right" }, thickness: 14, outlinewidth: 0, ...ticks(C) } } : { color: colours.curves[0] }),
      },
    };
    const marks = lost.filter(run => Number.isFinite(x[run])).map(run => ({
      x: xs.scale * x[run], failed: study.reasons.has(run), points: run,
      text: `${study.runTold(run)}: ${study.reasons.has(run) ? "failed: " + study.reasons.get(run) : "no value"}`,
    }));
    plot.setAttribute("aria-label", `${Y.name} over ${X.name} of ${good.length} runs; the table of numbers has all values`);
    plot.style.height = "420px";
    await Plotly.react(plot, marks.length ? [points, lostMarks(marks, colours)] : [points], plotLayout(colours, {
      height: 420, hovermode: "closest", dragmode: "zoom", margin: { l: 64, r: 16, t: 12, b: 46 },
      xaxis: { title: { text: titleOf(X, xs.unit) }, ...ticks(X) }, yaxis: { title: { text: titleOf(Y, ys.unit) }, ...ticks(Y) }, yaxis2: LOST_AXIS,
    }), { ...PLOT_SETTINGS, doubleClick: "reset" });
    if (plot.querySelector(".no-webgl")) {
      hasWebgl = drawnOnce = false;
      Plotly.purge(plot);
      return draw();
    }
    const failed = lost.filter(run => study.reasons.has(run)).length;
    note.textContent = `${good.length.toLocaleString("en")} runs. ` + (failed ? `${failed.toLocaleString("en")} failed runs are marked ✕ at the bottom. ` : "")
      + (lost.length > failed ? `${(lost.length - failed).toLocaleString("en")} without a value are marked ○. ` : "") + "Drag to zoom, double-click for all; a click chooses the run.";
    if (drawnOnce) return;
    drawnOnce = true;
    plot.on("plotly_click", ({ points: [point] }) => {
      const run = point.customdata[1], places = study.pointsOf(study.dims, run);
      study.choose(study.axes.map(dim => places[dim.k]));
      study.show(run);
    });
  }

  // Names in place of the numbers of texts.
  function ticks(one) {
    return one.items ? { tickvals: Object.values(one.items), ticktext: Object.keys(one.items).map(plain) } : {};
  }

  for (const choice of [quantity, over, colour]) choice.addEventListener("change", draw);
  whole.addEventListener("click", () => drawnOnce && Plotly.relayout(plot, { "xaxis.autorange": true, "yaxis.autorange": true }));
  theme.onChange(draw);
  whenSeen(root, show);
  function show() {
    seen = true;
    return draw();
  }
  return { draw: show, plot };
}

// Runs `action` once when an element comes near to what is seen.
function whenSeen(element, action) {
  new IntersectionObserver((entries, observer) => {
    if (!entries.some(entry => entry.isIntersecting)) return;
    observer.disconnect();
    action();
  }, { rootMargin: "200px" }).observe(element);
}
