// Plots over time below one another in `root` (the element of histories.html), with one time axis and one cursor.
// `first` are lists of names for the first plots, of which two are in the element `lead`, if there is one. Returns `panels`, `range` [s], `now` [s], `seek(t)`, and
// `onTime(action)`, `onRange(action)`, `onPanels(action)`: actions after the reader moves the cursor, zooms, or changes
// what is shown.
function historiesOf(root, store, theme, first, lead = null) {
  const [from, to, add, stack] = [".from", ".to", ".add", ".panels"].map(name => root.querySelector(name));
  const whole = [store.time[0], store.time.at(-1)], least = (whole[1] - whole[0]) * 1e-6;
  const listeners = { time: [], range: [], panels: [] };
  let range = [...whole];

  const plots = {
    panels: [], whole, now: whole[0], colours: theme.colours(),
    get range() { return range; },
    set range(wanted) {
      const [a, b] = [Math.min(...wanted), Math.max(...wanted)];
      range = [Math.max(whole[0], a), Math.min(whole[1], b)];
      if (!(range[1] - range[0] >= least)) range = [...whole];
      told();
      for (const action of listeners.range) action();
      return Promise.all(plots.panels.map(panel => panel.dress()));
    },
    onTime(action) { listeners.time.push(action); },
    onRange(action) { listeners.range.push(action); },
    onPanels(action) { listeners.panels.push(action); },
    seek, choose, key, open, close, remove, show, replace,
    dress() {
      plots.colours = theme.colours();
      return Promise.all(plots.panels.map(panel => panel.dress()));
    },
  };

  // The cursor at a time, without telling anybody.
  function seek(t) {
    plots.now = Math.min(Math.max(t, whole[0]), whole[1]);
    for (const panel of plots.panels) panel.show();
  }

  // The cursor where the reader wants it.
  function choose(t) {
    seek(t);
    for (const action of listeners.time) action(plots.now);
  }

  function told() {
    from.value = digits(range[0]);
    to.value = digits(range[1]);
  }

  // A new plot of these variables.
  function open(names) {
    const panel = panelOf(store, names, plots);
    plots.panels.push(panel);
    (lead?.children.length < 2 && !stack.children.length ? lead : stack).append(panel.element);
    changed();
    return panel.draw();
  }

  function close(panel) {
    plots.panels.splice(plots.panels.indexOf(panel), 1);
    panel.element.remove();
    if (panel.element.querySelector(".plot")._fullLayout) Plotly.purge(panel.element.querySelector(".plot"));
    changed();
    (stack.querySelector(".plot") || add).focus();
  }

  function remove(panel, name) {
    panel.names = panel.names.filter(other => other !== name);
    return panel.names.length ? replace(panel, panel.names) : close(panel);
  }

  // Shows a variable in the plot `where`, in a new one, or in the first with its unit.
  function show(name, where) {
    const { unit } = store.variables.get(name);
    const alike = panel => panel.names.some(other => store.variables.get(other).unit === unit);
    const panel = where === "unit" ? plots.panels.find(alike) : plots.panels[where];
    if (!panel) return open([name]);
    if (panel.names.includes(name)) return null;
    return replace(panel, [...panel.names, name]);
  }

  // Other variables in a plot.
  function replace(panel, names) {
    panel.names = names;
    changed();
    return panel.draw();
  }

  function changed() {
    for (const panel of plots.panels) if (panel.curves.length) panel.show();
    for (const action of listeners.panels) action();
  }

  const zoom = factor => {
    const middle = plots.now > range[0] && plots.now < range[1] ? plots.now : (range[0] + range[1]) / 2;
    plots.range = range.map(end => middle + factor * (end - middle));
  };
  const pan = share => {
    const span = range[1] - range[0], step = Math.min(Math.max(share * span, whole[0] - range[0]), whole[1] - range[1]);
    plots.range = [range[0] + step, range[1] + step];
  };
  const row = step => {
    const place = Math.round(placeOf(store.time, plots.now)) + step;
    choose(store.time[Math.min(Math.max(place, 0), store.count - 1)]);
  };

  // Keys of a plot: the cursor by rows or by a tenth of what is shown, zoom, and the times shown.
  function key(event) {
    const tenth = (range[1] - range[0]) / 10;
    const actions = {
      ArrowLeft: () => event.shiftKey ? choose(plots.now - tenth) : row(-1),
      ArrowRight: () => event.shiftKey ? choose(plots.now + tenth) : row(1),
      Home: () => choose(range[0]), End: () => choose(range[1]),
      PageUp: () => pan(-0.5), PageDown: () => pan(0.5),
      "+": () => zoom(0.5), "-": () => zoom(2), 0: () => { plots.range = whole; },
    };
    if (!(event.key in actions) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }

  const press = (name, action) => root.querySelector(name).addEventListener("click", action);
  press(".in", () => zoom(0.5));
  press(".out", () => zoom(2));
  press(".back", () => pan(-0.5));
  press(".on", () => pan(0.5));
  press(".whole", () => { plots.range = whole; });
  for (const end of [from, to]) end.addEventListener("change", () => {
    const wanted = [Number(from.value), Number(to.value)];
    plots.range = from.value && to.value && wanted[0] < wanted[1] ? wanted : range;
  });
  told();
  // The first plots one after the other: the reader sees the first as soon as it is there.
  plots.ready = first.reduce((before, names) => before.then(() => open(names)).then(() => {
    performance.mark("plot drawn");
    return new Promise(done => setTimeout(done, 0));
  }), Promise.resolve());
  return plots;
}
