"""Algebraic loops that become singular while a composed program runs, or where it is looked at."""

from __future__ import annotations

import pytest

from m4e_fmi.analysis import equilibrium, linearize, sensitivity
from m4e_fmi.errors import RunError
from m4e_fmi.program import AnyScalar, Connection, Program, Recorder, Variable, compose
from m4e_fmi.simulate import simulate

METHODS = ("dop853", "rk45", "rodas", "rk4")


def looped(*, of_time: bool = False, driven: bool = True) -> Program:
    """u = g·u + 1 with the gain g = k, or `of_time` t; ẋ is u − x if `driven`, else −x."""
    r = Recorder("a", "")
    u, x = r.input(Variable("u", "1", "")), r.state(Variable("x", "1", "", start=1.0))
    k = r.parameter(Variable("k", "1", "", start=0.5))
    gain: AnyScalar = r.time if of_time else k
    r.rate("x", u - x if driven else -x)
    r.output(Variable("y", "1", ""), gain * u + 1.0)
    return compose("whole", {"a": r.program()}, [Connection(("a", "y"), ("a", "u"))])


@pytest.mark.parametrize(
    ("method", "interval"),
    [*((method, 0.01) for method in METHODS), ("dop853", 0.03)],
)
def test_no_method_passes_a_pole(method: str, interval: float) -> None:
    """The gain is 1 at t = 1 s, at an output time or between two."""
    with pytest.raises(RunError, match=r"algebraic loop of a\.u is (close to )?singular"):
        simulate(looped(of_time=True), stop_time=2.0, output_interval=interval, method=method)


def test_a_pole_that_moves_nothing_is_told_at_its_time() -> None:
    program = looped(of_time=True, driven=False)
    with pytest.raises(RunError, match=r"a\.u is (close to )?singular"):
        simulate(program, stop_time=2.0, output_interval=0.25)
    beside = simulate(program, stop_time=2.0, output_interval=0.3)
    assert beside["a.y"][-1] == pytest.approx(-1.0, rel=1e-14)


@pytest.mark.parametrize("gain", [1.0, 1.0 - 1e-16, 1.0 - 1e-12])
def test_a_parameter_that_makes_a_loop_singular(gain: float) -> None:
    program, at = looped(), {"a.k": gain}
    told = r"whole: the algebraic loop of a\.u is singular"
    with pytest.raises(RunError, match=told):
        simulate(program, stop_time=1.0, start_values=at)
    with pytest.raises(RunError, match=told):
        linearize(program, at=at)
    with pytest.raises(RunError, match=told):
        equilibrium(program, at=at)
    with pytest.raises(RunError, match=told):
        sensitivity(program, of=["a.y"], by=["a.k"], at=at)


def test_gains_near_one_are_solved() -> None:
    program = looped()
    found = simulate(program, stop_time=1.0, start_values={"a.k": 1.0 + 1e-6})
    assert found["a.y"][-1] == pytest.approx(-1e6, rel=1e-9)
    assert linearize(program, at={"a.k": 0.999}, inputs=["a.k"]).B[0, 0] == pytest.approx(1e6)
