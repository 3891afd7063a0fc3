"""Values of time and parameters only: computed apart, for many times at once, never out of date."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.runtime_programs import waves

from m4e_fmi.errors import RunError
from m4e_fmi.program import Program, Variable
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime.engine import Control, Engine, ensemble


def _fresh(program: Program, height: float, t: float) -> np.ndarray:
    engine = Engine(program)
    engine.set_parameters([height])
    return engine.rates(t, [0.2, 0.3, 0.4])


def test_values_follow_time_and_parameters() -> None:
    program, x = waves(), [0.2, 0.3, 0.4]
    engine = Engine(program)
    for height, t in ((0.05, 1.0), (0.06, 1.0), (0.06, 2.0), (0.06, 1.0), (0.0, 1.0), (0.06, 1.0)):
        engine.set_parameters([height])
        np.testing.assert_array_equal(engine.rates(t, x), _fresh(program, height, t))
    engine.set_inputs([7.0])
    assert engine.rates(1.0, x)[1] == pytest.approx(_fresh(program, 0.06, 1.0)[1] + 6.9, abs=1e-12)


def test_the_two_zeros_are_two_times() -> None:
    """The direction of (-1, t) turns by a whole turn between them; and nan is no time."""
    program = waves()
    engine, x = Engine(program), [0.2, 0.3, 0.4]
    form = load_python(program)
    constants = form.constants([0.05])
    for t in (0.0, -0.0, 0.0, float("nan"), -0.0):
        found = engine.rates(t, x)
        np.testing.assert_array_equal(found, _fresh(program, 0.05, t))
        if t == t:
            expected = form.rates(t, x, [0.1], [0.05], constants)
            np.testing.assert_allclose(found, expected, rtol=1e-12)
        else:
            assert np.isnan(found[1])
    assert engine.rates(0.0, x)[1] != engine.rates(-0.0, x)[1]


@pytest.mark.parametrize("method", ["rk45", "dop853", "rk4"])
def test_times_foreseen_have_the_bits_of_single_ones(method: str) -> None:
    """An ensemble computes them stage by stage. Also after a parameter has changed."""
    program, times = waves(), np.linspace(0.0, 6.0, 61)
    control = Control(method, 1e-8, 1e-8)
    engine = Engine(program)
    for height in (0.05, 0.3):
        single, states = np.array([[height]]), np.full((1, 3), 0.2)
        [alone] = ensemble(program, times, parameters=single, states=states, control=control)
        engine.set_parameters([height])
        run = engine.simulate(times, control=control)
        np.testing.assert_array_equal(run.states, alone.states)
        np.testing.assert_array_equal(run.outputs, alone.outputs)
        assert run.evaluations == alone.evaluations
        engine.set_parameters([2.0 * height])  # what was foreseen for the last time is so no more
        found = engine.rates(6.0, [0.2, 0.3, 0.4])
        np.testing.assert_array_equal(found, _fresh(program, 2.0 * height, 6.0))


def test_a_calculated_parameter_does_not_depend_on_time() -> None:
    program = waves()
    force = program.results[1]
    wrong = replace(program, calculated=(Variable("late", "N", "?"),), constants=(force,))
    with pytest.raises(RunError, match="calculated parameter that varies"):
        Engine(wrong)
