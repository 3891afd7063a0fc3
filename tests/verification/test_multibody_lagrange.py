"""Accelerations of whole models against Lagrange's equation derived in the test.

The derivations know positions only, written down by hand for each mechanism; see
support/lagrange.py.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from support.lagrange import TIME, Mechanism, assert_accelerations, distance, forces, turned
from support.programs import Evaluated

from m4e_fmi.model import (
    Body,
    BodyForce,
    Joint,
    Model,
    Point,
    PointForce,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.multibody import model_program


@pytest.mark.verifies(
    "accelerations of the double pendulum of section 5.1",
    independent="Lagrange's equation derived by SymPy",
    tolerance="1e-10",
)
def test_double_pendulum() -> None:
    """The example of the paper's section 5.1: push, torsion spring and two torsion dampers."""
    examples = Path(__file__).parents[2] / "examples"
    program = Evaluated(model_program(examples / "double_pendulum" / "double_pendulum.model.yaml"))
    pendulum = Mechanism("upper lower")
    a, b = pendulum.q
    x1, z1 = turned(0, -0.5, a)
    x2, z2 = 2 * x1 + turned(0, -0.5, b)[0], 2 * z1 + turned(0, -0.5, b)[1]
    tip = 2 * x2 - 2 * x1, 2 * z2 - 2 * z1
    pendulum.body(x1, z1, a, mass=1, inertia=1, g=9.81)
    pendulum.body(x2, z2, b, mass=1, inertia=1, g=9.81)
    pendulum.spring(50, a - (-0.75 * sp.pi))
    pendulum.damper(5, a)
    pendulum.damper(5, b - a)
    u = forces(
        "body.lower.force_x", "body.upper.moment_y", "point.tip.force_z", "joint.elbow.effort"
    )
    pendulum.force(
        (20 + u["body.lower.force_x"], x2),
        (20, z2),
        (u["body.upper.moment_y"], a),
        (u["point.tip.force_z"], tip[1]),
        (u["joint.elbow.effort"], b - a),
    )
    assert_accelerations(program, pendulum, ["joint.shoulder.q", "joint.elbow.q"], u)


def cart_model() -> Model:
    """The paper's section 4.2.2 (`slider_w_dpend`)."""
    return Model(
        name="slider_w_dpend",
        gravity=9.81,
        bodies={name: Body(1.0, 1.0) for name in ("cart", "first", "second")},
        joints={
            "rail": Joint("prismatic", "cart", joint_to_child=(0, 0.125), direction=(1, 0)),
            "hip": Joint("revolute", "first", "cart", joint_to_child=(0, -0.625)),
            "knee": Joint(
                "revolute", "second", "first", parent_to_joint=(0, -0.5), joint_to_child=(0, -0.5)
            ),
        },
        loads={"drive": BodyForce("cart", ("3*cos(1.5*t)", 0.0))},
    )


@pytest.mark.verifies(
    "accelerations of the cart of section 4.2.2",
    independent="Lagrange's equation derived by SymPy",
    tolerance="1e-10",
)
def test_cart_with_two_pendulums() -> None:
    """With the force in time of the paper, and efforts."""
    cart = Mechanism("s a b")
    s, a, b = cart.q
    x1, z1 = s + turned(0, -0.625, a)[0], 0.125 + turned(0, -0.625, a)[1]
    x2, z2 = (
        start + half + own
        for start, half, own in zip((x1, z1), turned(0, -0.5, a), turned(0, -0.5, b), strict=True)
    )
    cart.body(s, sp.Rational(1, 8), 0, mass=1, inertia=1, g=9.81)
    cart.body(x1, z1, a, mass=1, inertia=1, g=9.81)
    cart.body(x2, z2, b, mass=1, inertia=1, g=9.81)
    u = forces(
        "joint.rail.effort",
        "joint.hip.effort",
        "joint.knee.effort",
        "body.cart.moment_y",
        "body.second.force_x",
    )
    cart.force(
        (3 * sp.cos(1.5 * TIME), s),
        (u["joint.rail.effort"], s),
        (u["joint.hip.effort"], a),  # the cart, its parent, does not turn
        (u["joint.knee.effort"], b - a),
        (u["body.second.force_x"], x2),
    )
    assert_accelerations(
        Evaluated(model_program(cart_model())),
        cart,
        ["joint.rail.q", "joint.hip.q", "joint.knee.q"],
        u,
    )


def tree_model() -> Model:
    """arm (R) → sledge (P, oblique) → flap (R); arm → weight (R); springs in between."""
    return Model(
        name="tree",
        gravity=9.80665,
        bodies={
            "arm": Body(2.0, 0.7),
            "sledge": Body(1.5, 0.3),
            "flap": Body(0.8, 0.2),
            "weight": Body(3.0, 0.9),
        },
        joints={
            "base": Joint(
                "revolute", "arm", parent_to_joint=(0.4, 1.0), joint_to_child=(0.5, -0.2)
            ),
            "rail": Joint(
                "prismatic",
                "sledge",
                "arm",
                parent_to_joint=(0.3, 0.1),
                joint_to_child=(-0.2, 0.6),
                direction=(3, 4),
            ),
            "hinge": Joint(
                "revolute", "flap", "sledge", parent_to_joint=(0.1, -0.3), joint_to_child=(0, -0.5)
            ),
            "pin": Joint(
                "revolute", "weight", "arm", parent_to_joint=(-0.6, 0), joint_to_child=(-0.4, 0.2)
            ),
        },
        points={
            "edge": Point("flap", (0.2, -0.4)),
            "hook": Point("weight", (0.1, 0.3)),
            "post": Point("ground", (-2.0, -3.0)),
        },
        loads={
            "rope": TensionSpring(("edge", "hook"), 30.0, 1.2),
            "stay": TensionSpring(("post", "hook"), 20.0, 0.5),
            "piston": TensionDamper(("edge", "post"), 4.0),
            "bush": TorsionSpring(("sledge", "flap"), 12.0, 0.3),
            "grease": TorsionDamper(("weight", "sledge"), 2.5),
            "wind": PointForce("edge", (1.5, -0.5)),
        },
    )


@pytest.mark.verifies(
    "accelerations of a tree with a slider on a turning parent",
    independent="Lagrange's equation derived by SymPy",
    tolerance="1e-10",
)
def test_tree_with_a_slider_on_a_turning_parent() -> None:
    tree = Mechanism("arm sledge flap weight")
    a, s, f, w = tree.q
    base = sp.Matrix([0.4, 1.0])

    def arm_of(x: float, z: float, theta: sp.Symbol) -> sp.Matrix:
        return sp.Matrix(turned(x, z, theta))

    arm = base + arm_of(0.5, -0.2, a)
    along = arm_of(0.6, 0.8, a)  # (3, 4) of length one; turns with the arm
    sledge = arm + arm_of(0.3 - 0.2, 0.1 + 0.6, a) + s * along
    flap = sledge + arm_of(0.1, -0.3, a) + arm_of(0, -0.5, f)  # the sledge turns with the arm
    weight = arm + arm_of(-0.6, 0, a) + arm_of(-0.4, 0.2, w)
    edge, hook, post = flap + arm_of(0.2, -0.4, f), weight + arm_of(0.1, 0.3, w), (-2.0, -3.0)
    for place, theta, mass, inertia in (
        (arm, a, 2.0, 0.7),
        (sledge, a, 1.5, 0.3),
        (flap, f, 0.8, 0.2),
        (weight, w, 3.0, 0.9),
    ):
        tree.body(place[0], place[1], theta, mass=mass, inertia=inertia, g=9.80665)
    tree.spring(30.0, distance(edge, hook) - 1.2)
    tree.spring(20.0, distance(hook, post) - 0.5)
    tree.damper(4.0, distance(edge, post))
    tree.spring(12.0, f - a - 0.3)
    tree.damper(2.5, a - w)
    u = forces(
        "joint.rail.effort",
        "joint.hinge.effort",
        "joint.pin.effort",
        "body.sledge.moment_y",
        "body.sledge.force_x",
        "point.hook.force_x",
        "point.hook.force_z",
    )
    tree.force(
        (1.5, edge[0]),
        (-0.5, edge[1]),
        (u["joint.rail.effort"], s),
        (u["joint.hinge.effort"], f - a),
        (u["joint.pin.effort"], w - a),
        (u["body.sledge.moment_y"], a),
        (u["body.sledge.force_x"], sledge[0]),
        (u["point.hook.force_x"], hook[0]),
        (u["point.hook.force_z"], hook[1]),
    )
    states = [f"joint.{name}.q" for name in ("base", "rail", "hinge", "pin")]
    assert_accelerations(Evaluated(model_program(tree_model())), tree, states, u)


ADDED_MASS = np.array(
    [
        [4.0, 0.3, -0.8, 0.5, 0.1, 0.2],
        [0.3, 6.0, 0.4, -0.2, 0.7, 0.1],
        [-0.8, 0.4, 3.0, 0.1, -0.3, 0.4],
        [0.5, -0.2, 0.1, 2.0, 0.2, -0.5],
        [0.1, 0.7, -0.3, 0.2, 1.5, 0.3],
        [0.2, 0.1, 0.4, -0.5, 0.3, 1.0],
    ]
)
"""Positive definite, with coupling between the two bodies; world axes, about the CGs."""


def float_model() -> Model:
    """hull (F, wet) → flap (R, wet); hull → mast (P)."""
    return Model(
        name="float",
        gravity=9.81,
        bodies={
            "mast": Body(0.5, 0.1),
            "hull": Body(5.0, 2.0, added_mass=True),
            "flap": Body(1.2, 0.4, added_mass=True),
        },
        joints={
            "lift": Joint(
                "prismatic",
                "mast",
                "hull",
                parent_to_joint=(0.2, 0.8),
                joint_to_child=(0, 0.5),
                direction=(-0.5, 1.0),
            ),
            "hinge": Joint(
                "revolute", "flap", "hull", parent_to_joint=(1.0, -0.4), joint_to_child=(0.1, -0.7)
            ),
            "sea": Joint("floating", "hull"),
        },
        points={"fairlead": Point("hull", (-0.9, -0.6)), "anchor": Point("ground", (-6, -8))},
        loads={
            "line": TensionSpring(("anchor", "fairlead"), 8.0, 9.0),
            "drag": TensionDamper(("anchor", "fairlead"), 1.5),
            "stop": TorsionSpring(("hull", "flap"), 15.0, -0.2),
        },
    )


@pytest.mark.verifies(
    "accelerations of a floating base with coupled added mass",
    independent="Lagrange's equation derived by SymPy",
    tolerance="1e-10",
)
def test_floating_base_with_children_and_added_mass() -> None:
    """Gravity pulls on the dry masses only."""
    program = Evaluated(
        model_program(float_model()).with_start(
            {f"added_mass[{i + 1},{j + 1}]": ADDED_MASS[i, j] for i in range(6) for j in range(6)}
        )
    )
    sea = Mechanism("x z theta flap mast")
    x, z, theta, f, m = sea.q
    hull = sp.Matrix([x, z])
    along = sp.Matrix(turned(-1 / np.sqrt(5), 2 / np.sqrt(5), theta))
    mast = hull + sp.Matrix(turned(0.2, 0.8 + 0.5, theta)) + m * along
    flap = hull + sp.Matrix(turned(1.0, -0.4, theta)) + sp.Matrix(turned(0.1, -0.7, f))
    fairlead = hull + sp.Matrix(turned(-0.9, -0.6, theta))
    sea.body(hull[0], hull[1], theta, mass=5.0, inertia=2.0, g=9.81)
    sea.body(flap[0], flap[1], f, mass=1.2, inertia=0.4, g=9.81)
    sea.body(mast[0], mast[1], theta, mass=0.5, inertia=0.1, g=9.81)
    sea.added_mass(ADDED_MASS, [*hull, theta, *flap, f])
    sea.spring(8.0, distance(fairlead, (-6, -8)) - 9.0)
    sea.damper(1.5, distance(fairlead, (-6, -8)))
    sea.spring(15.0, f - theta + 0.2)
    u = forces(
        "body.hull.force_x",
        "body.hull.force_z",
        "body.hull.moment_y",
        "body.flap.moment_y",
        "body.mast.force_z",
        "point.fairlead.force_x",
        "joint.hinge.effort",
        "joint.lift.effort",
    )
    sea.force(
        (u["body.hull.force_x"], hull[0]),
        (u["body.hull.force_z"], hull[1]),
        (u["body.hull.moment_y"], theta),
        (u["body.flap.moment_y"], f),
        (u["body.mast.force_z"], mast[1]),
        (u["point.fairlead.force_x"], fairlead[0]),
        (u["joint.hinge.effort"], f - theta),
        (u["joint.lift.effort"], m),
    )
    states = ["body.hull.x", "body.hull.z", "body.hull.theta", "joint.hinge.q", "joint.lift.q"]
    assert_accelerations(program, sea, states, u)
