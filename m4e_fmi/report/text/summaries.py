"""Summaries of runs and simulations: as text, and as numbers for programs that read them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.headlines import headlines
from m4e_fmi.report.panels import Panel, aligned, fitting, moving, panels, percent, quantity
from m4e_fmi.report.run_report.flows import energy_closes
from m4e_fmi.results.results_file import Results, Series
from m4e_fmi.shown import WIDTH, columns

if TYPE_CHECKING:
    from m4e_fmi.cosim import BondEnergy, FmuMessage, Outcome
    from m4e_fmi.simulate import Simulation


Entry = dict[str, object]
LOSSY = 0.01
"""Share of the energy over a connection that is worth a line."""
MOST_MESSAGES = 20
"""Kinds of messages that a summary has."""


def result_text(results: Results) -> str:
    """The headline figures, as few lines; "" without any."""
    texts = list(map(str, headlines(results)))
    lines = texts[:1]
    for text in texts[1:]:
        if len(lines[-1]) + len(text) + 2 > WIDTH:
            lines.append(text)
        else:
            lines[-1] += f"; {text}"
    return "\n".join(lines)


def run_text(outcome: Outcome, told: Collection[str] = ()) -> str:
    """Headline figures, doubts, and the coupling error in words of a run that wrote results.

    Warnings and messages of FMUs that were `told` already, as `warn` of `run` got them, are left
    out.
    """
    messages = [message for message in outcome.messages if str(message) not in told]
    lines = [
        result_text(outcome.results()),
        *(note for note in outcome.notes if note not in told),
        *(line for line in map("warning: {}".format, outcome.warnings) if line not in told),
        *_messages(messages),
        *_lossy(outcome.energy),
        _certified(outcome),
    ]
    return "\n".join(filter(None, lines))


def run_summary(outcome: Outcome) -> str:
    """Steps, time, extremes and energies of a run that wrote results."""
    loaded = outcome.results()
    settings = outcome.prepared.system.simulation
    span = float(loaded.time[-1] - loaded.time[0])
    errors = outcome.certificate
    coverage = None if isinstance(errors, str) else errors.coverage
    factor = span / outcome.wall_time if outcome.wall_time else float("inf")
    lines = [
        f"simulated {span:g} s in {outcome.wall_time:.1f} s ({factor:.1f} × real time): "
        f"{outcome.steps} steps of {_sizes(outcome)}, {settings.algorithm}",
        *([f"  {coverage}"] if coverage and not coverage.lost else []),
        *(["scenario:"] if outcome.scenario else []),
        *(f"  {line}" for line in outcome.scenario),
        *_extremes(loaded, _rows(loaded, outcome.steps)),
    ]
    return "\n".join([*lines, *_bonds(outcome.energy, span)])


def _bonds(energy: Sequence[BondEnergy], span: float) -> list[str]:
    """The table of the energies over the connections within `span` [s]."""
    if not energy:
        return []
    rows = [
        (
            bond.connection,
            quantity(bond.given, "J"),
            quantity(bond.received, "J"),
            "–" if bond.is_idle else percent(bond.relative),
            quantity(bond.given / span if span else 0.0, "W"),
        )
        for bond in energy
    ]
    head, *lines = columns("<>>>>", ("", "given", "received", "lost or made", "mean power"), *rows)
    found = ["energy over the connections, from the force's source into the body", head]
    for bond, line in zip(energy, lines, strict=True):
        found.append(line)
        if bond.adds:
            found.append(f"    the sum of the forces of {', '.join(bond.adds)}, counted as one")
    return found


def _messages(messages: Sequence[FmuMessage]) -> list[str]:
    """Warnings and errors of FMUs; of many, the first and how many more there are."""
    if not messages:
        return []
    lines = [f"  {message}" for message in messages[:MOST_MESSAGES]]
    more = len(messages) - len(lines)
    if more:
        lines.append(f"  {more} more are in the results (attribute 'messages')")
    return ["messages of FMUs:", *lines]


def lossy_text(connection: str, share: float) -> str:
    """A connection that makes a `share` [1] of the energy over it, or loses it if negative."""
    verb = "makes" if share > 0.0 else "loses"
    return f"{connection} {verb} {percent(abs(share)).lstrip('+')} of the energy that it passes"


def _lossy(energy: Sequence[BondEnergy]) -> list[str]:
    """A line for each connection that loses or makes much of its energy."""
    return [
        lossy_text(bond.connection, bond.relative)
        for bond in energy
        if not (bond.is_idle or abs(bond.relative) <= LOSSY)
    ]


def _certified(outcome: Outcome) -> str:
    found = outcome.certificate
    if isinstance(found, str):
        return f"coupling error not known: {found}; compare with a run at half the step_size"
    if not (found.errors or found.uncovered):
        return ""
    less = found.coverage and found.coverage.lost
    return f"{found}\n  {found.coverage}" if less else str(found)


def _sizes(outcome: Outcome) -> str:
    settings = outcome.prepared.system.simulation
    if settings.coupling_tolerance is None:
        shortened = f", {outcome.rejected} made again" if outcome.rejected else ""
        return f"{settings.step_size:g} s{shortened}"
    return f"up to {settings.step_size:g} s, {outcome.rejected} made again"


def _rows(results: Results, steps: int) -> str:
    """Distance of the rows where there are fewer than communication points; else ""."""
    if len(results.time) > steps:
        return ""
    return f"from rows every {np.diff(results.time).max(initial=0.0):.6g} s"


def _extremes(results: Results, rows: str) -> list[str]:
    """Smallest, mean and largest value of what a figure would show.

    `rows` is what is said of figures that are from some communication points only.
    """
    reals = {name: one for name, one in results.series.items() if one.recorded.is_real}
    found = [fitting(panel) for panel in moving(panels(reals))]
    lines = []
    shown = extremes(found, results.time)
    if shown:
        table = [(name, *numbers, unit) for name, unit, numbers in shown]
        lines += columns("<>>><", (rows, "min", "mean", "max", ""), *table)
    lines += [
        f"  {panel.left_out} more in {panel.unit}, which vary less, are in the results"
        for panel in found
        if panel.left_out
    ]
    return lines


def ranges(values: np.ndarray, time: np.ndarray) -> tuple[float, float, float]:
    """Smallest, mean and largest of `values` (n,) over `time` (n,) [s], in the unit of `values`.

    The mean is by the trapezoidal rule.
    """
    span = float(time[-1] - time[0])
    mean = np.trapezoid(values, time) / span if span else values[0]
    return float(np.min(values)), float(mean), float(np.max(values))


def extremes(shown: Iterable[Panel], time: np.ndarray) -> list[tuple[str, str, list[str]]]:
    """Names, units, and the `ranges` of what is in panels as texts, over `time` (n,) [s]."""
    return [
        (name, panel.unit, aligned(*ranges(panel.scale * one.values, time)))
        for panel in shown
        for name, one in panel.series.items()
    ]


def simulation_text(simulation: Simulation, results: Results) -> str:
    """Headline figures of its `results`, events and energy balance of an in-process simulation."""
    lines = [result_text(results)]
    if simulation.events:
        lines.append("changes of sign:")
        lines += [
            f"  {event.name:<32} {event.time: .9g} s{', the end' if event.terminal else ''}"
            for event in simulation.events
        ]
    if closes := energy_closes(simulation.energy):
        lines.append(f"energy balance {closes}")
    return "\n".join(filter(None, lines))


def simulation_summary(simulation: Simulation) -> str:
    """Steps and time, works of loads and final state of an in-process simulation."""
    span = float(simulation.time[-1])
    lines = [
        f"{simulation.program.name}: {span:g} s in {simulation.wall_time:.2f} s "
        f"({span / simulation.wall_time:.0f} × real time), {simulation.method}, "
        f"{simulation.evaluations} evaluations"
    ]
    works = {name: work for name, work in simulation.values.items() if name.endswith(".work")}
    if works:
        lines.append(f"into the system within {span:g} s, and the mean power:")
    lines += [
        f"  {name:<32} {work[-1]: .6g} J, {work[-1] / span: .6g} W" for name, work in works.items()
    ]
    lines.append("state at the end:")
    lines += [
        f"  {state.name:<32} {simulation[state.name][-1]: .9g} {state.unit}"
        for state in simulation.program.states
        if not state.local
    ]
    return "\n".join(lines)


def run_numbers(outcome: Outcome) -> tuple[list[Entry], list[Entry]]:
    """Numbers {name, unit, value} of a run that wrote results, and those of its variables.

    Errors of the coupling are shares [1] of the range of their output; energies [J] are those over
    the connections, from the force's source into the body.
    """
    loaded = outcome.results()
    time = loaded.time
    numbers = [
        _number("simulated time", "s", float(time[-1] - time[0])),
        _number("wall time of the run", "s", outcome.wall_time),
        _number("steps", "1", outcome.steps),
        _number("steps made again", "1", outcome.rejected),
    ]
    if not isinstance(outcome.certificate, str) and outcome.certificate.errors:
        worst = outcome.certificate.errors[0]
        name = f"coupling error of {worst.source}{outcome.certificate.uncovered}"
        numbers.append(_number(name, "1", worst.error))
    for bond in outcome.energy:
        numbers.append(_number(f"energy given over {bond.connection}", "J", bond.given))
        numbers.append(_number(f"energy received over {bond.connection}", "J", bond.received))
    return numbers, _variable_numbers(loaded.series, time)


def simulation_numbers(simulation: Simulation) -> tuple[list[Entry], list[Entry]]:
    """Numbers {name, unit, value} of a simulation, and those of its variables."""
    numbers = [
        _number("simulated time", "s", float(simulation.time[-1])),
        _number("wall time of the run", "s", simulation.wall_time),
        _number("evaluations", "1", simulation.evaluations),
    ]
    if simulation.energy is not None:
        numbers.append(_number("error of the energy balance", "1", simulation.energy.relative))
    named = {
        name: simulation[name]
        for name, variable in simulation.variables.items()
        if not variable.local
    }
    return numbers, _variable_numbers(named, simulation.time)


def _variable_numbers(series: Mapping[str, Series], time: np.ndarray) -> list[Entry]:
    """Smallest, mean and largest value of the variables that a figure would show, in their units.

    Means are those over the `time` (n,) [s], by the trapezoidal rule.
    """
    reals = {name: one for name, one in series.items() if one.recorded.is_real}
    shown = map(fitting, panels(reals)) if reals and len(time) else ()
    found = [(name, one) for panel in shown for name, one in panel.series.items()]
    ends = ("min", "mean", "max")
    return [
        {"name": name, "unit": one.unit, **dict(zip(ends, ranges(one.values, time), strict=True))}
        for name, one in found
    ]


def _number(name: str, unit: str, value: float) -> Entry:
    return {"name": name, "unit": unit, "value": value}
