"""Loads in a section of a body: the reaction of a fixed joint that cuts it, in the body's axes."""

from __future__ import annotations

from math import cos, sin

import numpy as np
import pytest
from support.programs import Evaluated

from m4e_fmi.model import Body, Joint, Model, Point
from m4e_fmi.multibody import Equations, model_program

G = 9.81
PARTS = ("x", "y", "z", "moment_x", "moment", "moment_z")


@pytest.mark.verifies(
    "bending moment, shear and tension of a falling chimney", analytic="rod on a hinge",
    tolerance="1e-12",
)  # fmt: skip
@pytest.mark.parametrize("cut", [0.2, 1 / 3, 0.8])
def test_a_falling_chimney(cut: float) -> None:
    """θ̈ = 3 g sin θ/(2 L): the moment m g sin θ/4 · x (1 − x/L)² is largest at L/3.

    What is above the cut would fall more slowly by itself, and is pushed on in the sense of θ.
    """
    mass, length, theta, omega = 900.0, 12.0, 0.6, 0.7
    low, high = cut * length, (1 - cut) * length
    model = Model(
        name="chimney",
        gravity=G,
        bodies={
            "foot": Body(mass * cut, mass * cut * low**2 / 12),
            "top": Body(mass * (1 - cut), mass * (1 - cut) * high**2 / 12),
        },
        joints={
            "hinge": Joint("revolute", "foot", joint_to_child=(0, low / 2)),
            "section": Joint(
                "fixed", "top", "foot", (0, low / 2), (0, high / 2), reaction_axes="body"
            ),
        },
    )
    found = Evaluated(model_program(model)).outputs(
        {"joint.hinge.q": theta, "joint.hinge.u": omega}
    )
    x, z, moment = (found[f"joint.section.reaction_{p}"] for p in ("x", "z", "moment"))
    alpha, middle = 1.5 * G * sin(theta) / length, low + high / 2
    above = mass * (1 - cut)
    assert moment == pytest.approx(mass * G * sin(theta) / 4 * low * (1 - cut) ** 2, rel=1e-12)
    assert x == pytest.approx(above * (middle * alpha - G * sin(theta)), rel=1e-12)
    assert z == pytest.approx(above * (G * cos(theta) - middle * omega**2), rel=1e-12)


def skew(a: np.ndarray) -> np.ndarray:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


@pytest.mark.verifies(
    "six sectional loads of a tumbling hull", independent="Newton and Euler of the whole body",
    tolerance="1e-12",
)  # fmt: skip
def test_a_tumbling_hull() -> None:
    """One rigid body in NumPy, pushed at its bow; what the bow needs beyond its own loads."""
    r = np.random.default_rng(3)
    masses, places = [3.0, 2.0], [np.array([-1.0, 0.2, 0.1]), np.array([1.5, -0.1, 0.3])]
    tensors = [np.diag([1.0, 1.2, 1.1]), np.array([[0.8, 0.05, 0], [0.05, 0.9, 0.1], [0, 0.1, 1]])]
    section, bow = np.array([0.25, 0.0, 0.1]), np.array([2.5, 0.3, 0.2])
    force, e, omega = (r.uniform(-1, 1, n) for n in (3, 4, 3))
    e /= np.linalg.norm(e)
    flat = [(J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[1, 2], J[2, 0]) for J in tensors]
    model = Model(
        name="hull",
        dimensions=3,
        gravity=G,
        bodies={"aft": Body(masses[0], flat[0]), "fore": Body(masses[1], flat[1])},
        joints={
            "free": Joint("floating", "aft"),
            "section": Joint(
                "fixed", "fore", "aft", tuple(section - places[0]), tuple(places[1] - section),
                reaction_axes="body",
            ),
        },
        points={"bow": Point("fore", tuple(bow - places[1]))},
    )  # fmt: skip
    values = {f"body.aft.e{k}": part for k, part in enumerate(e)}
    values |= {
        f"body.aft.{n}": w for n, w in zip(("omega_x", "omega", "omega_z"), omega, strict=True)
    }
    values |= {f"point.bow.force_{axis}": part for axis, part in zip("xyz", force, strict=True)}
    found = Evaluated(model_program(model)).outputs(values)

    R = np.eye(3) + 2 * (e[0] * skew(e[1:]) + skew(e[1:]) @ skew(e[1:]))
    w, push, down = R.T @ omega, R.T @ force, R.T @ [0, 0, -G]  # all in body axes
    middle = sum(m * p for m, p in zip(masses, places, strict=True)) / sum(masses)
    arms = [p - middle for p in places]
    J = sum(T - m * skew(a) @ skew(a) for T, m, a in zip(tensors, masses, arms, strict=True))
    alpha = np.linalg.solve(J, np.cross(bow - middle, push) - np.cross(w, J @ w))
    a = push / sum(masses) + down + np.cross(alpha, arms[1]) + np.cross(w, np.cross(w, arms[1]))
    needed = masses[1] * (a - down) - push
    turn = tensors[1] @ alpha + np.cross(w, tensors[1] @ w)
    turn += np.cross(places[1] - section, masses[1] * (a - down)) - np.cross(bow - section, push)
    given = [found[f"joint.section.reaction_{part}"] for part in PARTS]
    assert np.abs(given - np.r_[needed, turn]).max() < 1e-12 * np.abs(given).max()
    text = Equations(model).text(reactions=True)
    assert "of section in the axes of the child" in text
