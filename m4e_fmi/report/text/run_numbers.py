"""The numbers of a summary, for programs that read them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.report.panels import fitting, panels
from m4e_fmi.results.series import Series

if TYPE_CHECKING:
    from m4e_fmi.cosim import Outcome
    from m4e_fmi.simulate import Simulation

Entry = dict[str, object]


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
    return numbers, variable_numbers(loaded.series, time)


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
    return numbers, variable_numbers(named, simulation.time)


def variable_numbers(series: Mapping[str, Series], time: np.ndarray) -> list[Entry]:
    """Smallest, mean and largest value of the variables that a figure would show, in their units.

    Means are those over the `time` (n,) [s], by the trapezoidal rule.
    """
    reals = {name: one for name, one in series.items() if one.recorded.is_real}
    shown = {
        name: one for panel in panels(reals) for name, one in fitting(panel).series.items()
    } if reals and len(time) else {}  # fmt: skip
    span = float(time[-1] - time[0]) if len(time) else 0.0
    return [
        {
            "name": name,
            "unit": one.unit,
            "min": float(one.values.min()),
            "mean": float(np.trapezoid(one.values, time) / span if span else one.values[0]),
            "max": float(one.values.max()),
        }
        for name, one in shown.items()
    ]


def _number(name: str, unit: str, value: float) -> Entry:
    return {"name": name, "unit": unit, "value": value}
