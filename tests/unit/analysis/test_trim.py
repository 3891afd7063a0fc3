"""Equilibria with given properties, against statics by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from m4e_fmi.analysis import linearize, modes, trimmed
from m4e_fmi.errors import M4eError, RunError
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
    """Statics by hand: the elbow carries half a link, the shoulder that and one and a half.

    These are 4.1274 and 17.5077 N.m.
    """
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


def sprung(m: float = 1.0) -> Model:
    """The double pendulum with springs in its joints and a damper at the shoulder."""
    plain = pendulum()
    parameters = {
        "k1": Parameter(1.0, "N.m/rad"),
        "k2": Parameter(1.0, "N.m/rad"),
        "c": Parameter(0.1, "N.m.s/rad"),
    }
    loads = {
        "first": JointEffort("shoulder", "-k1*joint.shoulder.q - c*joint.shoulder.u"),
        "second": JointEffort("elbow", "-k2*joint.elbow.q"),
    }
    bodies = {name: Body(m, 0.1) for name in plain.bodies}
    return Model("sprung", bodies, plain.joints, parameters=parameters, loads=loads, gravity=G)


def test_stiffness_for_a_frequency() -> None:
    """A mass m on a spring k: omega² = k/m; the block has 2 kg, the bob a higher frequency."""
    block = model()
    loads = {**block.loads, "spring": JointEffort("rail", "push - c*joint.rail.q")}
    parameters = {**block.parameters, "c": Parameter(5.0, "N/m"), "k": Parameter(9e3, "N.m/rad")}
    block = replace(block, loads=loads, parameters=parameters)
    point = trimmed(block, such_that={"mode 1": "2 Hz"}, vary=["c"])
    assert point["c"] == pytest.approx(2.0 * (4.0 * math.pi) ** 2, rel=1e-9)


@pytest.mark.parametrize(("first", "second"), [("k1", "k2"), ("k2", "k1"), ("k1", "c")])
def test_two_frequencies_by_two_parameters(first: str, second: str) -> None:
    """Those of other parameters, found again by the names that linearize has."""
    start = {"k1": 30.0, "k2": 12.0, "c": 2.0}
    goal = modes(linearize(sprung(), at={**start, first: 41.0, second: 7.0})).frequencies
    wanted = {f"mode {k} frequency": f"{float(goal[k - 1])!r} rad/s" for k in (2, 1)}
    point = trimmed(sprung(), such_that=wanted, vary=[first, second], at=start)
    found = modes(linearize(sprung(), at=point)).frequencies
    assert found == pytest.approx(goal, rel=1e-8)
    assert point[first] == pytest.approx(41.0, rel=1e-6)


def test_frequency_damping_ratio_and_place_at_once() -> None:
    """m q̈ + c q̇ + k q = push: k = m omega², c = 2 zeta m omega, push = k q."""
    block = Model(
        "block",
        {"block": Body(2.0, 1.0)},
        {"rail": Joint("prismatic", "block", direction=(1.0, 0.0))},
        parameters={name: Parameter(1.0, unit) for name, unit in UNITS.items()},
        loads={"all": JointEffort("rail", "push - k*joint.rail.q - c*joint.rail.u")},
    )
    wanted = {"mode 1 damping": "5 %", "joint.rail.q": "3 cm", "mode 1 frequency": "0.5 Hz"}
    point = trimmed(block, such_that=wanted, vary=["push", "c", "k"])
    stiffness = 2.0 * math.pi**2
    assert point["k"] == pytest.approx(stiffness, rel=1e-9)
    assert point["c"] == pytest.approx(2 * 0.05 * 2.0 * math.pi, rel=1e-8)
    assert point["push"] == pytest.approx(0.03 * stiffness, rel=1e-9)


def test_a_mode_keeps_its_number_not_its_shape() -> None:
    """The block (100 N/m, 2 kg) stays mode 1 or 2: mode 1 is never faster than it."""
    with pytest.raises(RunError, match=r"mode 1 frequency \[Hz\] = 1\.12\d* instead of 2 "):
        trimmed(model(), such_that={"mode 1": "2 Hz"}, vary=["k"])


UNITS = {"k": "N/m", "c": "N.s/m", "push": "N"}
MODES: tuple[tuple[dict[str, float | str], str], ...] = (
    ({"mode 9": "2 Hz"}, "no mode 9 among its 2(.|\n)*linearize"),
    ({"mode 1 frequency": 2.0}, "it has no unit: write '2.0 Hz'"),
    ({"mode 1": "2 kg"}, "it is in Hz: kg is not 1/s"),
    ({"mode 1": "0 Hz"}, "between 0 and inf"),
    ({"mode 1 damping": 1.5}, "between -1 and 1"),
    ({"mode one": 1.0}, "'mode one' names nothing of a mode(.|\n)*write 'mode 1 frequency'"),
    ({"mode 2 frequency": "90 Hz", "mode 1 frequency": "89 Hz"}, r"instead of 90.* = \d.*k1 = \d"),
)


@pytest.mark.parametrize(("such_that", "said"), MODES)
def test_modes_that_cannot_be(such_that: dict[str, float | str], said: str) -> None:
    with pytest.raises(M4eError, match=said):
        trimmed(sprung(), such_that=such_that, vary=["k1", "k2"][: len(such_that)])


def test_a_mode_that_does_not_oscillate() -> None:
    with pytest.raises(RunError, match="mode 1 does not oscillate"):
        trimmed(sprung(), such_that={"mode 1": "1 Hz"}, vary=["k2"], at={"c": 1e3})


def test_frequencies_that_stay_equal() -> None:
    """Two equal oscillators: neither mode has a derivative, but both move together."""
    rail = Joint("prismatic", "one", direction=(1.0, 0.0))
    pair = Model(
        "pair",
        {name: Body(2.0, 1.0) for name in ("one", "two")},
        {"one": rail, "two": replace(rail, child="two")},
        parameters={"k": Parameter(3.0, "N/m")},
        loads={name: JointEffort(name, f"-k*joint.{name}.q") for name in ("one", "two")},
    )
    point = trimmed(pair, such_that={"mode 2": "1 Hz"}, vary=["k"])
    assert point["k"] == pytest.approx(8.0 * math.pi**2, rel=1e-9)
