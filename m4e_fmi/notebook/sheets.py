"""The sheet of each kind of object: models, systems, results, runs, linear equations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from m4e_fmi.analysis import Linearization, Modes
from m4e_fmi.cosim import Kind, Outcome, System
from m4e_fmi.model import Model
from m4e_fmi.notebook.sheet import MOST_ROWS, Sheet
from m4e_fmi.program import Variable
from m4e_fmi.report.text.summaries import ranges
from m4e_fmi.report.text.tables import model_listings
from m4e_fmi.results.results_file import Results
from m4e_fmi.results.series import Series
from m4e_fmi.shown import span
from m4e_fmi.simulate import Simulation

MOST_TABLES = 12
"""Components of results that have a table."""
MOST_STATES = 12
"""Of a matrix that is shown."""
ATTRIBUTES = ("algorithm", "method", "tolerance", "ended")
"""Attributes of results that are shown."""


def _model(model: Model) -> Sheet:
    plane = "in space" if model.dimensions == 3 else "planar"
    sheet = Sheet(f"Model {model.name}", plane, model.description)
    *others, parameters = model_listings(model)
    for listing in (parameters, *others):
        if listing.rows:
            sheet.note(listing.title)
            sheet.table(listing.head, listing.rows)
    for warning in model.warnings:
        sheet.note(f"warning: {warning}")
    return sheet


def _system(system: System) -> Sheet:
    times = system.simulation
    sheet = Sheet(
        f"System {system.name}",
        system.description,
        f"{times.start_time:g} s to {times.stop_time:g} s in steps of {times.step_size:g} s",
        times.algorithm,
    )
    sheet.table(
        ("component", "made from", "step", "start values"),
        [
            (
                c.name,
                f"kind {c.source.name}" if isinstance(c.source, Kind) else c.source.path.name,
                c.step_size or "",
                ", ".join(f"{n} = {v}" for n, v in c.start.items()),
            )
            for c in system.components
        ],
    )
    for title in ("connections", "scenario", "notes"):
        sheet.lines(title, getattr(system, title))
    return sheet


def _results(results: Results) -> Sheet:
    """A table for each component: variables, units, ranges."""
    told = [
        f"{name}: {results.attributes[name]}" for name in ATTRIBUTES if name in results.attributes
    ]
    title = results.attributes.get("title") or results.path.name
    sheet = Sheet(f"Results of {title}", str(results.path), span(results.time), *told)
    for component, members in list(results.components.items())[:MOST_TABLES]:
        _series(sheet, component, members, results.time)
    if (left := len(results.components) - MOST_TABLES) > 0:
        sheet.note(f"and {left} further components")
    return sheet


def _simulation(simulation: Simulation) -> Sheet:
    """A table of states and outputs: units, ranges."""
    energy, variables = simulation.energy, simulation.variables
    balance = "" if energy is None else f"energy balance closes to {100 * energy.relative:.1e} %"
    sheet = Sheet(
        f"Simulation of {simulation.program.name}", span(simulation.time), simulation.method,
        f"{simulation.evaluations} evaluations in {simulation.wall_time:.2g} s", balance,
    )  # fmt: skip
    shown = {
        name: one
        for name, one in simulation.values.items()
        if not (name in variables and variables[name].local)
    }
    _series(sheet, "variables", shown, simulation.time)
    sheet.table(
        ("change of sign", "time [s]"), [(event.name, event.time) for event in simulation.events]
    )
    return sheet


def _series(sheet: Sheet, title: str, series: Mapping[str, Series], time: np.ndarray) -> None:
    """Add a table of ranges over times (n,) [s]; of what is no number the type alone."""
    rows: list[Sequence[object]] = []
    for name, one in list(series.items())[:MOST_ROWS]:
        has_range = one.recorded.is_real and len(time)
        numbers = ranges(one.values, time) if has_range else ("", "", "")
        rows.append((name, one.unit or one.recorded.type, *numbers, one.long_name))
    heads = (f"{title} ({len(series)})", "unit", "min", "mean", "max", "description")
    sheet.table(heads, rows, more=len(series) - len(rows))


def _outcome(outcome: Outcome) -> Sheet:
    """Steps, coupling error, energy over the connections, warnings, messages."""
    system, certificate = outcome.prepared.system, outcome.certificate
    sheet = Sheet(
        f"Outcome of {system.name}",
        f"{outcome.steps} steps in {outcome.wall_time:.3g} s, {system.simulation.algorithm}",
        f"results in {outcome.path}" if outcome.path else "no file of results",
    )
    unknown = "coupling error not known: " if isinstance(certificate, str) else ""
    sheet.note(f"{unknown}{certificate}")
    sheet.table(
        ("energy over the connection", "given [J]", "received [J]", "lost or made [1]"),
        [
            (b.connection, float(b.given), float(b.received), float(b.relative))
            for b in outcome.energy
        ],
    )
    sheet.lines("warnings", outcome.warnings)
    sheet.lines("messages of FMUs", outcome.messages)
    sheet.lines("scenario", outcome.scenario)
    sheet.lines("notes", outcome.notes)
    return sheet


def _linearization(linear: Linearization) -> Sheet:
    """The matrix A, and the names of states, inputs and outputs."""
    sizes = ", ".join(
        f"{name} {'×'.join(map(str, getattr(linear, name).shape))}" for name in "ABCD"
    )
    point = linear.point
    sheet = Sheet(f"Linear equations of {point.program.name}", f"t = {point.time:g} s", sizes)
    names = [v.name for v in linear.states]
    if len(names) <= MOST_STATES:
        rows = [(name, *map(float, row)) for name, row in zip(names, linear.A, strict=True)]
        sheet.table(("A", *names), rows)
    for title in ("states", "inputs", "outputs"):
        variables: tuple[Variable, ...] = getattr(linear, title)
        rows = [(v.name, v.unit, v.description) for v in variables]
        sheet.table((f"{title} ({len(rows)})", "unit", "description"), rows)
    return sheet


def _modes(modes: Modes) -> Sheet:
    """Frequency, period, damping ratio and main coordinate of each mode."""
    sheet = Sheet("Modes", "no motion grows" if modes.stable else "a motion grows")
    rows: list[Sequence[object]] = []
    for k, value in enumerate(modes.eigenvalues.tolist()):
        hertz, ratio = abs(value) / (2 * np.pi), float(modes.damping_ratios[k])
        swings, main = value.imag != 0, ""
        if modes.coordinates:
            main = modes.coordinates[int(np.abs(modes.shapes[:, k]).argmax())].name
        rows.append((
            str(k + 1), hertz if swings else None, 1 / hertz if swings else None,
            ratio if np.isfinite(ratio) else None, float(value.real), main,
        ))  # fmt: skip
    heads = ("mode", "frequency [Hz]", "period [s]", "damping ratio [1]", "growth [1/s]", "mostly")
    sheet.table(heads, rows)
    return sheet


SHEETS: dict[type, Callable[..., Sheet]] = {
    Model: _model,
    System: _system,
    Results: _results,
    Simulation: _simulation,
    Outcome: _outcome,
    Linearization: _linearization,
    Modes: _modes,
}
"""Kinds of objects, and what makes their sheets."""
