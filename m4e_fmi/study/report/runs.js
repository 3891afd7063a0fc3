// The choice of the run whose series the plots of `plots` show.
function runsOf(root, study, plots) {
  const { series } = study.data, [run, before, after, beside, note] = [".run", ".before", ".after", ".beside", ".missing"].map(name => root.querySelector(name));
  const nameOf = (variable, number) => `${variable}, run ${number + 1}`;
  filled(run, series.runs.map(number => [number, `${number + 1}: ${study.runTold(number)}`]), series.runs[0]);

  // Every plot with the series of the chosen run, in place of those of others or beside them.
  function show() {
    const number = Number(run.value), variables = new Set(series.names.map(name => nameOf(name, number)));
    const own = name => nameOf(name.replace(/, run \d+$/, ""), number);
    note.textContent = "";
    if (!plots.panels.length) return variables.forEach(name => plots.show(name, "unit"));
    for (const panel of [...plots.panels]) plots.replace(panel, [...new Set([...beside.checked ? panel.names : [], ...panel.names.map(own)])]);
    return null;
  }

  const move = step => {
    run.selectedIndex = Math.min(Math.max(run.selectedIndex + step, 0), series.runs.length - 1);
    show();
  };
  run.addEventListener("change", show);
  before.addEventListener("click", () => move(-1));
  after.addEventListener("click", () => move(1));
  study.onRun(number => {
    if (series.runs.includes(number)) {
      run.value = number;
      show();
      root.scrollIntoView({ block: "start" });
    } else note.textContent = `This page has no series of run ${number + 1} (${study.runTold(number)}).`;
  });
  return { show };
}
