// The table of all numbers in `root` (the element of numbers.html), a row for each run or design, in pages; sorted by
// a column that is chosen. As CSV it has every row, in the order shown, with all digits.
function tableOf(root, study, name) {
  const [kind, head, body, page, done] = [".rows", "thead tr", "tbody", ".page", ".done"].map(part => root.querySelector(part));
  const ROWS = 100, kinds = study.copies > 1 && study.quantities.length ? [["designs", "designs: means over seeds, ± 95 % confidence"], ["runs", "runs"]] : [["runs", "runs"]];
  filled(kind, kinds, kinds[0][0]);
  let columns = [], order = [], first = 0, sorted = null;

  // Columns of the table: name, unit, and the value of row `n`.
  async function load() {
    const of = async one => ({ name: one.name, unit: one.unit, value: await reader(one) });
    const reader = async one => {
      const values = await study.runs.numbers(one.name), names = one.items && Object.keys(one.items);
      return names ? n => names[values[n]] : n => values[n];
    };
    const all = [...study.runs.variables.values()], varied = all.filter(one => one.component === "varied");
    if (kind.value === "runs") {
      columns = [{ name: "run", unit: "", value: n => n + 1 }, ...await Promise.all(all.map(of)), { name: "failure", unit: "", text: true, value: n => study.reasons.get(n) || "" }];
      order = Array.from({ length: study.count }, (_, n) => n).filter(study.isRun);
    } else {
      const seeds = new Set(study.data.columns.filter(({ dim }) => study.dims[dim].repeats).map(one => one.name));
      const runAt = n => study.runsAt(study.pointsOf(study.axes, n))[0];
      columns = (await Promise.all(varied.filter(one => !seeds.has(one.name)).map(of))).map(one => ({ ...one, value: n => one.value(runAt(n)) }));
      for (const quantity of study.quantities) {
        const { mean, width, missing } = await study.design(quantity.name, quantity.of);
        columns.push({ name: quantity.name, unit: quantity.unit, value: n => mean[n] });
        if (width) columns.push({ name: `± of ${quantity.name}`, unit: quantity.unit, value: n => width[n] });
        if (missing && !quantity.of) columns.push({ name: `runs with ${quantity.name}`, unit: "", value: n => study.copies - missing[n] });
      }
      columns.push({ name: "failed runs", unit: "", value: n => study.failuresAt(study.pointsOf(study.axes, n)).count });
      order = Array.from({ length: study.designCount }, (_, n) => n).filter(n => study.isMade(study.pointsOf(study.axes, n)));
    }
    [first, sorted] = [0, null];
    show();
  }

  const title = one => one.unit ? `${one.name} [${one.unit}]` : one.name;

  function show() {
    head.replaceChildren(...columns.map((one, k) => {
      const state = sorted && sorted.k === k ? (sorted.down ? "descending" : "ascending") : "none";
      const button = made("button", { type: "button", onclick: () => sort(k) }, title(one), { none: "", ascending: " ▲", descending: " ▼" }[state]);
      return made("th", { scope: "col", class: one.text ? "" : "number", "aria-sort": state }, button);
    }));
    body.replaceChildren(...order.slice(first, first + ROWS).map(n => made("tr", {}, ...columns.map(one => {
      const value = one.value(n), odd = typeof value === "number" && !Number.isFinite(value);
      return made("td", { class: one.text ? "" : "number" }, odd ? "–" : typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value));
    }))));
    page.textContent = `rows ${(first + 1).toLocaleString("en")} to ${Math.min(first + ROWS, order.length).toLocaleString("en")} of ${order.length.toLocaleString("en")}`;
  }

  // By a column, first ascending; what is no number comes last.
  function sort(k) {
    const down = Boolean(sorted && sorted.k === k && !sorted.down), { value } = columns[k], sign = down ? -1 : 1;
    const odd = x => x === "" || typeof x === "number" && !Number.isFinite(x);
    order.sort((a, b) => {
      const [x, y] = [value(a), value(b)];
      if (odd(x) || odd(y)) return odd(x) - odd(y) || a - b;
      return sign * (x < y ? -1 : x > y ? 1 : 0) || a - b;
    });
    [first, sorted] = [0, { k, down }];
    show();
    head.querySelectorAll("button")[k].focus();
  }

  function csv() {
    const quoted = value => {
      const formula = typeof value === "string" && /^[=+\-@\t\r]/.test(value);  // of a spreadsheet
      const text = typeof value === "number" && !Number.isFinite(value) ? "" : `${formula ? "'" : ""}${value}`;
      return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    };
    return [columns.map(one => quoted(title(one))), ...order.map(n => columns.map(one => quoted(one.value(n))))].map(row => row.join(",") + "\r\n").join("");
  }

  async function copied(text) {
    try {
      await navigator.clipboard.writeText(text);
      return true;
    } catch {  // pages of files may not, in some browsers
      const area = made("textarea", { "aria-hidden": "true" });
      area.value = text;
      document.body.append(area);
      area.select();
      const well = document.execCommand("copy");
      area.remove();
      return well;
    }
  }

  function move(to) {
    first = Math.min(Math.max(to, 0), Math.floor((order.length - 1) / ROWS) * ROWS);
    show();
  }

  const press = (part, action) => root.querySelector(part).addEventListener("click", action);
  press(".first", () => move(0));
  press(".earlier", () => move(first - ROWS));
  press(".later", () => move(first + ROWS));
  press(".copy", async () => {
    done.textContent = await copied(csv()) ? `${order.length.toLocaleString("en")} rows are copied.` : "The browser does not allow copying: download them.";
  });
  press(".download", () => {
    const address = URL.createObjectURL(new Blob([csv()], { type: "text/csv" })), link = made("a", { href: address, download: `${name}.${kind.value}.csv` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  });
  kind.addEventListener("change", load);
  return { ready: load(), csv };
}
