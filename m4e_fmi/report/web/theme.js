// The colours of the page: as the system has them, or as its reader chooses. Returns `onChange(action)`, `name()`,
// `colours()` for plots and `as(name)`, which sets them until the next choice.
function themeOf(choice) {
  const system = window.matchMedia("(prefers-color-scheme: dark)"), listeners = [];
  const wanted = () => choice.value === "auto" ? (system.matches ? "dark" : "light") : choice.value;
  const as = name => {
    if (document.documentElement.dataset.theme === name) return;
    document.documentElement.dataset.theme = name;
    for (const action of listeners) action();
  };
  choice.addEventListener("change", () => as(wanted()));
  system.addEventListener("change", () => as(wanted()));
  as(wanted());
  return {
    as,
    wanted,
    onChange(action) { listeners.push(action); },
    colours() {
      const style = getComputedStyle(document.documentElement), of = name => style.getPropertyValue("--" + name).trim();
      return { ink: of("ink"), grey: of("grey"), line: of("line"), paper: of("paper"), failed: of("cursor"), curves: of("curves").split(/\s+/) };
    },
  };
}

// Layout that all plots share, in the colours of the page.
function plotLayout(colours, more) {
  const axis = { gridcolor: colours.line, zerolinecolor: colours.line, linecolor: colours.grey, tickcolor: colours.grey, automargin: true };
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false, autosize: true,
    font: { color: colours.ink, size: 12, family: "system-ui, sans-serif" },
    hoverlabel: { bgcolor: colours.paper, bordercolor: colours.grey, font: { color: colours.ink } },
    margin: { l: 60, r: 24, t: 8, b: 36 },
    ...more,
    xaxis: { ...axis, ...more.xaxis },
    yaxis: { ...axis, ...more.yaxis },
  };
}

const PLOT_SETTINGS = { displaylogo: false, displayModeBar: false, responsive: true, doubleClick: false };

// Text for plots, which read some tags: those of names are shown as they are.
function plain(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
}
