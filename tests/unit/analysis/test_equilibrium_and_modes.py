"""Equilibria, eigenvalues and frequency responses of systems that can be solved by hand."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.analysis import (
    eigenvalue_sensitivity,
    equilibrium,
    frequency_response,
    linearize,
    modes,
    sensitivity,
    trajectory_sensitivity,
)
from m4e_fmi.analysis.response.linear_equations import Held
from m4e_fmi.cli import main
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.model import Body, Joint, Model, Parameter, Point, TensionDamper, TensionSpring
from m4e_fmi.model.elements import Quantity
from m4e_fmi.program import Program, Recorder, Variable

G = 9.81


def hung(*, damping: float = 0.0, stiffness: float = 200.0) -> Model:
    """2 kg on a vertical rail, on a spring of 1 m from the ceiling at Z = 0."""
    return Model(
        name="hung",
        gravity=G,
        bodies={"mass": Body(2.0, 1.0)},
        joints={"rail": Joint("prismatic", "mass", direction=(0, -1), initial={"q": 1.3})},
        points={"hook": Point("ground", (0, 0)), "eye": Point("mass", (0, 0))},
        loads={
            "spring": TensionSpring(("hook", "eye"), stiffness, 1.0),
            "damper": TensionDamper(("hook", "eye"), damping),
        },
    )


def pendulum(q: float = 0.0) -> Model:
    pin = Joint("revolute", "rod", joint_to_child=(0, -0.5), initial={"q": q})
    return Model("pendulum", {"rod": Body(2.0, 0.3)}, {"pin": pin}, gravity=G)


def floating(gravity: float = G) -> Model:
    """A body that nothing holds."""
    air = Joint("floating", "stone", initial={"x": 100.0})
    return Model("free", {"stone": Body(1e5, 1e5)}, {"air": air}, gravity=gravity)


def test_a_mass_on_a_spring_with_an_input() -> None:
    point = equilibrium(hung(), at={"joint.rail.u": 4.0})
    assert point["joint.rail.q"] == pytest.approx(1.0 + 2 * G / 200.0, rel=1e-14)
    assert point["joint.rail.u"] == 0.0
    point = equilibrium(hung(), at={"joint.rail.effort": 50.0})
    assert point["joint.rail.q"] == pytest.approx(1.0 + (2 * G + 50.0) / 200.0, rel=1e-14)
    linear = linearize(hung(), at=point)
    assert linear.point["joint.rail.effort"] == 50.0
    assert linear.rates == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("nearest", [False, True])
def test_a_pendulum_held_by_an_effort(nearest: bool) -> None:
    """sin θ = τ/(m g l); Newton alone would jump away. With τ > m g l no angle balances it."""
    at = {"joint.pin.effort": 0.9 * 2.0 * G * 0.5}
    point = equilibrium(pendulum(q=1.56), at=at, nearest=nearest)
    assert np.sin(point["joint.pin.q"]) == pytest.approx(0.9, rel=1e-12)
    assert nearest or point["joint.pin.q"] == pytest.approx(np.arcsin(0.9), rel=1e-12)
    with pytest.raises(RunError, match=r"no equilib.*joint\.pin\.u is") as lost:
        equilibrium(pendulum(q=0.3), at={"joint.pin.effort": 12.0}, nearest=nearest)
    assert "start nearer" in lost.value.remedy


@pytest.mark.parametrize("start", [0.1, 0.5 * np.pi, 3.0])
def test_a_pendulum_settles_below_and_stands_where_that_is_nearest(start: float) -> None:
    assert equilibrium(pendulum(q=start))["joint.pin.q"] == pytest.approx(0.0, abs=1e-14)
    point = equilibrium(pendulum(q=3.0), nearest=True)
    assert point["joint.pin.q"] == pytest.approx(np.pi, rel=1e-14)
    assert not modes(linearize(pendulum(), at=point)).stable
    assert modes(linearize(pendulum())).stable
    # a start that is an equilibrium is found as it is
    assert equilibrium(pendulum(q=np.pi))["joint.pin.q"] == np.pi


def test_a_mass_on_a_line() -> None:
    """100 t on a stiff line, held out level with the hook: l = l₀ + m g/k below it."""
    ends = {"hook": Point("ground", (0, 0)), "eye": Point("stone", (0, 0.01))}
    line = TensionSpring(("hook", "eye"), 1e7, 100.5)
    found = equilibrium(replace(floating(), points=ends, loads={"line": line}))
    assert found["body.stone.x"] == pytest.approx(0.0, abs=1e-12)
    assert found["body.stone.theta"] == pytest.approx(0.0, abs=1e-12)
    assert found["body.stone.z"] == pytest.approx(-(100.5 + 1e5 * G / 1e7) - 0.01, rel=1e-13)
    with pytest.raises(RunError, match=r"nothing holds it there.*stone\.vz is -9\.81 m/s2"):
        equilibrium(floating())


def test_what_nothing_holds_stays_where_it_is() -> None:
    """A cart with a pendulum: the cart is at rest anywhere; settling takes it along."""
    model = Model(
        name="cart",
        gravity=G,
        bodies={"cart": Body(1.0, 1.0), "rod": Body(1.0, 0.1)},
        joints={
            "rail": Joint("prismatic", "cart", direction=(1, 0), initial={"q": 7.0}),
            "pin": Joint("revolute", "rod", "cart", joint_to_child=(0, -0.5), initial={"q": 0.4}),
        },
    )
    point = equilibrium(model, nearest=True)
    assert point["joint.rail.q"] == pytest.approx(7.0, abs=1e-12)
    assert point["joint.pin.q"] == pytest.approx(0.0, abs=1e-13)
    assert equilibrium(model)["joint.rail.q"] == pytest.approx(6.9, abs=0.03)


BARS = {
    "hinge": Joint("revolute", "bar", axis=(0, 1, 0)),
    "ball": Joint("spherical", "bar"),
    "universal": Joint("universal", "bar", axis=(0, 1, 0), second_axis=(0, 0, 1)),
}
COORDINATE = {"hinge": "q", "ball": "theta", "universal": "q1", "plane": "q"}


@pytest.mark.parametrize("nearest", [False, True])
@pytest.mark.parametrize("start", [0.0, 1e-9, 1e-5, 3.0])
@pytest.mark.parametrize("kind", COORDINATE)
def test_bars_held_out_level_fall(kind: str, start: float, nearest: bool) -> None:
    """There, to first order, no turn changes what gravity does."""
    initial: dict[str, Quantity] = {COORDINATE[kind]: start}
    if kind == "plane":
        bodies = {"bar": Body(2.0, 0.1), "next": Body(1.0, 0.1)}
        first = Joint("revolute", "bar", joint_to_child=(1.0, 0.0), initial=initial)
        second = Joint("revolute", "next", "bar", (1.0, 0.0), (1.0, 0.0), initial=initial)
        model = Model(name="bars", bodies=bodies, joints={"pin": first, "knee": second})
    else:
        pin = replace(BARS[kind], joint_to_child=(1.0, 0.0, 0.0), initial=initial)
        bar = Body(2.0, (0.1, 0.1, 0.1))
        model = Model(name="bar", bodies={"bar": bar}, joints={"pin": pin}, dimensions=3)
    point = equilibrium(model, nearest=nearest)
    if kind == "ball":
        sine = 2 * point["joint.pin.e0"] * point["joint.pin.e2"]
    else:
        sine = np.sin(point[f"joint.pin.{COORDINATE[kind]}"])
    assert sine == pytest.approx(1.0, abs=1e-12)  # it hangs down


def test_states_without_velocity() -> None:
    r = Recorder("tank", "two tanks")
    flow = r.input(Variable("flow", "m3/s", "inflow", start=2.0))
    a = r.state(Variable("a", "m", "level", start=1.0))
    b = r.state(Variable("b", "m", "level", start=1.0))
    r.rate("a", flow - (a - b))
    r.rate("b", (a - b) - b * b)
    point = equilibrium(r.program())
    assert point["b"] == pytest.approx(2.0**0.5, rel=1e-13)
    assert point["a"] == pytest.approx(2.0 + 2.0**0.5, rel=1e-13)


def test_other_states_come_last() -> None:
    r = Recorder("actuator", "a mass behind a slow actuator")
    command = r.input(Variable("command", "N", "command"))
    force = r.state(Variable("force", "N", "force"))
    x = r.state(Variable("x", "m", "position"))
    v = r.state(Variable("v", "m/s", "velocity", derivative_of="x"))
    r.rate("force", (command - force) / 0.5)
    r.rate("x", v)
    r.rate("v", force - 4.0 * x)
    linear = linearize(r.program(), inputs=["command"])
    assert [v.name for v in linear.states] == ["x", "v", "force"]
    assert np.array_equal(linear.C, np.eye(3))  # outputs are the states
    assert np.array_equal(linear.A, [[0, 1, 0], [-4, 0, 1], [0, 0, -2]])
    assert np.array_equal(linear.B, [[0], [0], [2]])
    assert linear.mechanical is None


def test_rates_that_jump_by_rounding() -> None:
    """x is seen in steps of 1.2e-10 only, and 0.3 is not among them."""
    r = Recorder("coarse", "a rate with cancellation")
    x = r.state(Variable("x", "m", "level", start=2.0))
    r.rate("x", 0.3 - ((x + 1e6) - 1e6))
    assert equilibrium(r.program())["x"] == pytest.approx(0.3, abs=2e-10)


def test_a_program_without_states() -> None:
    r = Recorder("gain", "a gain")
    r.output(Variable("y", "1", "output"), 2.0 * r.input(Variable("u", "1", "input", start=3.0)))
    program = r.program()
    linear = linearize(program, at=equilibrium(program), inputs=["u"], outputs=["y"])
    assert (linear.D, linear.values) == (2.0, 6.0)
    assert modes(linear).eigenvalues.size == 0
    assert frequency_response(linear, 1.0).of("y", "u") == 2.0


def test_order_and_shapes_of_modes() -> None:
    """Two equal masses between walls, springs k, κ, k: in phase first, then against."""
    found = modes(linearize(two_masses()))
    assert found.frequencies == pytest.approx([2.0, np.sqrt(4.0 + 2 * 1.5)], rel=1e-13)
    assert found.shapes == pytest.approx(np.array([[1.0, 1.0], [1.0, -1.0]]), abs=1e-12)
    assert np.abs(found.left.conj().T @ found.right) == pytest.approx(np.eye(2), abs=1e-12)
    free = modes(linearize(floating(gravity=0.0)))
    assert np.array_equal(free.eigenvalues, np.zeros(6))
    assert np.isnan(free.damping_ratios).all()
    assert free.stable


def test_modes_of_a_pendulum_in_space() -> None:
    """A body that is not round on a ball joint: small rotations in place of its quaternion."""
    mass, arm, moments = 2.0, 1.5, (0.3, 0.4, 0.2)
    hook = Joint("spherical", "bob", joint_to_child=(0, 0, -arm))
    model = Model("p", {"bob": Body(mass, moments)}, {"hook": hook}, dimensions=3, gravity=G)
    linear = linearize(model)
    names = [f"rotation_{axis}" for axis in "xyz"] + ["omega_x", "omega", "omega_z"]
    assert [v.name for v in linear.states] == [f"joint.hook.{name}" for name in names]
    found = sorted(abs(value) for value in modes(linear).eigenvalues)
    exact = [np.sqrt(mass * G * arm / (m + mass * arm**2)) for m in moments[:2]]
    np.testing.assert_allclose(found, [0, 0, *sorted(exact)], atol=1e-12)


def two_masses() -> Program:
    r = Recorder("two", "two masses of 1 kg")
    push = r.input(Variable("push", "N", "force on the first"))
    a, b = (r.state(Variable(n, "m", "position")) for n in "ab")
    va, vb = (r.state(Variable(f"v{n}", "m/s", "v", derivative_of=n)) for n in "ab")
    between = 1.5 * (b - a)
    r.rate("a", va)
    r.rate("b", vb)
    r.rate("va", push - 4.0 * a + between)
    r.rate("vb", -4.0 * b - between)
    return r.program()


def test_the_response_of_one_mass() -> None:
    """1/(k − m ω² + iωc): with e^{+iωt} the motion lags."""
    linear = linearize(hung(damping=4.0), at=equilibrium(hung()), inputs=["joint.rail.effort"])
    omega = np.array([0.0, 5.0, 10.0, 20.0])
    found = frequency_response(linear, omega)
    expected = 1 / (200.0 - 2 * omega**2 + 4j * omega)
    assert found.values.shape == (4, 2, 1)
    response = found.of("joint.rail.q", "joint.rail.effort")
    assert response == pytest.approx(expected, rel=1e-12)
    assert (response.imag <= 0).all()
    assert found.of("joint.rail.u", "joint.rail.effort") == pytest.approx(1j * omega * expected)
    assert found.unit("joint.rail.q", "joint.rail.effort") == "(m)/(N)"
    with pytest.raises(InputError, match="there is no pull"):
        found.of("joint.rail.q", "pull")


def test_an_undamped_resonance() -> None:
    """A free mass at ω = 0, which is one of its natural frequencies to the last bit."""
    r = Recorder("free", "a free mass of 1 kg")
    push = r.input(Variable("push", "N", "force"))
    r.state(Variable("x", "m", "position"))
    v = r.state(Variable("v", "m/s", "velocity", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", push)
    linear = linearize(r.program(), inputs=["push"])
    assert frequency_response(linear, 2.0).of("x", "push") == pytest.approx(-0.25)
    with pytest.raises(RunError, match="undamped natural frequency"):
        frequency_response(linear, [1.0, 0.0])


def test_what_moves_away_for_ever_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A hinge with −50 N·m/rad, as of a ship without stability: upright is the nearest."""
    text = "name: capsizing\ngravity: 0\nbodies: {ship: {mass: 1, inertia: 1}}\n"
    text += "joints: {roll: {type: revolute, child: ship, initial: {q: 0.1}}}\n"
    text += "loads: {water: {type: joint_effort, joint: roll, effort: 50*joint.roll.q}}\n"
    path = tmp_path / "ship.model.yaml"
    path.write_text(text, encoding="utf-8")
    assert main(["equilibrium", str(path)]) == 1
    told = capsys.readouterr().err
    assert "at the start it is unstable: a negative stiffness moves joint.roll.q away" in told
    assert "or take --nearest" in told
    assert main(["equilibrium", str(path), "--nearest", "--json"]) == 0
    told = capsys.readouterr().err
    assert told.count(f"note: the equilibrium is unstable: a motion grows ({50**0.5:.3g} 1/s)") == 1


def test_a_mean_moves_where_it_is_held_only() -> None:
    """Place and velocity of a body on a spring, and of one that nothing holds in place.

    A mean that a sea sets free would pass for settled: its step is not zero.
    """
    spring = np.array([[0.0, 1, 0, 0], [-4.0, -0.3, 0, 0], [0, 0, 0, 1.0], [0, 0, 0, -0.2]])
    change = np.array([0.0, 2.0, 0.0, 0.0])
    step = Held.by(spring).step(spring, change)
    np.testing.assert_allclose(step, [0.5, 0.0, 0.0, 0.0], atol=1e-15)
    free = spring.copy()
    free[1, 0] = 0.0
    with pytest.raises(RunError, match="does not hold it in this sea"):
        Held.by(spring).step(free, change)


def test_results_are_printed_as_tables_with_units() -> None:
    """A pendulum of one link, m g L/2 over J + m (L/2)² = 3 g/(2 L)."""
    model = Model(
        "link",
        parameters={"L": Parameter(2, "m")},
        bodies={"link": Body(1.0, "L**2/12")},
        joints={"pin": Joint("revolute", "link", joint_to_child=(0, "-L/2"))},
        gravity=9.81,
    )
    linear = linearize(model, inputs=["joint.pin.effort"])
    assert re.search(r"\n +1 +2\.71247 +0\.431703 +0 ", repr(modes(linear)).replace("-0 ", "0 "))
    found = sensitivity(model, of=["der(joint.pin.u)"], by=["joint.pin.q", "L"])
    assert re.search(r"pin\.u\)\) +/ d\(joint\.pin\.q\) +-7\.3575 +rad/s2/rad", repr(found))
    change = repr(eigenvalue_sensitivity(model, by=["L"]))
    assert re.search(
        r"mode 1, 2\.71247 rad/s: +d\|λ\| / d\(L\) +-0\.67811\d +\(rad/s\)/\(m\)", change
    )
    course = trajectory_sensitivity(model, of=["joint.pin.q"], by=["joint.pin.q"], stop_time=0.1)
    assert re.search(r"/ d\(joint\.pin\.q\) +0\.9634\d* +1 +rad/rad", repr(course))
