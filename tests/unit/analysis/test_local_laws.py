"""Points of programs with parts whose equations hold about a point only, and notes on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, modes, trimmed
from m4e_fmi.analysis.rest_notes import growth, rest_notes
from m4e_fmi.errors import RunError
from m4e_fmi.program import Connection, Program, Recorder, Variable, compose
from m4e_fmi.report import linear_json, linear_text
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.limits import limits_left

Law = Callable[[float], tuple[float, float]]
"""Force [N] and its slope [N/m] at a place [m]."""
MASS, STIFFNESS = 2.0, 3.0
TOO_SOFT = 1e-4
"""By how much the slope of a law is more than the stiffness [N/m]."""


def cubic(x: float) -> tuple[float, float]:
    return -4.0 * x**3, -12.0 * x**2


def undoing(x: float) -> tuple[float, float]:
    return (STIFFNESS + TOO_SOFT) * x, STIFFNESS + TOO_SOFT


class Tangent:
    """A force of the place, known by its tangent, whose slope has an `error` [N/m]."""

    def __init__(self, law: Law, error: float = 0.0) -> None:
        self.law, self.asked = law, list[float]()
        self.errors = {"slope": error}

    def parameters_at(self, inputs: Mapping[str, float]) -> Mapping[str, float]:
        self.asked.append(inputs["x"])
        force, slope = self.law(inputs["x"])
        return {"x0": inputs["x"], "y0": force, "slope": slope}


def system(law: Law, *, start: float = 0.0, pull: float = 10.0, error: float = 0.0) -> Program:
    """A mass on a spring of 3 N/m, pulled by 10 N and by the law."""
    r = Recorder("tangent", "")
    x = r.input(Variable("x", "m", ""))
    x0, y0 = (r.parameter(Variable(name, "1", "")) for name in ("x0", "y0"))
    slope = r.parameter(Variable("slope", "N/m", ""))
    r.output(Variable("force", "N", ""), y0 + slope * (x - x0))
    tangent = r.program()
    r = Recorder("mass", "")
    given = r.parameter(Variable("pull", "N", "", start=pull))
    force = r.input(Variable("force", "N", ""))
    x = r.state(Variable("x", "m", "", start=start))
    v = r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", (given + force - STIFFNESS * x) / MASS)
    return compose(
        "whole",
        {"mass": r.program(), "law": tangent},
        [
            Connection(("mass", "x"), ("law", "x")),
            Connection(("law", "force"), ("mass", "force")),
        ],
        origins={"law": Tangent(law, error)},
    )


def root(pull: float) -> float:
    """x of pull = 3 x + 4 x³."""
    (found,) = (z.real for z in np.roots([4.0, 0.0, STIFFNESS, -pull]) if abs(z.imag) < 1e-12)
    return float(found)


@pytest.mark.parametrize("nearest", [True, False])
def test_the_equilibrium_is_that_of_the_law_itself(nearest: bool) -> None:
    point = equilibrium(system(cubic), nearest=nearest)
    assert point["mass.x"] == pytest.approx(root(10.0), rel=1e-8)
    assert point["law.slope"] == pytest.approx(-12.0 * root(10.0) ** 2, rel=1e-7)
    law = point.program.parts[1].origin
    assert isinstance(law, Tangent)
    count = len(law.asked)
    linearize(point.program, at=point)
    assert len(law.asked) == count  # a point keeps its law
    point = trimmed(system(cubic), such_that={"mass.x": 1.5}, vary=["mass.pull"])
    assert point["mass.pull"] == pytest.approx(STIFFNESS * 1.5 + 4.0 * 1.5**3, rel=1e-8)


def test_linear_equations_have_the_slope_of_their_point() -> None:
    program = system(cubic)
    for at, x in (({"mass.x": 0.7}, 0.7), (equilibrium(program), root(10.0)), (None, 0.0)):
        stiffness = STIFFNESS + 12.0 * x**2
        assert linearize(program, at=at).A[1, 0] == pytest.approx(-stiffness / MASS, rel=1e-7)


def test_steps_that_lead_too_far_are_shortened() -> None:
    """Newton's method alone diverges on this force from here: its steps grow from side to side."""
    program = system(lambda x: (-50.0 * np.arctan(x), -50.0 / (1.0 + x * x)), start=8.0)
    assert abs(10.0 - 3.0 * (x := equilibrium(program)["mass.x"]) - 50.0 * np.arctan(x)) < 1e-5


def test_a_force_that_is_nowhere_in_balance() -> None:
    """It pulls to the right left of 3 m, and to the left right of it."""
    program = system(lambda x: (2.0 if x < 3.0 else -2.0, 0.0))
    with pytest.raises(RunError, match=r"no equilibrium with law was found.* of a state"):
        equilibrium(program)


def test_a_law_that_fails_is_told() -> None:
    def law(x: float) -> tuple[float, float]:
        if x > 1.0:
            raise RunError(f"the line has parted at {x:g} m", "a longer one")
        return 0.0, 0.0

    with pytest.raises(RunError, match=r"no equilibrium with law.* the line has parted at"):
        equilibrium(system(law))
    with pytest.raises(RunError, match=r"^the line has parted at 2 m"):
        linearize(system(law), at={"mass.x": 2.0})


@pytest.mark.parametrize("error", [0.9 * TOO_SOFT, 1.1 * TOO_SOFT, 300.0])
def test_growth_that_an_error_of_a_law_may_be(error: float) -> None:
    program = system(undoing, pull=0.0, error=error)
    linear = linearize(program, at=equilibrium(program, nearest=True))
    found, neutral = growth(linear), error > TOO_SOFT
    assert found is not None
    assert found.rate == pytest.approx(math.sqrt(TOO_SOFT / MASS), rel=1e-6)
    kind = "neutral within the error of K of law" if neutral else "UNSTABLE"
    told = f"{kind}: a motion grows (0.00707 1/s)"
    assert told in linear_text(linear, modes(linear), title="start")
    assert linear_json(linear, modes(linear))["neutral"] is neutral
    (line,) = rest_notes(linear.point)
    assert line.startswith("neutral" if neutral else "the equilibrium is unstable")


@pytest.mark.parametrize(("pull", "told"), [(10.0, False), (-30.0, True), (30.0, True)])
def test_outputs_beyond_their_limits_are_told(pull: float, told: bool) -> None:
    """A draft of pull over stiffness, which linear water knows up to ±7.5 m."""
    r = Recorder("water", "")
    x = r.state(Variable("x", "m", ""))
    v = r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", pull - STIFFNESS * x - v)
    r.output(Variable("heave", "m", "small motions", minimum=-7.5, maximum=7.5), x)
    line = f"heave: {pull / STIFFNESS:.3g} m is outside of its limits, -7.5 to 7.5 m: small motions"
    assert rest_notes(equilibrium(r.program())) == ([line] if told else [])


def test_outputs_that_leave_their_limits_in_motion_are_told_with_the_first_time() -> None:
    """Of 2 m/s from -1 m: up to 0.5 m in 0.75 s; a limit of just what is reached is kept."""
    r = Recorder("drift", "")
    x = r.state(Variable("x", "m", "", start=-1.0))
    r.rate("x", 2.0)
    r.output(Variable("near", "m", "place", minimum=-2.0, maximum=0.5), x)
    r.output(Variable("far", "m", "place", minimum=-1.0, maximum=1.0), x)
    (told,) = limits_left(simulate(r.program(), stop_time=1.0, output_interval=0.1))
    assert told == "near is 0.6 m at t = 0.8 s, outside of its limits, -2 to 0.5 m: place"
