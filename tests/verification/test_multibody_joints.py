"""Fixed joints against one body of the same mass, relative angles against absolute ones.

Both sides are double precision; see support/lagrange.py for the tolerance.
"""

from __future__ import annotations

import math

import pytest
import sympy as sp
from support.lagrange import RELATIVE, Mechanism, assert_accelerations, forces, turned
from support.programs import Evaluated

from m4e_fmi.model import Body, Joint, Model, Point, TorsionDamper, TorsionSpring
from m4e_fmi.multibody import model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.model_program.recording import recorded
from m4e_fmi.multibody.sensitivity import Recursion

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
