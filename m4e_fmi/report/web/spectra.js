// A spectrum of each plot of `plots` in `root`, from the time `start` [s] on, or of the times that are shown. They are
// computed when they come into view. `leftOut` is what is before `start`.
function spectraOf(root, store, plots, theme, start, leftOut = "the ramp of the waves") {
  const [stack, note, shown, logarithmic] = [".panels", ".told", ".shown", ".logarithmic"].map(name => root.querySelector(name));
  let seen = false, waiting = 0;

  function draw() {
    if (!seen) return;
    const { colours } = plots, [from, to] = shown.checked ? plots.range : [start, plots.whole[1]];
    const about = { text: "" };
    const charts = plots.panels.filter(panel => panel.curves.length && panel.curves.some(one => !one.variable.steps));
    stack.replaceChildren();
    for (const panel of charts) {
      const { unit, scale } = panel.unit, plot = made("div", { class: "spectrum", role: "img" });
      const names = panel.curves.map(one => one.variable.name).join(", ");
      const traces = panel.curves.filter(one => !one.variable.steps).map(({ variable, values }, k) => {
        const { frequency, density } = spectrum(values, from, to, about);
        return {
          type: "scatter", mode: "lines", name: plain(variable.name), x: Array.from(frequency.slice(1)), y: Array.from(density.slice(1), d => d * scale * scale),
          line: { color: colours.curves[k % colours.curves.length], width: 1.4 }, hovertemplate: `%{y:.5~g} ${squared(unit)}`,
        };
      });
      const readout = made("ul", { class: "readout" }, ...traces.map((trace, k) => {
        const chip = made("span", { class: "chip" });
        chip.style.background = trace.line.color;
        return made("li", {}, chip, made("span", {}, panel.curves.filter(one => !one.variable.steps)[k].variable.name));
      }));
      plot.setAttribute("aria-label", `spectrum of ${names}`);
      stack.append(made("section", { class: "panel" }, plot, readout));
      Plotly.newPlot(plot, traces, plotLayout(colours, {
        height: 250, hovermode: "x unified", dragmode: "zoom",
        xaxis: { ticksuffix: " Hz", hoverformat: ".5~g", range: frequencies(traces) },
        yaxis: { title: { text: squared(unit) }, type: logarithmic.checked ? "log" : "linear", exponentformat: "power" },
      }), { ...PLOT_SETTINGS, doubleClick: "reset" });
    }
    note.textContent = charts.length ? about.text : "Nothing is shown: choose variables above.";
  }

  // Spectrum of values between two times; tells how it was made.
  function spectrum(values, from, to, about) {
    let last = values.length - 1;
    while (last > 0 && !Number.isFinite(values[last])) last--;  // behind the end of a run
    const even = evenly(store.time, values, from, Math.min(to, store.time[last])), length = segmentOf(even.values.length);
    if (!(length >= 8)) {
      about.text = `From t = ${digits(from)} to ${digits(to)} s there are too few samples for a spectrum.`;
      return { frequency: new Float64Array(0), density: new Float64Array(0) };
    }
    const found = welch(even.values, even.step, length);
    about.text = `From t = ${digits(even.from)} to ${digits(even.to)} s, `
      + (shown.checked ? "the times shown above" : start > plots.whole[0] ? `without ${leftOut} (until ${digits(start)} s)` : `the whole run; ${leftOut} is not known or 0 s`)
      + `: mean of ${found.segments} periodograms (Welch), Hann windows of ${length} samples half over one another, means removed; one-sided, every ${digits(1 / (length * even.step))} Hz`
      + (even.even ? "." : "; the samples are not evenly spaced: linear between them.");
    return found;
  }

  function squared(unit) {
    return unit ? `${/^[A-Za-z°]+$/.test(unit) ? unit : `(${plain(unit)})`}²/Hz` : "1/Hz";
  }

  // Up to the frequency below which 99.9 % of the power of all curves are.
  function frequencies(traces) {
    let most = 0;
    for (const { x, y } of traces) {
      const total = y.reduce((sum, d) => sum + d, 0);
      let sum = 0, k = 0;
      while (k < x.length - 1 && sum < 0.999 * total) sum += y[k++];
      if (Number.isFinite(total)) most = Math.max(most, x[k] || 0);
    }
    return most ? [0, 1.1 * most] : undefined;
  }

  function soon() {
    clearTimeout(waiting);
    waiting = setTimeout(draw, 120);
  }

  plots.onPanels(soon);
  plots.onRange(() => shown.checked && soon());
  theme.onChange(soon);
  for (const box of [shown, logarithmic]) box.addEventListener("change", draw);
  new IntersectionObserver((entries, observer) => {
    if (!entries.some(entry => entry.isIntersecting)) return;
    seen = true;
    observer.disconnect();
    draw();
  }, { rootMargin: "200px" }).observe(root);
  return { draw() { seen = true; draw(); } };
}
