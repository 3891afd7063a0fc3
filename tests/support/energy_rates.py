"""Energy that a program makes or loses: the rate of its total energy beside its powers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mpmath
from support.tape_values import exact_values

from m4e_fmi.program import Program


def imbalance(program: Program, values: Mapping[str, float], power: Any) -> float:
    """|d(energy)/dt − power of the inputs and of the loads|, relative to the energy.

    To it comes how far the program's own power of the inputs is from `power`.

    The rate of the energy is a difference quotient along the motion, in 100 digits: its error is
    the square of the step, 1e-40, times a third derivative.
    """
    step = mpmath.mpf(10) ** -20
    outputs = dict(zip((v.name for v in program.outputs), program.results, strict=True))
    with mpmath.workdps(100):
        rates = exact_values(program, program.rates, values)
        total = outputs["energy.total"]
        energies = []
        for side in (1, -1):
            moved = {**values, "time": values.get("time", 0.0) + side * step}
            for state, rate in zip(program.states, rates, strict=True):
                moved[state.name] = values[state.name] + side * step * rate
            energies += exact_values(program, [total], moved)
        slope = (energies[0] - energies[1]) / (2 * step)
        loads = [name for name in outputs if name.startswith("load.") and name.endswith(".power")]
        nodes = [outputs[name] for name in ("inputs.power", *loads)]
        told, *gained = exact_values(program, nodes, values)
        wrong = abs(slope - power - sum(gained)) + abs(told - power)
        return float(wrong / (1 + abs(energies[0])))
