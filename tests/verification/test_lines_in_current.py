"""Lines at rest in a current: an elastic cable with drag, by its differential equation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root
from support.lines_in_waves import line_system

DEPTH, GRAVITY, DENSITY = 120.0, 9.80665, 1025.0
SPEED, TO = 1.5, math.radians(40)
DIAMETER, MASS, STIFFNESS, LENGTH = 0.15, 40.0, 3.0e7, 150.0
DRAG, AXIAL = 1.2, 0.05
LOW, TOP = np.array([10.0, -5.0, -116.0]), np.array([70.0, 25.0, -4.0])
TEXT = """\
dimensions: 3
water: {{density: 1025, depth: 120}}
current: {{speed: 1.5, direction: 40, profile: {profile}}}
line_types:
  rope: {{diameter: 0.15, mass_per_length: 40, axial_stiffness: 3.0e+7, axial_damping_ratio: 1,
         drag_coefficient: 1.2, added_mass_coefficient: 1, axial_drag_coefficient: 0.05}}
anchors: {{low: [10, -5, -116]}}
fairleads: {{top: [70, 25, -4]}}
lines: {{l: {{type: rope, from: low, to: top, unstretched_length: 150, segments: 60}}}}
"""


def cable(pull: np.ndarray, exponent: float) -> tuple[np.ndarray, np.ndarray]:
    """Place and tension (3,) at the upper end of a cable that pulls its lower end by `pull`."""
    weight = np.array([0.0, 0.0, (DENSITY * math.pi * DIAMETER**2 / 4 - MASS) * GRAVITY])

    def slope(_: float, state: np.ndarray) -> np.ndarray:
        tension = float(np.linalg.norm(state[3:]))
        q = state[3:] / tension
        speed = SPEED * max((state[2] + DEPTH) / DEPTH, 1e-9) ** exponent
        u = speed * np.array([math.cos(TO), math.sin(TO), 0.0])
        along = (u @ q) * q
        across = u - along
        drag = DRAG * np.linalg.norm(across) * across
        drag = drag + math.pi * AXIAL * np.linalg.norm(along) * along
        load = weight + 0.5 * DENSITY * DIAMETER * drag
        return np.concatenate([(1 + tension / STIFFNESS) * q, -load])

    solved = solve_ivp(slope, (0, LENGTH), np.concatenate([LOW, pull]), rtol=1e-10, atol=1e-8)
    return solved.y[:3, -1], solved.y[3:, -1]


@pytest.mark.verifies(
    "pull of a line at rest in a uniform and a sheared current",
    independent="differential equation of an elastic cable with drag", tolerance="5e-4",
)  # fmt: skip
@pytest.mark.parametrize(("profile", "exponent"), [("uniform", 0.0), ("0.25", 0.25)])
def test_a_line_rests_in_a_current(profile: str, exponent: float) -> None:
    """From the start, and after half a minute; the drag across it would be 31 kN."""
    lines, rest = line_system(TEXT.format(profile=profile)), (0.0, 0.0, 0.0)
    lines.start([tuple(TOP)], [rest])
    assert lines.warnings == []
    at_start, pull = np.array(lines.force[0]), np.array(lines.end_force(0, 0))
    for k in range(60):
        lines.advance(0.5 * k, 0.5, [tuple(TOP)], [rest])
    later = np.array(lines.force[0])
    lines.close()
    found = root(lambda pull: cable(pull, exponent)[0] - TOP, pull, tol=1e-9)
    assert found.success
    expected = -cable(found.x, exponent)[1]  # on the fairlead
    size = np.linalg.norm(expected)
    assert np.linalg.norm(at_start - expected) < 5e-4 * size
    assert np.linalg.norm(later - expected) < 5e-4 * size
