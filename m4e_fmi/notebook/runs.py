"""Sheets of results, simulations, and of what a run says of itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice

import numpy as np

from m4e_fmi.cosim import Outcome
from m4e_fmi.notebook.sheet import MOST_ROWS, Sheet
from m4e_fmi.results.results_file import Results
from m4e_fmi.results.series import Series
from m4e_fmi.shown import span
from m4e_fmi.simulate import Simulation

ATTRIBUTES = ("algorithm", "method", "tolerance", "ended")
"""Attributes of results that are shown."""
HEADS = ("unit", "min", "mean", "max", "description")


def results_sheet(results: Results) -> Sheet:
    """A table for each component: variables, units, ranges."""
    told = [
        f"{name}: {results.attributes[name]}" for name in ATTRIBUTES if name in results.attributes
    ]
    title = results.attributes.get("title") or results.path.name
    sheet = Sheet(f"Results of {title}", str(results.path), span(results.time), *told)
    for component, members in results.components.items():
        heads = (f"{component} ({len(members)})", *HEADS)
        rows = list(islice(_rows(members, results.time), MOST_ROWS))
        sheet.table(heads, rows, more=len(members) - len(rows))
    return sheet


def simulation_sheet(simulation: Simulation) -> Sheet:
    """A table of states and outputs: units, ranges."""
    program = simulation.program
    energy = simulation.energy
    balance = "" if energy is None else f"energy balance closes to {100 * energy.relative:.1e} %"
    sheet = Sheet(
        f"Simulation of {program.name}", span(simulation.time), simulation.method,
        f"{simulation.evaluations} evaluations in {simulation.wall_time:.2g} s", balance,
    )  # fmt: skip
    shown = {
        name: one
        for name, one in simulation.values.items()
        if not (name in simulation.variables and simulation.variables[name].local)
    }
    rows = list(islice(_rows(shown, simulation.time), MOST_ROWS))
    heads = (f"variables ({len(shown)})", *HEADS)
    sheet.table(heads, rows, more=len(shown) - len(rows))
    sheet.table(
        ("change of sign", "time [s]"), [(event.name, event.time) for event in simulation.events]
    )
    return sheet


def _rows(series: Mapping[str, Series], time: np.ndarray) -> Iterator[tuple[object, ...]]:
    """Rows of a table, at times (n,) [s]; of what is no number the type alone."""
    for name, one in series.items():
        if not one.recorded.is_real or not len(time):
            yield name, one.unit or one.recorded.type, "", "", "", one.long_name
            continue
        values = one.values
        length = float(time[-1] - time[0])
        mean = float(np.trapezoid(values, time)) / length if length else float(values[0])
        yield name, one.unit, float(values.min()), mean, float(values.max()), one.long_name


def outcome_sheet(outcome: Outcome) -> Sheet:
    """Steps, coupling error, energy over the connections, warnings, messages."""
    system = outcome.prepared.system
    where = f"results in {outcome.path}" if outcome.path else "no file of results"
    sheet = Sheet(
        f"Outcome of {system.name}",
        f"{outcome.steps} steps in {outcome.wall_time:.3g} s, {system.simulation.algorithm}",
        where,
    )
    certificate = outcome.certificate
    if isinstance(certificate, str):
        sheet.note(f"coupling error not known: {certificate}")
    else:
        sheet.note(str(certificate))
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
