"""Mooring lines in space: those of the plane turned about Z, and a body on three of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.lines_in_waves import lines_of

from m4e_adapters.moordyn import MooringConfig, mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_fmi.files.document import Document

ANGLE = math.radians(37)
STEP, STEPS = 0.05, 60
LINES = """\
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.09, mass_per_length: 50, axial_stiffness: 2.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.3, added_mass_coefficient: 1}
"""
PLANAR = f"""{LINES}
anchors: {{left: [-150, -50], right: [160, -52]}}
fairleads: [f]
lines:
  l: {{type: chain, from: left, to: f, unstretched_length: 160, segments: 10}}
  r: {{type: chain, from: right, to: f, unstretched_length: 168, segments: 10}}
"""


def turned(x: float, z: float) -> tuple[float, float, float]:
    return math.cos(ANGLE) * x, math.sin(ANGLE) * x, z


def system(text: str) -> LineSystem:
    made = mooring(Document.parse(text).validate(MooringConfig))
    return lines_of(made)


def forces(text: str, place: Any) -> np.ndarray:
    """Force on the fairlead at the end of every step of a motion."""
    lines = system(text)
    here = [place(k * STEP) for k in range(STEPS + 1)]
    lines.start([here[0]], [tuple(0.0 for _ in here[0])])
    found = [lines.force[0]]
    for k in range(STEPS):
        mean = tuple((b - a) / STEP for a, b in zip(here[k], here[k + 1], strict=True))
        lines.advance(k * STEP, STEP, [here[k]], [mean])
        found.append(lines.force[0])
    lines.close()
    return np.array(found)


def path(t: float) -> tuple[float, float]:
    return 3 * math.sin(0.7 * t) ** 2, -2 + math.sin(0.9 * t) ** 2


@pytest.mark.verifies(
    "mooring lines turned by 37° about Z", analytic="symmetry: the same lines in the plane",
    tolerance="1e-6",
)  # fmt: skip
def test_turned_lines_exert_turned_forces() -> None:
    left, right = (turned(x, z) for x, z in ((-150, -50), (160, -52)))
    anchors = f"anchors: {{left: {[*left]}, right: {[*right]}}}"
    planar = "anchors: {left: [-150, -50], right: [160, -52]}"
    text = "dimensions: 3\n" + PLANAR.replace(planar, anchors)
    flat = forces(PLANAR, path)
    found = forces(text, lambda t: turned(*path(t)))
    expected = np.array([turned(x, z) for x, z in flat])
    assert np.abs(found - expected).max() < 1e-6 * np.abs(flat).max()


def test_three_lines_hold_a_fairlead_alike_in_all_directions() -> None:
    """Anchors at 0, 120 and 240°: small offsets meet one stiffness, whatever their direction."""
    corners = [math.radians(120 * k) for k in range(3)]
    anchors = ", ".join(f"a{k}: [{150 * math.cos(c)}, {150 * math.sin(c)}, -50]"
                        for k, c in enumerate(corners))  # fmt: skip
    rows = "\n".join(
        f"  l{k}: {{type: chain, from: a{k}, to: f, unstretched_length: 165, segments: 10}}"
        for k in range(3)
    )
    text = f"dimensions: 3\n{LINES}anchors: {{{anchors}}}\nfairleads: [f]\nlines:\n{rows}\n"
    stiffness = []
    for angle in np.radians([0, 45, 90, 200]):
        lines = system(text)
        offset = 0.02 * np.array([math.cos(angle), math.sin(angle), 0.0])
        lines.start([tuple(offset)], [(0.0, 0.0, 0.0)])
        force = np.array(lines.force[0])
        lines.close()
        stiffness.append(-force[:2] @ offset[:2] / 0.02**2)
        across = np.array([-offset[1], offset[0]]) / 0.02
        assert abs(force[:2] @ across) < 0.01 * abs(force[:2] @ offset[:2]) / 0.02
    np.testing.assert_allclose(stiffness, stiffness[0], rtol=0.01)
