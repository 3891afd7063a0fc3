// A report of a study: maps, scatter, numbers, and time histories of its runs.
async function start(data) {
  const part = name => document.querySelector(name), theme = themeOf(part(".theme")), study = studyOf(data);
  const ready = library(), title = document.title.replace(/[^\w.-]+/g, "_");
  await ready;
  const quantities = data.quantities.filter(one => !one.of).map(one => one.name), shares = data.quantities.filter(one => one.of).map(one => one.name);
  const maps = part("#results") && mapsOf(part("#results"), study, theme, quantities);
  if (maps) await maps.ready;
  const states = part("#states") && mapsOf(part("#states"), study, theme, shares);
  const scatter = part("#scatter") && scatterOf(part("#scatter"), study, theme);
  const numbers = tableOf(part("#numbers"), study, title);
  const series = data.series && await seriesOf(part, study, theme, data.startUp);
  if (states) await states.ready;
  await numbers.ready;
  onPaper(theme, () => Promise.all([scatter, series && series.spectra].map(one => one && one.draw())), () => series && series.plots.dress());
  globalThis.report = { study, theme, maps, states, scatter, numbers, ...series, moves: false, player: null };
}

async function seriesOf(part, study, theme, startUp) {
  const { samples, names, runs } = study.data.series, store = storeOf(samples), root = part("#histories");
  await store.ready();
  const byUnit = new Map();
  for (const name of names.map(name => `${name}, run ${runs[0] + 1}`)) {
    const { unit } = store.variables.get(name);
    byUnit.set(unit, [...byUnit.get(unit) || [], name]);
  }
  const plots = historiesOf(root.querySelector(".histories"), store, theme, [...byUnit.values()]);
  chooserOf(root.querySelector(".histories"), store, plots);
  await plots.ready;
  theme.onChange(() => plots.dress());
  const chosen = runsOf(root, study, plots), spectra = spectraOf(part(".spectra"), store, plots, theme, startUp, "the start-up");
  return { store, plots, spectra, chosen };
}
