"""Energy of a line on a circle: what is put in is stored or dissipated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.line_energies import energies
from support.lines_in_waves import lines_of, mooring_of

TEXT = """\
water: {{density: 1025, depth: {depth}}}
line_types:
  chain: {{diameter: 0.09, mass_per_length: 50, axial_stiffness: 2.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.3, added_mass_coefficient: 1, axial_drag_coefficient: 0.4}}
anchors: {{anchor: [-180, -50]}}
fairleads: {{f: [-4, -2]}}
lines: {{l: {{type: chain, from: anchor, to: f, unstretched_length: {length}, segments: 20}}}}
"""
CURRENT = "current: {speed: 0.8, profile: 0.143}\n"


def place(t: float) -> tuple[float, float]:
    """A circle of 1 m, into which the fairlead is led within 3 s."""
    s = min(t / 3, 1.0)
    radius, phase = s**3 * (10 - 15 * s + 6 * s * s), 2 * math.pi * t / 7.5
    return -4.0 + radius * math.sin(phase), -2.0 + radius * (math.cos(phase) - 1)


def balance(text: str, h: float, stop: float) -> tuple[float, float]:
    """Largest difference of the balance [J], and energy put in and taken out [J]."""
    made = mooring_of(text)
    assert made.net is not None
    lines = lines_of(made)
    lines.start([place(0.0)], [(0.0, 0.0)])
    nodes = range(21)  # of all nodes
    kept = []
    for k in range(round(stop / h)):
        water = None
        places = [lines.node_position(0, n) for n in nodes]
        if lines.course:
            water = lines.course.current(np.array(places)).tolist()
        speeds = [lines.node_velocity(0, n) for n in nodes]
        kept.append(energies(made.kinds[0], made.net["lines"][0], places, speeds, water))
        (x0, z0), (x1, z1) = place(k * h), place((k + 1) * h)
        lines.advance(k * h, h, [(x0, z0)], [((x1 - x0) / h, (z1 - z0) / h)])
    lines.close()
    stored, *powers = np.array(kept).T
    put_in, by_water, dissipated = (
        np.concatenate([[0.0], np.cumsum((p[1:] + p[:-1]) / 2) * h]) for p in powers
    )
    left = put_in + by_water - dissipated - (stored - stored[0])
    return float(np.abs(left).max()), float(np.abs(np.diff(put_in + by_water)).sum())


@pytest.mark.verifies(
    "energy put into a line on a circle, stored, and dissipated",
    analytic="balance",
    tolerance="2e-3",
)
@pytest.mark.parametrize("more", ["", CURRENT], ids=["still", "current"])
@pytest.mark.parametrize(("depth", "length"), [(300, 195), (50, 188)], ids=["clear", "on the bed"])
def test_energy_is_stored_or_dissipated(depth: int, length: int, more: str) -> None:
    left, turned = balance(TEXT.format(depth=depth, length=length) + more, 0.025, 30.0)
    assert left < 2e-3 * turned
