"""Points of programs with parts whose equations hold about a point only."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, trimmed
from m4e_fmi.errors import RunError
from m4e_fmi.program import Connection, Program, Recorder, Variable, compose

Law = Callable[[float], tuple[float, float]]
"""Force [N] and its slope [N/m] at a place [m]."""
MASS, STIFFNESS = 2.0, 3.0


def cubic(x: float) -> tuple[float, float]:
    return -4.0 * x**3, -12.0 * x**2


class Tangent:
    """A force of the place, known by its tangent."""

    def __init__(self, law: Law, error: float = 0.0) -> None:
        self.law, self.asked = law, list[float]()
        self.errors = {"slope": error}

    def parameters_at(self, inputs: Mapping[str, float]) -> Mapping[str, float]:
        self.asked.append(inputs["x"])
        force, slope = self.law(inputs["x"])
        return {"x0": inputs["x"], "y0": force, "slope": slope}


def tangent() -> Program:
    r = Recorder("tangent", "")
    x = r.input(Variable("x", "m", ""))
    x0, y0 = (r.parameter(Variable(name, "1", "")) for name in ("x0", "y0"))
    slope = r.parameter(Variable("slope", "N/m", ""))
    r.output(Variable("force", "N", ""), y0 + slope * (x - x0))
    return r.program()


def system(law: Law, *, start: float = 0.0, error: float = 0.0) -> Program:
    """A mass on a spring of 3 N/m, pulled by 10 N and by the law, whose slope has an `error`."""
    r = Recorder("mass", "")
    pull = r.parameter(Variable("pull", "N", "", start=10.0))
    force = r.input(Variable("force", "N", ""))
    x = r.state(Variable("x", "m", "", start=start))
    v = r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", (pull + force - STIFFNESS * x) / MASS)
    return compose(
        "whole",
        {"mass": r.program(), "law": tangent()},
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


def test_linear_equations_have_the_slope_of_their_point() -> None:
    program = system(cubic)
    for at, x in (({"mass.x": 0.7}, 0.7), (equilibrium(program), root(10.0)), (None, 0.0)):
        stiffness = STIFFNESS + 12.0 * x**2
        assert linearize(program, at=at).A[1, 0] == pytest.approx(-stiffness / MASS, rel=1e-7)


def test_a_given_property() -> None:
    point = trimmed(system(cubic), such_that={"mass.x": 1.5}, vary=["mass.pull"])
    assert point["mass.pull"] == pytest.approx(STIFFNESS * 1.5 + 4.0 * 1.5**3, rel=1e-8)


def test_steps_that_lead_too_far_are_shortened() -> None:
    """Newton's method alone diverges on this force from here: its steps grow from side to side."""
    program = system(lambda x: (-50.0 * np.arctan(x), -50.0 / (1.0 + x * x)), start=8.0)
    assert abs(10.0 - 3.0 * (x := equilibrium(program)["mass.x"]) - 50.0 * np.arctan(x)) < 1e-5


def test_a_force_that_is_nowhere_in_balance_is_named() -> None:
    """It pulls to the right left of 3 m, and to the left right of it."""
    program = system(lambda x: (2.0 if x < 3.0 else -2.0, 0.0))
    with pytest.raises(RunError) as caught:
        equilibrium(program)
    assert "no equilibrium with law was found" in caught.value.message
    told = caught.value.message.partition("of a state; ")[2]
    other = {"2": "-2", "-2": "2"}
    assert told in [f"law.force is {a} N there, and {b} N balances" for a, b in other.items()]


def test_a_law_that_fails_is_told() -> None:
    def law(x: float) -> tuple[float, float]:
        if x > 1.0:
            raise RunError(f"the line has parted at {x:g} m", "a longer one")
        return 0.0, 0.0

    with pytest.raises(RunError, match=r"no equilibrium with law.* the line has parted at"):
        equilibrium(system(law))
    with pytest.raises(RunError, match=r"^the line has parted at 2 m"):
        linearize(system(law), at={"mass.x": 2.0})


def test_a_point_keeps_its_law() -> None:
    program = system(cubic)
    point = equilibrium(program)
    law = program.parts[1].origin
    assert isinstance(law, Tangent)
    count = len(law.asked)
    linearize(program, at=point)
    assert len(law.asked) == count
