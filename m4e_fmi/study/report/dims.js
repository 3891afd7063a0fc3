// The numbers of a study: dimensions, runs, and designs (runs of other seeds are one design). Runs and designs are
// numbered with the last dimension first. Returns `at`, the chosen point of each dimension of designs, and
// `choose(at)`, `onChoice(action)`, `onRun(action)`, `show(run)`.
function studyOf(data) {
  const dims = data.dims.map((dim, k) => ({ ...dim, k, labels: dim.labels || Array.from({ length: dim.count }, (_, n) => String(n + 1)) }));
  const axes = dims.filter(dim => !dim.repeats), seeds = dims.filter(dim => dim.repeats);
  const runs = storeOf(data.runs), designs = storeOf(data.designs), listeners = { choice: [], run: [] };
  const reasons = new Map(data.failures.runs.map(([run, k]) => [run, data.failures.texts[k]]));
  const notRun = new Set(data.notRun);
  const size = list => list.reduce((product, dim) => product * dim.count, 1);
  const count = size(dims), copies = size(seeds);

  // Numbers of the points of `list`, one for each of its dimensions, of place `n`.
  function pointsOf(list, n) {
    const found = [];
    for (const dim of [...list].reverse()) {
      found.unshift(n % dim.count);
      n = Math.floor(n / dim.count);
    }
    return found;
  }
  const placeIn = (list, points) => list.reduce((n, dim, k) => n * dim.count + points[k], 0);

  const study = {
    data, dims, axes, seeds, runs, count, copies, designCount: size(axes), at: axes.map(() => 0),
    quantities: data.quantities, reasons, pointsOf,
    place: points => placeIn(axes, points),
    // The runs of the design at `points`, one for each seed.
    runsAt(points) {
      return Array.from({ length: copies }, (_, n) => {
        const own = pointsOf(seeds, n);
        return placeIn(dims, dims.map(dim => dim.repeats ? own[seeds.indexOf(dim)] : points[axes.indexOf(dim)]));
      });
    },
    told: (list, points) => list.map((dim, k) => `${dim.name} ${dim.labels[points[k]]}${dim.unit ? " " + dim.unit : ""}`).join(", ") || "the run",
    runTold: run => study.told(dims, pointsOf(dims, run)),
    // Means of a quantity over seeds, half the widths of their intervals, and numbers of seeds without a value: those of
    // the quantity `of` from which it is computed.
    async design(name, of = "") {
      const found = (kind, one) => designs.variables.has(`${kind} ${one}`) ? designs.numbers(`${kind} ${one}`) : null;
      const [mean, width, missing] = await Promise.all([found("mean", name) || runs.numbers(name), found("width", name), found("missing", of || name)]);
      return { mean, width, missing };
    },
    choose(at) {
      study.at = at;
      for (const action of listeners.choice) action();
    },
    onChoice(action) { listeners.choice.push(action); },
    show(run) { for (const action of listeners.run) action(run); },
    onRun(action) { listeners.run.push(action); },
    // False of a run, or of the design at `points`, that was not made: it has no probability.
    isRun: run => !notRun.has(run),
    isMade: points => !notRun.has(study.runsAt(points)[0]),
    // The first reason for which runs of the design at `points` failed, and their number.
    failuresAt(points) {
      const failed = study.runsAt(points).filter(run => reasons.has(run));
      return { count: failed.length, why: failed.length ? reasons.get(failed[0]) : "" };
    },
  };
  study.madeCount = Array.from({ length: study.designCount }, (_, n) => pointsOf(axes, n)).filter(study.isMade).length;
  return study;
}

// Name and unit of a dimension, a quantity or a variable.
function titleOf(one, unit = one.unit) {
  return plain(unit ? `${one.name} [${unit}]` : one.name);
}

// At most `most` of the points of a dimension for the ticks of an axis.
function ticksOf(dim, most = 14) {
  const step = Math.ceil(dim.count / most), places = [];
  for (let k = 0; k < dim.count; k += step) places.push(k);
  return { tickvals: places, ticktext: places.map(k => plain(dim.labels[k])) };
}

// Values of a quantity with their confidence, for hover texts and readouts.
function valueText(value, width, { unit, scale }) {
  const sign = unit ? " " + unit : "";
  if (!Number.isFinite(value)) return "no value";
  if (!(scale * width > 0)) return `${digits(scale * value)}${sign}`;
  const decimals = Math.min(Math.max(1 - Math.floor(Math.log10(scale * width)), 0), 12);
  return `${(scale * value).toFixed(decimals)} ± ${(scale * width).toFixed(decimals)}${sign}`;
}

function largestOf(values) {
  let largest = 0;
  for (const value of values) if (Math.abs(value) > largest && Number.isFinite(value)) largest = Math.abs(value);
  return largest;
}

// Options of a choice, [value, text] each.
function filled(select, options, chosen) {
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  select.value = chosen;
}
