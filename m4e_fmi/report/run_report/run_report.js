// A report of a run: plots, animation, power flow and spectra, with one time.
async function start(data) {
  const part = name => document.querySelector(name), theme = themeOf(part(".theme")), store = storeOf(data.samples);
  const ready = library();
  await store.ready();
  await ready;
  const plots = historiesOf(part(".histories"), store, theme, data.first);
  chooserOf(part(".histories"), store, plots);
  await plots.ready;
  performance.mark("first plot");
  theme.onChange(() => plots.dress());
  const spectra = spectraOf(part(".spectra"), store, plots, theme, data.ramp);
  const flows = data.flows && flowsOf(part(".flows"), store, plots, theme, data.flows);
  globalThis.report = { plots, store, theme, spectra, flows, player: null };
  if (data.animation) setTimeout(() => animate(data.animation), 0);
  printed(theme, report);
}

// The animation, at rest until it is played: its time and the cursor of the plots are one.
function animate(data) {
  const root = document.querySelector(".animation"), { plots, theme } = report;
  const player = animation(root, data, root);
  let moving = false;
  report.player = player;
  player.play(false);
  player.seek(plots.now);
  player.onTime(time => { if (!moving) plots.seek(time); });
  plots.onTime(time => {
    moving = true;
    player.seek(time);
    moving = false;
  });
  theme.onChange(player.dress);
}

// On paper all is drawn, light, and as wide as the paper.
function printed(theme, report) {
  const charts = () => document.querySelectorAll(".plot, .spectrum, .sankey");
  window.addEventListener("beforeprint", () => {
    theme.as("light");
    report.plots.dress();
    if (report.flows) report.flows.draw();
    report.spectra.draw();
    for (const chart of charts()) if (chart._fullLayout) Plotly.relayout(chart, { width: 660, autosize: false });
  });
  window.addEventListener("afterprint", () => {
    theme.as(theme.wanted());
    for (const chart of charts()) if (chart._fullLayout) Plotly.relayout(chart, { width: null, autosize: true });
    report.plots.dress();
  });
}
