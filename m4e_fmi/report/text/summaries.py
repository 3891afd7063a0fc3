"""Summaries of runs and simulations: as text, and as numbers for programs that read them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.panels import Panel, aligned, fitting, moving, panels, percent, quantity
from m4e_fmi.results.results_file import Results, Series
from m4e_fmi.shown import columns
from m4e_fmi.units import BASE_UNITS, parse_unit

if TYPE_CHECKING:
    from m4e_fmi.cosim import BondEnergy, FmuMessage, Outcome
    from m4e_fmi.simulate import Simulation


Entry = dict[str, object]
MOST_MESSAGES = 20
"""Kinds of messages that a summary has."""


def run_summary(outcome: Outcome, told: Collection[str] = ()) -> str:
    """Power, extremes, steps, time and energy balance of a run that wrote results.

    Warnings and messages of FMUs that were `told` already, as `warn` of `run` got them, are left
    out.
    """
    loaded = outcome.results()
    settings = outcome.prepared.system.simulation
    span = float(loaded.time[-1] - loaded.time[0])
    factor = span / outcome.wall_time if outcome.wall_time else float("inf")
    lines = [
        f"simulated {span:g} s in {outcome.wall_time:.1f} s ({factor:.1f} × real time): "
        f"{outcome.steps} steps of {_sizes(outcome)}, {settings.algorithm}",
        *(f"  {note}" for note in outcome.notes),
        *(f"  {line}" for line in map("warning: {}".format, outcome.warnings) if line not in told),
        *(["scenario:"] if outcome.scenario else []),
        *(f"  {line}" for line in outcome.scenario),
        *_messages([message for message in outcome.messages if str(message) not in told]),
        *_certified(outcome),
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


def _certified(outcome: Outcome) -> list[str]:
    lines = [f"  {outcome.certificate}"]
    if isinstance(outcome.certificate, str):
        text = f"  coupling error not known: {outcome.certificate}"
        return [f"{text}; compare with a run at half the step_size"]
    if outcome.certificate.coverage:
        lines.append(f"  {outcome.certificate.coverage}")
    return lines


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
    """Mean of every power first; then smallest, mean, largest value of what a figure would show.

    `rows` is what is said of figures that are from some communication points only.
    """
    reals = {name: one for name, one in results.series.items() if one.recorded.is_real}
    found = [fitting(panel) for panel in moving(panels(reals))]
    span = float(results.time[-1] - results.time[0])
    powers = {name: one for name, one in reals.items() if _watts(one.unit)}
    # that of the inputs of a model lifts its weight, and is in the energies over the connections
    others = {name: one for name, one in powers.items() if not name.endswith("inputs.power")}
    lines = [
        f"mean power {quantity(_watts(one.unit) * ranges(one.values, results.time)[1], 'W')}"
        f" over {span:g} s ({name}){rows and f', {rows}'}"
        for name, one in (others or powers).items()
    ]
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


@cache
def _watts(unit: str) -> float:
    """Watts of a unit of power; 0 for any other unit."""
    try:
        found, watt = parse_unit(unit), parse_unit("W")
    except ValueError:
        return 0.0
    angles = BASE_UNITS.index("rad")
    ours, theirs = (u.exponents[:angles] + u.exponents[angles + 1 :] for u in (found, watt))
    return found.factor if ours == theirs else 0.0


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


def simulation_summary(simulation: Simulation) -> str:
    """Steps and time, energy balance, events and final state of an in-process simulation."""
    factor = simulation.time[-1] / simulation.wall_time
    lines = [
        f"{simulation.program.name}: {simulation.time[-1]:g} s in {simulation.wall_time:.2f} s "
        f"({factor:.0f} × real time), {simulation.method}, {simulation.evaluations} evaluations",
        *_energy(simulation),
    ]
    if simulation.events:
        lines.append("changes of sign:")
        lines += [
            f"  {event.name:<32} {event.time: .9g} s{', the end' if event.terminal else ''}"
            for event in simulation.events
        ]
    lines.append("state at the end:")
    lines += [
        f"  {state.name:<32} {simulation[state.name][-1]: .9g} {state.unit}"
        for state in simulation.program.states
        if not state.local
    ]
    return "\n".join(lines)


def _energy(simulation: Simulation) -> list[str]:
    """Energy at both ends, what each load and the inputs did to it, and how well that adds up."""
    audit = simulation.energy
    if audit is None:
        return []
    total, span = audit.total, float(simulation.time[-1])
    works = {name: work for name, work in simulation.values.items() if name.endswith(".work")}
    lines = [f"total energy {total[0]:.6g} J at the start, {total[-1]:.6g} J at the end"]
    if works:
        lines.append(f"into the system within {span:g} s, and the mean power:")
    lines += [
        f"  {name:<32} {work[-1]: .6g} J, {work[-1] / span: .6g} W" for name, work in works.items()
    ]
    percent = 100 * audit.relative
    return [*lines, f"energy balance closes to {percent:.1e} % of {audit.scale:.6g} J"]


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
