// The list of all variables by component, with a search; ticked ones are shown in `plots`.
function chooserOf(root, store, plots) {
  const [search, where, found, groups, clear] = [".search", ".where", ".found", ".groups", ".clear"].map(name => root.querySelector(name));
  const MOST = 200, components = new Map();
  for (const one of store.variables.values()) {
    if (!components.has(one.component)) components.set(one.component, []);
    components.get(one.component).push(one);
  }
  let next = null;  // of the next variable: a plot of its own

  function item(one) {
    const box = made("input", { type: "checkbox", value: one.name, onchange: () => toggle(one, box.checked) });
    box.checked = plots.panels.some(panel => panel.names.includes(one.name));
    const stated = one.stated ? ` Stated error: ${one.stated}.` : "";
    return made("li", {}, made("label", { title: `${one.description || one.name}.${stated}` }, box,
      made("span", {}, one.label), made("span", { class: "unit" }, one.unit)));
  }

  function toggle(one, shown) {
    if (shown) plots.show(one.name, next ?? (where.value === "unit" ? "unit" : where.value === "new" ? -1 : Number(where.value)));
    else for (const panel of plots.panels.filter(panel => panel.names.includes(one.name))) plots.remove(panel, one.name);
    next = null;
  }

  // Components with their variables, filled when they are opened; all that match the words of the search.
  function list() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean), sections = [];
    let left = MOST, count = 0;
    for (const [component, members] of components) {
      const matching = members.filter(one => words.every(word => `${one.name} ${one.unit} ${one.description}`.toLowerCase().includes(word)));
      count += matching.length;
      if (!matching.length) continue;
      const items = made("ul"), section = made("details", {}, made("summary", {}, `${component} (${matching.length})`), items);
      const fill = most => items.replaceChildren(...matching.slice(0, most).map(item));
      if (words.length) {
        fill(left);
        left -= items.children.length;
        section.open = true;
      } else section.addEventListener("toggle", () => section.open && !items.children.length && fill(matching.length));
      sections.push(section);
    }
    groups.replaceChildren(...sections);
    found.hidden = !words.length;
    found.textContent = `${count} found${count > MOST ? `, the first ${MOST} are listed` : ""}`;
  }

  // Ticks and targets as the plots are now.
  function mark() {
    for (const box of groups.querySelectorAll("input")) box.checked = plots.panels.some(panel => panel.names.includes(box.value));
    const wanted = where.value || "unit";
    where.replaceChildren(new Option("the plot with its unit", "unit"), new Option("a new plot", "new"),
      ...plots.panels.map((_, k) => new Option(`plot ${k + 1}`, k)));
    where.value = [...where.options].some(option => option.value === wanted) ? wanted : "unit";
  }

  search.addEventListener("input", list);
  clear.addEventListener("click", () => [...plots.panels].forEach(plots.close));
  root.querySelector(".add").addEventListener("click", () => {
    next = -1;
    found.hidden = false;
    found.textContent = "The next variable that you tick gets a plot of its own.";
    search.focus();
  });
  plots.onPanels(mark);
  list();
  mark();
}
