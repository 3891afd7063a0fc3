"""Sheets of systems, as given and prepared, and of the FMUs in them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from m4e_fmi.cosim import Component, Kind, Prepared, System
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.notebook.graph import MOST_NODES, graph
from m4e_fmi.notebook.sheet import Sheet

Edges = Mapping[tuple[str, str], int]
_ARROW = re.compile(r"<->|->|<-")
CAN = {
    "saves_state": "saves its state",
    "serializes_state": "serialises it",
    "input_order": "interpolates inputs",
    "directional_derivatives": "has directional derivatives",
    "has_events": "has events",
    "constant_step": "needs a constant step",
    "once_per_process": "once in a process",
}


def system_sheet(system: System) -> Sheet:
    """The graph, tables of components and connections, the simulation."""
    sheet = _begun(system)
    names = [component.name for component in system.components]
    _add_graph(sheet, names, connected(names, system.connections))
    sheet.table(
        ("component", "made from", "step", "start values"),
        [(c.name, _source(c), c.step_size or "", _started(c)) for c in system.components],
    )
    sheet.lines("connections", system.connections)
    sheet.lines("scenario", system.scenario)
    sheet.lines("notes", system.notes)
    return sheet


def prepared_sheet(prepared: Prepared) -> Sheet:
    """The graph with all connected variables, tables of FMUs and connections, warnings."""
    system, links = prepared.system, prepared.wiring.all_links
    sheet = _begun(system, f"{len(links)} connected variables")
    edges: dict[tuple[str, str], int] = {}
    for link in links:
        ends = (link.source.component, link.target.component)
        edges[ends] = edges.get(ends, 0) + 1
    _add_graph(sheet, list(prepared.descriptions), edges)
    sheet.table(
        ("component", "FMU", "FMI", "inputs", "outputs", "parameters"),
        [(name, d.path.name, d.version, *_counts(d)) for name, d in prepared.descriptions.items()],
    )
    sheet.lines("connections", system.connections)
    sheet.lines("warnings", prepared.warnings)
    sheet.lines("notes", prepared.notes)
    return sheet


def description_sheet(description: Description) -> Sheet:
    """The FMU's identity and abilities, and tables of its variables."""
    can = [words for name, words in CAN.items() if getattr(description, name)]
    sheet = Sheet(
        f"FMU {description.path.name}", f"FMI {description.version}", description.tool, *can
    )
    for causality in ("input", "output", "parameter", "calculatedParameter", "local"):
        variables = description.of_causality(causality)
        sheet.table(
            (f"{causality} ({len(variables)})", "type", "unit", "start", "description"),
            [(v.name, v.type, v.unit, v.start or "", v.description) for v in variables],
        )
    return sheet


def connected(names: Iterable[str], connections: Iterable[str]) -> Edges:
    """Pairs of components that texts of connections lead from and to, and how many texts do so.

    ``a.x <-> b.x`` leads both ways.
    """
    longest = sorted(map(re.escape, names), key=len, reverse=True)
    known = re.compile(rf"(?<![\w.])({'|'.join(longest)})\.") if longest else None
    found: dict[tuple[str, str], int] = {}
    for line in connections:
        arrow = _ARROW.search(line)
        if arrow is None or known is None:
            continue
        left, right = known.findall(line[: arrow.start()]), known.findall(line[arrow.end() :])
        pairs = {(a, b) for a in left for b in right}
        if arrow[0] != "->":
            back = {(b, a) for a, b in pairs}
            pairs = back if arrow[0] == "<-" else pairs | back
        for pair in pairs:
            found[pair] = found.get(pair, 0) + 1
    return found


def _begun(system: System, *facts: str) -> Sheet:
    times = system.simulation
    return Sheet(
        f"System {system.name}",
        system.description,
        f"{times.start_time:g} s to {times.stop_time:g} s in steps of {times.step_size:g} s",
        times.algorithm,
        *facts,
    )


def _add_graph(sheet: Sheet, names: list[str], edges: Edges) -> None:
    if len(names) > MOST_NODES:
        sheet.note(f"{len(names)} components are too many for a graph")
    else:
        sheet.markup(graph(names, edges))


def _source(component: Component) -> str:
    source = component.source
    return f"kind {source.name}" if isinstance(source, Kind) else source.path.name


def _started(component: Component) -> str:
    return ", ".join(f"{name} = {value}" for name, value in component.start.items())


def _counts(description: Description) -> tuple[str, ...]:
    kinds = ("input", "output", "parameter")
    return tuple(str(len(description.of_causality(kind))) for kind in kinds)
