"""Fixed joints against one body of the same mass, relative angles against absolute ones.

Both sides are double precision; see support/lagrange.py for the tolerance.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import sympy as sp
from support.lagrange import RELATIVE, Mechanism, assert_accelerations, forces, turned
from support.programs import Evaluated

from m4e_fmi.model import Body, Joint, Model, Point, TorsionDamper, TorsionSpring
from m4e_fmi.model.elements import AngleReference
from m4e_fmi.multibody import Equations, model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import tangent

ALGORITHMS = [Recursion, ClosedForm]


def welded() -> Model:
    """A pendulum of three bodies, the second welded to the first and the third to the second."""
    return Model(
        name="welded",
        gravity=9.81,
        bodies={"rod": Body(2.0, 0.3), "arm": Body(1.0, 0.1), "bob": Body(0.5, 0.05)},
        joints={
            "hinge": Joint("revolute", "rod", joint_to_child=(0.0, -1.0)),
            "elbow": Joint("fixed", "arm", "rod", (0.0, -1.0), (0.4, 0.0)),
            "end": Joint("fixed", "bob", "arm", (0.4, 0.0), (0.1, 0.2)),
        },
        points={"tip": Point("bob", (0.1, 0.0))},
    )


def lumped() -> tuple[float, float, float, float]:
    """Mass, centre of gravity from the hinge, and inertia about it of the same as one body."""
    parts = [(2.0, 0.0, -1.0, 0.3), (1.0, 0.4, -2.0, 0.1), (0.5, 0.9, -1.8, 0.05)]
    mass = sum(m for m, _, _, _ in parts)
    x = sum(m * px for m, px, _, _ in parts) / mass
    z = sum(m * pz for m, _, pz, _ in parts) / mass
    inertia = sum(j + m * ((px - x) ** 2 + (pz - z) ** 2) for m, px, pz, j in parts)
    return mass, x, z, inertia


@pytest.mark.verifies(
    "bodies that are welded together",
    analytic="one body of the same mass and inertia",
    tolerance="1e-10",
)
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_what_is_welded_together_moves_like_one_body(algorithm: type) -> None:
    mass, x, z, inertia = lumped()
    one = Model(
        name="one",
        gravity=9.81,
        bodies={"rod": Body(mass, inertia)},
        joints={"hinge": Joint("revolute", "rod", joint_to_child=(x, z))},
        points={"tip": Point("rod", (1.0 - x, -1.8 - z))},
    )
    state = {"joint.hinge.q": 0.7, "joint.hinge.u": -1.3, "point.tip.force_x": 2.5}
    model = welded()
    found, expected = (Evaluated(recorded(m, topology(m), algorithm)) for m in (model, one))
    u_dot = expected.rates(state)["joint.hinge.u"]
    assert found.rates(state)["joint.hinge.u"] == pytest.approx(u_dot, rel=RELATIVE)
    got, want = found.outputs(state), expected.outputs(state)
    for name in ("x", "z", "vx", "vz", "ax", "az"):
        assert got[f"point.tip.{name}"] == pytest.approx(want[f"point.tip.{name}"], rel=RELATIVE)
    assert got["energy.total"] == pytest.approx(want["energy.total"], rel=RELATIVE)
    assert got["body.bob.theta"] == 0.7
    assert got["body.bob.alpha"] == got["body.rod.alpha"]


def test_a_welded_body_has_no_coordinate_and_no_effort() -> None:
    program = model_program(welded())
    assert [v.name for v in program.states] == ["joint.hinge.q", "joint.hinge.u"]
    assert [v.name for v in program.inputs if v.name.startswith("joint")] == ["joint.hinge.effort"]
    assert Equations(welded()).B.shape == (9, 1)


def test_what_is_welded_to_the_ground_stands_still() -> None:
    """A pendulum on a post: its hinge is where the post puts it."""
    rod = {"rod": Body(1.0, 1.0)}
    hinge = Joint("revolute", "rod", "post", (0.0, 1.0), (0.0, -0.5))
    on_post = Model(
        name="post",
        bodies={**rod, "post": Body(7.0, 8.0)},
        joints={"hinge": hinge, "foot": Joint("fixed", "post", joint_to_child=(2.0, 1.0))},
        points={"top": Point("post", (0.0, 1.0))},
    )
    free = Model(
        name="free",
        bodies=rod,
        joints={"hinge": replace(hinge, parent="ground", parent_to_joint=(2.0, 2.0))},
    )
    state = {"joint.hinge.q": 0.4, "joint.hinge.u": 1.1}
    found, expected = (Evaluated(model_program(m)) for m in (on_post, free))
    assert found.rates(state) == pytest.approx(expected.rates(state), rel=1e-15)
    got = found.outputs({**state, "point.top.force_x": 3.0, "body.post.moment_y": 1.0})
    for name, value in {"x": 2, "z": 1, "theta": 0, "vx": 0, "omega": 0, "ax": 0, "az": 0}.items():
        assert got[f"body.post.{name}"] == value
    assert (got["point.top.x"], got["point.top.z"]) == (2, 2)


def test_derivatives_go_through_fixed_joints_and_relative_angles() -> None:
    """The tangent of the recursion against a central difference: error h² and rounding over h."""
    model = welded()
    bodies = {**model.bodies, "flap": Body(0.7, 0.2)}
    knee = Joint("revolute", "flap", "bob", (0.1, 0.0), (0.3, -0.4), coordinate="relative")
    model = replace(model, bodies=bodies, joints={**model.joints, "knee": knee})
    program = recorded(model, topology(model), Recursion)
    states = [v.name for v in program.states]
    derivative = Evaluated(tangent(program, states))
    values = dict(zip(states, (0.3, -0.8, 1.2, 0.6), strict=True))
    direction = dict(zip(states, (0.5, -0.2, 0.9, 0.4), strict=True))
    h = 1e-6
    ahead, behind = (
        Evaluated(program).rates({k: v + s * h * direction[k] for k, v in values.items()})
        for s in (1, -1)
    )
    seeds = {f"d({name})": value for name, value in direction.items()}
    got = derivative.outputs({**values, **seeds})
    for name in ("joint.hinge.u", "joint.knee.u"):
        slope = (ahead[name] - behind[name]) / (2 * h)
        assert got[f"d(der({name}))"] == pytest.approx(slope, rel=1e-8)


def double_pendulum() -> Model:
    """The lower angle is measured from the upper link."""
    return Model(
        name="relative",
        gravity=9.81,
        bodies={"upper": Body(1.0, 1.0), "lower": Body(2.0, 0.5)},
        joints={
            "shoulder": Joint("revolute", "upper", joint_to_child=(0.0, -0.5)),
            "elbow": Joint(
                "revolute",
                "lower",
                "upper",
                (0.0, -0.5),
                (0.2, -0.5),
                coordinate="relative",
                initial={"q": "pi/2", "u": 1.0},
            ),
        },
        loads={
            "coil": TorsionSpring(("upper", "lower"), 5.0, 0.3),
            "oil": TorsionDamper(("upper", "lower"), 0.7),
        },
    )


@pytest.mark.verifies(
    "double pendulum in relative angles",
    independent="Lagrange's equation derived by SymPy",
    tolerance="1e-10",
)
def test_relative_angle_against_lagrange() -> None:
    pendulum = Mechanism("upper elbow")
    a, phi = pendulum.q
    x1, z1 = turned(0, -0.5, a)
    own = turned(0.2, -0.5, a + phi)
    x2, z2 = 2 * x1 + own[0], 2 * z1 + own[1]
    pendulum.body(x1, z1, a, mass=1, inertia=1, g=9.81)
    pendulum.body(x2, z2, a + phi, mass=2, inertia=0.5, g=9.81)
    pendulum.spring(5, phi - sp.Rational(3, 10))
    pendulum.damper(0.7, phi)
    u = forces("joint.elbow.effort", "joint.shoulder.effort", "body.lower.moment_y")
    pendulum.force(
        (u["joint.elbow.effort"], phi),
        (u["joint.shoulder.effort"], a),
        (u["body.lower.moment_y"], a + phi),
    )
    model = double_pendulum()
    for algorithm in ALGORITHMS:
        program = Evaluated(recorded(model, topology(model), algorithm))
        assert_accelerations(program, pendulum, ["joint.shoulder.q", "joint.elbow.q"], u)


def test_initial_values_are_relative_and_what_bodies_report_is_absolute() -> None:
    program = model_program(double_pendulum())
    start = {v.name: v.start for v in program.states}
    assert start["joint.elbow.q"] == pytest.approx(math.pi / 2, rel=1e-15)
    state = {"joint.shoulder.q": 0.25, "joint.shoulder.u": 0.5, "joint.elbow.u": 1.0}
    got = Evaluated(program).outputs(state)
    assert got["body.lower.theta"] == pytest.approx(0.25 + math.pi / 2, rel=1e-15)
    assert got["body.lower.omega"] == 1.5
    rates = Evaluated(program).rates(state)
    alpha = rates["joint.shoulder.u"] + rates["joint.elbow.u"]
    assert got["body.lower.alpha"] == pytest.approx(alpha, rel=1e-12)


def test_a_chain_in_relative_angles_costs_what_one_in_absolute_angles_costs() -> None:
    def operations(coordinate: AngleReference, n: int) -> int:
        link = Joint("revolute", "b", "a", (0.0, -0.5), (0.0, -0.5), None, coordinate)
        joints = {
            f"j{k}": replace(link, child=f"b{k}", parent=f"b{k - 1}" if k else "ground")
            for k in range(n)
        }
        model = Model(name="c", bodies={f"b{k}": Body(1.0, 1.0) for k in range(n)}, joints=joints)
        program = recorded(model, topology(model), Recursion)
        return len(program.operations(program.rates))

    # of each link: its absolute angle and rate, and the difference of two accelerations
    assert operations("relative", 40) <= operations("absolute", 40) + 3 * 40
