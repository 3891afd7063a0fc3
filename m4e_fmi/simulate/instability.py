"""Instability of a simulation of one model: the message (criterion: results/growth)."""

from __future__ import annotations

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.program import Program
from m4e_fmi.results.growth import largest_growth

HUGE = 1e20
"""No state of a working system is so large, in SI units."""
STOPS, FAILED = 6.0, 4.0
"""Decades of growth that tell an unstable system: of one that went on, and where it has failed."""
_FIXED = "take a smaller step_size, or a method that controls its error, as dop853"
_SYSTEM = (
    "look at the signs of stiffness, damping and feedback, or give it damping; what is meant to "
    "grow without end needs an earlier stop_time"
)


def instability(
    program: Program, method: str, times: np.ndarray, states: np.ndarray, failure: str
) -> RunError | None:
    """The error to raise if a state had grown without bound when the `failure` came.

    `states` are the program's first states, shape (n, states), in their units, at `times` (n,)
    [s]. With an empty `failure`, at the end of a simulation, a state must have become huge besides.
    """
    least = 0.0 if failure else HUGE
    columns = {
        v.name: column
        for v, column in zip(program.states, states.T, strict=False)
        if np.fmax.reduce(np.abs(column), initial=0.0) > least
    }
    grown = largest_growth(times, columns, decades=FAILED if failure else STOPS)
    if grown is None or grown.high < 1.0:
        return None
    state = next(v for v in program.states if v.name == grown.name)
    then = f"; then {failure}" if failure else ""
    message = f"{program.name} is unstable: {grown.text(state.description, state.unit)}{then}"
    return RunError(message, _FIXED if method == "rk4" else _SYSTEM)
