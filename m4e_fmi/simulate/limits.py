"""Outputs that leave their declared limits in a simulation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from m4e_fmi.program import Program, Variable
from m4e_fmi.simulate.simulation import Simulation

ROUNDING = 1e-9
"""Share of limits and values by which an output may be outside by rounding."""


def limited(program: Program) -> tuple[Variable, ...]:
    """The outputs with a declared limit; not those that are rates."""
    return tuple(
        v
        for v in program.outputs
        if v.derivative_of is None and np.isfinite([v.minimum, v.maximum]).any()
    )


def limits_left(motion: Simulation) -> Iterator[str]:
    """Lines on outputs that leave their limits in the rows of a motion, with the first time."""
    time = motion.time.values
    for v in limited(motion.program):
        if v.name not in motion.values:
            continue
        values = motion[v.name].values
        scale = np.nanmax(np.abs(values[np.isfinite(values)]), initial=0.0)
        near = ROUNDING * max(scale, *(abs(b) for b in (v.minimum, v.maximum) if np.isfinite(b)))
        outside = (values < v.minimum - near) | (values > v.maximum + near)
        if outside.any():
            row = int(np.argmax(outside))
            yield (
                f"{v.name} is {values[row]:.4g} {v.unit} at t = {time[row]:.9g} s, outside of "
                f"{limits_of(v)}"
            )


def limits_of(v: Variable) -> str:
    """Words on the limits of a variable, and on what it is."""
    return f"its limits, {v.minimum:.3g} to {v.maximum:.3g} {v.unit}: {v.description}"
