// On paper all plots are drawn, light, and no wider than the paper. `before` draws what was not yet, `after` is called
// when the page is as it was.
function onPaper(theme, before, after) {
  const PAPER = 660, charts = () => [...document.querySelectorAll(".js-plotly-plot")].filter(chart => chart._fullLayout);
  window.addEventListener("beforeprint", () => {
    theme.as("light");
    for (const section of document.querySelectorAll("details.section")) section.open = true;
    before();
    for (const chart of charts()) chart.style.zoom = Math.min(1, PAPER / chart._fullLayout.width);
  });
  window.addEventListener("afterprint", () => {
    theme.as(theme.wanted());
    for (const chart of charts()) chart.style.zoom = "";
    after();
  });
}
