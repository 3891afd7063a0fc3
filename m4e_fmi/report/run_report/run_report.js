// A report of a run: animation, plots, power flow and spectra, with one time.
async function start(data) {
  const part = name => document.querySelector(name), theme = themeOf(part(".theme")), store = storeOf(data.samples);
  const ready = library();
  await store.ready();
  await ready;
  const plots = historiesOf(part(".histories"), store, theme, data.first, part(".first-plots"));
  const player = data.animation && animate(data.animation, plots, theme);
  chooserOf(part(".histories"), store, plots);
  await plots.ready;
  theme.onChange(() => plots.dress());
  const spectra = spectraOf(part(".spectra"), store, plots, theme, data.ramp);
  const flows = data.flows && flowsOf(part(".flows"), store, plots, theme, data.flows);
  globalThis.report = { plots, store, theme, spectra, flows, moves: Boolean(data.animation), player };
  onPaper(theme, spectra.draw, () => plots.dress());
}

// The animation, at rest until it is played: its time and the cursor of the plots are one.
function animate(data, plots, theme) {
  const root = document.querySelector(".animation"), player = animation(root, data, root);
  let moving = false;
  player.play(false);
  player.seek(plots.now);
  player.onTime(time => { if (!moving) plots.seek(time); });
  plots.onTime(time => {
    moving = true;
    player.seek(time);
    moving = false;
  });
  theme.onChange(player.dress);
  const dock = document.querySelector(".dock"), place = document.querySelector(".moved"), free = dock.textContent;
  dock.addEventListener("click", () => {
    const docked = place.classList.toggle("docked");
    dock.setAttribute("aria-pressed", docked);
    dock.textContent = docked ? "Put back" : free;
    player.dress();
  });
  return player;
}
