"""Fixed steps in plain Python: order, the C library's steps, what a step costs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from support.runtime_programs import chain

from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime import RungeKutta
from m4e_fmi.runtime.engine import Control, Engine


def rotation(t: float, x: Sequence[float]) -> list[float]:
    """A linear system with time in it: x₀ = cos(t²/2), x₁ = sin(t²/2)."""
    return [-t * x[1], t * x[0]]


def test_order_four() -> None:
    errors = []
    for step in (0.1, 0.05, 0.025):
        x = RungeKutta(rotation, step=step, tolerance=1.0).advance(0.0, [1.0, 0.0], 2.0)
        errors.append(math.hypot(x[0] - math.cos(2.0), x[1] - math.sin(2.0)))
    for coarse, fine in pairwise(errors):
        # the next term of the error expansion is a step smaller: 0.1 s on a time scale of 1 s
        assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.4)


@pytest.mark.parametrize("step", [0.1, 0.03, 0.025, math.inf])
def test_the_steps_of_the_library(step: float) -> None:
    program, times = chain(2), [0.0, 0.1, 0.2]
    form = load_python(program)
    p = [v.start for v in program.parameters]
    c, calls = form.constants(p), []

    def rates(t: float, x: Sequence[float]) -> list[float]:
        calls.append(t)
        return form.rates(t, x, [], p, c)

    method, x = RungeKutta(rates, step=step, tolerance=1.0), [0.0] * 4
    for t, t_end in pairwise(times):
        x = method.advance(t, x, t_end)
    run = Engine(program).simulate(times, states=[0.0] * 4, control=Control("rk4", max_step=step))
    assert len(calls) == run.evaluations
    # sines of another library, and sums in another order, in some ten steps
    np.testing.assert_allclose(x, run.states[-1], rtol=1e-13)
