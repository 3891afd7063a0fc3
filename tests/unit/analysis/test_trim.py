"""Equilibria with given properties, against statics by hand."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from m4e_fmi.analysis import trimmed
from m4e_fmi.errors import M4eError
from m4e_fmi.model import Body, Joint, JointEffort, Model, Parameter
from m4e_fmi.program import Program, Recorder, Scalar, Variable, sqrt

G = 9.81


def model() -> Model:
    """A pendulum of mass m with a torsion spring k, and a mass on a spring with a constant push."""
    return Model(
        "two",
        {"bob": Body("m", 0.1), "block": Body(2.0, 1.0)},
        {
            "hinge": Joint("revolute", "bob", joint_to_child=(0.5, 0.0)),
            "rail": Joint("prismatic", "block", direction=(1.0, 0.0)),
        },
        parameters={
            "m": Parameter(1.0, "kg"),
            "k": Parameter(20.0, "N.m/rad"),
            "push": Parameter(0.0, "N"),
        },
        loads={
            "torsion": JointEffort("hinge", "-k*joint.hinge.q"),
            "spring": JointEffort("rail", "push - 100*joint.rail.q"),
        },
        gravity=G,
    )


def test_parameters_for_values_with_units() -> None:
    """The bob hangs at an angle q below the horizontal: m g 0.5 cos q = k q."""
    point = trimmed(model(), such_that={"joint.hinge.q": 0.3}, vary=["m"])
    assert point["m"] == pytest.approx(20 * 0.3 / (G * 0.5 * math.cos(0.3)), rel=1e-9)
    assert point["joint.hinge.q"] == pytest.approx(0.3, abs=1e-9)
    wanted = {"joint.hinge.q": "20 deg", "joint.rail.q": "-4 cm"}
    point = trimmed(model(), such_that=wanted, vary=["push", "k"])
    angle = math.radians(20)
    assert point["push"] == pytest.approx(-4.0, rel=1e-9)
    assert point["k"] == pytest.approx(G * 0.5 * math.cos(angle) / angle, rel=1e-9)


def pendulum() -> Model:
    """Two links of 1 kg and 1 m, one below the other."""
    down = (0.0, -0.5)
    joints = {
        "shoulder": Joint("revolute", "upper", joint_to_child=down),
        "elbow": Joint("revolute", "lower", "upper", parent_to_joint=down, joint_to_child=down),
    }
    return Model("double", {"upper": Body(1.0, 0.1), "lower": Body(1.0, 0.1)}, joints, gravity=G)


@pytest.mark.parametrize("second", ["joint.elbow.q", "body.lower.theta"])
def test_efforts_hold_a_pose_far_from_rest(second: str) -> None:
    """Statics by hand: the elbow carries half a link, the shoulder that and one and a half."""
    efforts = ["joint.shoulder.effort", "joint.elbow.effort"]
    point = trimmed(pendulum(), such_that={"joint.shoulder.q": 2.0, second: 1.0}, vary=efforts)
    lower = 0.5 * G * math.sin(1.0)
    assert point["joint.elbow.effort"] == pytest.approx(lower, rel=1e-12)
    upper = 1.5 * G * math.sin(2.0)
    assert point["joint.shoulder.effort"] == pytest.approx(upper + lower, rel=1e-12)


def thruster(law: Callable[[Scalar], Scalar]) -> Program:
    """1 kg on a spring of 4 N/m, pushed by a law of the speed n; m pushes nothing."""
    r = Recorder("thruster", "")
    n, m = (r.input(Variable(name, "rad/s", "", start=1.0)) for name in ("n", "m"))
    x, v = r.state(Variable("x", "m", "")), r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", law(n) + 0.0 * m - 4.0 * x - 0.5 * v)
    return r.program()


@pytest.mark.parametrize("x", [0.05, 0.0625, 1.0, 9.0])
def test_a_force_that_is_not_linear_in_its_input(x: float) -> None:
    """Newton's step from n = 1 for 0.05 m is to n = -1, where the root gives no force."""
    point = trimmed(thruster(lambda n: n * n), such_that={"x": x}, vary=["n"])
    assert point["n"] == pytest.approx(2.0 * math.sqrt(x), rel=1e-9)
    point = trimmed(thruster(sqrt), such_that={"x": x}, vary=["n"])
    assert point["n"] == pytest.approx((4.0 * x) ** 2, rel=1e-6)


POSE = {"joint.shoulder.q": 2.0, "joint.elbow.q": 1.0}
MOMENTS = ["joint.shoulder.effort", "body.upper.moment_y"]
NONE = r"no equilibrium with these values.*"


@pytest.mark.parametrize(
    ("system", "such_that", "vary", "said"),
    [
        (model(), {"joint.hinge.q": -0.3}, ["m"], NONE + r" m = \d"),  # no mass lifts the bob
        (model(), {"joint.hinge.q": 0.3}, ["push"], "do not change them one by one"),
        (model(), {"joint.rail.q": "4 kg"}, ["push", "k"],
         r"kg is not m(.|\n)*1 values are given, 2 parameters may vary"),
        (pendulum(), POSE, MOMENTS, r"do not change them one by one.* instead of 1"),
        (thruster(lambda n: n * n), {"x": 1.0}, ["m"], NONE + "instead of 1"),
    ],
)  # fmt: skip
def test_what_cannot_be_held(
    system: Model | Program, such_that: dict[str, float | str], vary: list[str], said: str
) -> None:
    with pytest.raises(M4eError, match=said):
        trimmed(system, such_that=such_that, vary=vary)
