"""Simulation in process: methods agree, times are met, failures are told."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from m4e_fmi.program import Program, Recorder, Variable, cos
from m4e_fmi.runtime.engine import Control, Engine
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.simulation import METHODS, output_times


def oscillator() -> Program:
    """ẍ = −ω² x with ω = 2 rad/s, x(0) = 1; an output x²."""
    r = Recorder("oscillator", "undamped")
    omega = r.parameter(Variable("omega", "rad/s", "angular frequency", start=2.0))
    x = r.state(Variable("x", "m", "position", start=1.0))
    v = r.state(Variable("v", "m/s", "velocity"))
    r.rate("x", v)
    r.rate("v", -omega * omega * x)
    r.output(Variable("square", "m2", "x squared"), x * x)
    return r.program()


@pytest.mark.parametrize("method", METHODS)
def test_every_method_solves_the_oscillator(method: str):
    tolerance = 1e-8
    result = simulate(oscillator(), stop_time=5.0, tolerance=tolerance, method=method)
    # a local error of `tolerance` per step, some hundred steps, five periods of growth
    bound = 3000 * tolerance
    assert result["x"] == pytest.approx(np.cos(2 * result.time), abs=bound)
    assert result["square"] == pytest.approx(result["x"] ** 2, rel=1e-14)


@pytest.mark.parametrize("method", ["dop853", "rk45"])
def test_progress_changes_no_bit(method: str):
    told: list[float] = []
    watched = simulate(oscillator(), stop_time=5.0, method=method, progress=told.append)
    alone = simulate(oscillator(), stop_time=5.0, method=method)
    assert np.array_equal(watched["x"], alone["x"])
    assert told[-1] == 5.0
    assert all(a < b for a, b in pairwise(told))


def test_fixed_steps_alone_have_a_step_size():
    coarse, fine = (
        simulate(oscillator(), stop_time=4.0, output_interval=0.4, method="rk4", step_size=step)
        for step in (None, 0.1)
    )
    assert (coarse.evaluations, fine.evaluations) == (40, 160)


def test_the_stiff_method_has_the_exact_jacobian():
    """Without it, every step would evaluate the rates once for each state and for the time."""
    r = Recorder("relaxation", "y to cos t, fast")
    y = r.state(Variable("y", "1", "follows"))
    r.rate("y", 1e4 * (cos(r.time) - y))
    result = simulate(r.program(), stop_time=10.0, method="rodas")
    engine = Engine(result.program)
    differences = engine.simulate(result.time, control=Control("rodas"))
    assert result["y"][-1] == pytest.approx(np.cos(10.0 - 1e-4), abs=1e-7)
    assert result.evaluations < differences.evaluations - differences.jacobians


@pytest.mark.parametrize(
    ("stop", "interval"), [(20, 0.01), (10, 0.005), (0.1, 0.05), (1, 0.3), (0.2, 7)]
)
def test_output_times_of_any_ratio(stop: float, interval: float):
    times = output_times(stop, interval)
    assert times[0] == 0.0
    assert times[-1] == stop
    steps = np.diff(times)
    assert (steps > 0).all()
    # all but the last are the interval, to the rounding of k·interval
    assert steps[:-1] == pytest.approx(interval, abs=1e-12)
    assert steps[-1] <= interval * (1 + 1e-9)
