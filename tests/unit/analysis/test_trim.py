"""Equilibria with given properties, against statics by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.analysis import equilibrium, trimmed
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.model import Body, Joint, JointEffort, Model, Parameter, load_model
from m4e_fmi.program import Program, Recorder, Scalar, Variable, sqrt

G = 9.81
ARM = Path(__file__).parents[3] / "examples" / "arm" / "arm.urdf"


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


def test_one_parameter_for_one_value() -> None:
    point = trimmed(model(), such_that={"joint.hinge.q": 0.3}, vary=["m"])
    # the bob hangs at an angle q below the horizontal: m g 0.5 cos q = k q
    assert point["m"] == pytest.approx(20 * 0.3 / (G * 0.5 * math.cos(0.3)), rel=1e-9)
    assert point["joint.hinge.q"] == pytest.approx(0.3, abs=1e-9)


def test_two_at_once_with_units() -> None:
    wanted = {"joint.hinge.q": "20 deg", "joint.rail.q": "-4 cm"}
    point = trimmed(model(), such_that=wanted, vary=["push", "k"])
    angle = math.radians(20)
    assert point["push"] == pytest.approx(-4.0, rel=1e-9)
    assert point["k"] == pytest.approx(G * 0.5 * math.cos(angle) / angle, rel=1e-9)


def test_limits_of_parameters_hold() -> None:
    """No mass lifts the bob: the search ends with a mass that is not negative."""
    with pytest.raises(RunError, match=r"no equilibrium with these values .* m = \d"):
        trimmed(model(), such_that={"joint.hinge.q": -0.3}, vary=["m"])


def test_a_parameter_without_effect() -> None:
    with pytest.raises(RunError, match="do not change them one by one"):
        trimmed(model(), such_that={"joint.hinge.q": 0.3}, vary=["push"])


def test_counts_and_values_are_told_together() -> None:
    with pytest.raises(InputError) as caught:
        trimmed(model(), such_that={"joint.rail.q": "4 kg"}, vary=["push", "k"])
    text = str(caught.value)
    assert "kg is not m" in text
    assert "1 values are given, 2 parameters may vary" in text


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


def test_efforts_hold_an_arm_against_its_potential_energy() -> None:
    """Efforts are the derivatives of the potential energy by the angles."""
    model = load_model(ARM)
    pose = {f"joint.{name}.q": 0.3 * k - 0.7 for k, name in enumerate(model.joints)}
    vary = [f"joint.{name}.effort" for name in model.joints]
    point = trimmed(model, such_that=pose, vary=vary)
    for angle, effort in zip(pose, vary, strict=True):
        ahead, back = (
            point.with_values({angle: pose[angle] + step})["energy.potential"]
            for step in (1e-4, -1e-4)
        )
        assert point[effort] == pytest.approx((ahead - back) / 2e-4, abs=1e-5)


def test_a_pose_that_the_efforts_do_not_hold() -> None:
    pose = {"joint.shoulder.q": 2.0, "joint.elbow.q": 1.0}
    twice = ["joint.elbow.effort", "body.lower.force_x"]
    with pytest.raises(RunError, match=r"do not change them one by one.* instead of 1"):
        trimmed(pendulum(), such_that=pose, vary=["joint.shoulder.effort", "body.upper.moment_y"])
    assert trimmed(pendulum(), such_that=pose, vary=twice)["joint.elbow.q"] == 1.0


def thruster(law: Callable[[Scalar], Scalar]) -> Program:
    """1 kg on a spring of 4 N/m, pushed by a law of the speed n; m pushes nothing."""
    r = Recorder("thruster", "")
    n, m = (r.input(Variable(name, "rad/s", "", start=1.0)) for name in ("n", "m"))
    x, v = r.state(Variable("x", "m", "")), r.state(Variable("v", "m/s", "", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", law(n) + 0.0 * m - 4.0 * x - 0.5 * v)
    return r.program()


@pytest.mark.parametrize("x", [0.0625, 1.0, 9.0])
def test_a_force_that_is_not_linear_in_its_input(x: float) -> None:
    point = trimmed(thruster(lambda n: n * n), such_that={"x": x}, vary=["n"])
    assert point["n"] == pytest.approx(2.0 * math.sqrt(x), rel=1e-9)


def test_a_search_that_leaves_where_a_law_holds() -> None:
    """Newton's step from n = 1 to the root of n = 0 is to n = -1, where there is no force."""
    point = trimmed(thruster(sqrt), such_that={"x": 0.05}, vary=["n"])
    assert point["n"] == pytest.approx(0.2**2, rel=1e-6)


def test_a_pose_that_nothing_holds() -> None:
    for law, vary in ((lambda n: n * n, "m"), (lambda n: -n * n, "n")):
        with pytest.raises(RunError, match=r"no equilibrium with these values.* instead of 1"):
            trimmed(thruster(law), such_that={"x": 1.0}, vary=[vary])


def test_outputs_of_an_equilibrium() -> None:
    point = equilibrium(pendulum())
    assert point["body.lower.z"] == pytest.approx(-1.5, rel=1e-9)
    with pytest.raises(InputError, match="no state, input, parameter or output"):
        point["body.lower.zz"]
