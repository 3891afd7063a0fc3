"""Reactions of joints against statics and dynamics done by hand."""

from __future__ import annotations

from math import cos, pi, sin

import pytest
import sympy as sp
from support.programs import Evaluated

from m4e_fmi.model import Body, BodyForce, Joint, Model, Point, PointForce
from m4e_fmi.multibody import Equations, model_program

ROUNDING = 1e-13  # relative: a few dozen operations in double precision
G = 9.81


def outputs(model: Model, **values: float) -> dict[str, float]:
    given = {name.replace("__", "."): value for name, value in values.items()}
    return Evaluated(model_program(model)).outputs(given)


def reaction(found: dict[str, float], joint: str) -> tuple[float, float, float]:
    x, z, moment = (found[f"joint.{joint}.reaction_{part}"] for part in ("x", "z", "moment"))
    return x, z, moment


def test_a_hanging_link_is_carried() -> None:
    model = Model(
        name="link",
        gravity=G,
        bodies={"link": Body(2.0, 0.3)},
        joints={"pin": Joint("revolute", "link", joint_to_child=(0, -0.5))},
    )
    assert reaction(outputs(model), "pin") == pytest.approx((0.0, 2 * G, 0.0), abs=1e-13)


@pytest.mark.verifies(
    "reactions of a pinned link that swings", analytic="Newton and Euler by hand", tolerance="1e-13"
)
def test_a_swinging_link() -> None:
    """R = m (a + g e_z): a of the CG from θ̈ = −m g l sin θ/(J + m l²), inwards ω² l."""
    m, J, arm, theta, omega, tau = 2.0, 0.3, 0.5, 0.7, 1.3, 0.4
    model = Model(
        name="link",
        gravity=G,
        bodies={"link": Body(m, J)},
        joints={"pin": Joint("revolute", "link", joint_to_child=(0, -arm))},
    )
    found = outputs(model, joint__pin__q=theta, joint__pin__u=omega, joint__pin__effort=tau)
    alpha = (tau - m * G * arm * sin(theta)) / (J + m * arm**2)
    # the CG is at (−l sin θ, −l cos θ)
    x = m * (-arm * cos(theta) * alpha + arm * sin(theta) * omega**2)
    z = m * (G + arm * sin(theta) * alpha + arm * cos(theta) * omega**2)
    assert reaction(found, "pin") == pytest.approx((x, z, tau), rel=ROUNDING)


@pytest.mark.verifies(
    "reactions of a carriage on a rail", analytic="Newton and Euler by hand", tolerance="1e-13"
)
def test_a_slider_is_held_against_turning() -> None:
    """A carriage on a horizontal rail, 3 kg, pushed down 0.8 m beside its centre of gravity.

    The rail's point is 0.25 m above the centre of gravity.
    """
    model = Model(
        name="carriage",
        gravity=G,
        bodies={"box": Body(3.0, 1.0)},
        joints={"rail": Joint("prismatic", "box", joint_to_child=(0, -0.25), direction=(1, 0))},
        points={"side": Point("box", (0.8, 0.0))},
        loads={
            "push": PointForce("side", (0.0, -10.0)),
            "pull": BodyForce("box", (6.0, 0.0), moment=0.5),
        },
    )
    # the pull accelerates; it acts 0.25 m below the rail's point, as the inertia does: no moment
    # M_y = r_z F_x − r_x F_z of the push about the centre of gravity: +0.8 · 10, held back
    found = outputs(model, joint__rail__q=2.0, joint__rail__effort=1.5)
    assert found["body.box.ax"] == pytest.approx((6.0 + 1.5) / 3.0, rel=ROUNDING)
    # the effort acts at the joint, 0.25 m above the centre of gravity: M = −(8 + 0.5) − 0.25 · 1.5
    expected = (1.5, 3 * G + 10.0, -(8.0 + 0.5) - 0.25 * 1.5)
    assert reaction(found, "rail") == pytest.approx(expected, rel=ROUNDING)


def test_a_telescope_hands_its_weight_on() -> None:
    """A slider on a beam on a hinge with an effort that holds it at rest, 30° from the vertical."""
    theta, s = pi / 6, 0.4
    model = Model(
        name="crane",
        gravity=G,
        bodies={"beam": Body(5.0, 1.0), "slide": Body(2.0, 0.2)},
        joints={
            "hinge": Joint("revolute", "beam", joint_to_child=(0, 1.0)),
            "rail": Joint("prismatic", "slide", "beam", parent_to_joint=(0, 1.0), direction=(0, 1)),
        },
    )
    weight = 2 * G
    found = outputs(
        model,
        joint__hinge__q=theta,
        joint__rail__q=s,
        joint__rail__effort=weight * cos(theta),
        # gravity's moment about the hinge is +m g r sin θ; the effort is its opposite
        joint__hinge__effort=-(5 * 1.0 + 2 * (2.0 + s)) * G * sin(theta),
    )
    assert found["body.slide.az"] == pytest.approx(0.0, abs=1e-12)
    assert reaction(found, "rail") == pytest.approx((0.0, weight, 0.0), abs=1e-12)
    assert reaction(found, "hinge")[:2] == pytest.approx((0.0, 7 * G), abs=1e-12)


@pytest.mark.verifies("clamping moment of a welded bracket", analytic="statics", tolerance="1e-13")
def test_a_weld_carries_a_bracket() -> None:
    """An arm along X, welded to the wall at its end, and a pendulum that hangs still from its tip.

    M_y = r_z F_x − r_x F_z: a weight at r_x > 0 turns by + r_x m g, which the wall holds back.
    """
    model = Model(
        name="bracket",
        gravity=G,
        bodies={"arm": Body(3.0, 1.0), "bob": Body(2.0, 0.1)},
        joints={
            "weld": Joint("fixed", "arm", joint_to_child=(0.6, 0)),
            "hook": Joint("revolute", "bob", "arm", (0.6, 0), (0, -0.5)),
        },
    )
    found = outputs(model)
    assert reaction(found, "hook") == pytest.approx((0.0, 2 * G, 0.0), abs=1e-13)
    moment = -(0.6 * 3 + 1.2 * 2) * G
    assert reaction(found, "weld") == pytest.approx((0.0, 5 * G, moment), abs=1e-13)


def test_an_added_mass_is_felt_by_the_joint() -> None:
    """Pushed along X, a buoy on a vertical rail meets the water's coupling of heave and surge."""
    model = Model(
        name="buoy",
        gravity=0.0,
        bodies={"buoy": Body(4.0, 1.0, added_mass=True)},
        joints={"rail": Joint("prismatic", "buoy", direction=(0, 1))},
    )
    values = {"added_mass[2,2]": 6.0, "added_mass[1,2]": 1.5, "added_mass[3,2]": 0.7}
    found = Evaluated(model_program(model)).outputs({**values, "body.buoy.force_z": 20.0})
    assert found["body.buoy.az"] == pytest.approx(2.0, rel=ROUNDING)
    # what holds it has to move the water: R = A v̇
    assert reaction(found, "rail") == pytest.approx((3.0, 0.0, 1.4), rel=ROUNDING, abs=1e-14)


def test_symbolic_reactions() -> None:
    model = Model(
        name="link",
        gravity=G,
        bodies={"link": Body(2, 1)},
        joints={"pin": Joint("revolute", "link", joint_to_child=(0, -1))},
    )
    equations = Equations(model)
    theta, omega, alpha = (s.flat()[0] for s in (equations.q, equations.u, equations.u_dot))
    assert str(alpha) == "ThetaDD_1"
    x = 2 * (sp.sin(theta) * omega**2 - sp.cos(theta) * alpha)
    z = 2 * (sp.Rational("9.81") + sp.cos(theta) * omega**2 + sp.sin(theta) * alpha)
    found = equations.reactions["pin"]
    assert sp.simplify(found - sp.Matrix([x, z, 0])) == sp.zeros(3, 1)
