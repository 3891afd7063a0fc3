"""Loads of waves on mooring lines: Morison's equation on a taut line, by quadrature."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from support.lines_in_waves import line_system

DEPTH, GRAVITY, DENSITY = 50.0, 9.80665, 1025.0
HEIGHT, PERIOD, PHASE, DIRECTION = 2.0, 8.0, 0.7, math.radians(30)
DIAMETER, DRAG, ADDED = 0.2, 1.2, 0.8
SHORTENED = 0.95  # unstretched length over length
TAUT = """\
dimensions: 3
water: {{density: 1025, depth: 50}}
waves: {{spectrum: regular, height: 2, period: 8, phase: 0.7, direction: 30, ramp_time: 4}}
stretching: {stretching}
line_types:
  rope: {{diameter: 0.2, mass_per_length: 32, axial_stiffness: 2.0e+8, axial_damping_ratio: 0.5,
         drag_coefficient: {drag}, added_mass_coefficient: {added}}}
anchors: {{low: [3, -4, {low}]}}
fairleads: {{top: [3, -4, {top}]}}
lines: {{l: {{type: rope, from: low, to: top, unstretched_length: {length}, segments: 40}}}}
solver: {{scheme: RK4}}
"""


def wavenumber() -> float:
    omega = 2 * math.pi / PERIOD
    root = brentq(lambda k: GRAVITY * k * math.tanh(k * DEPTH) - omega**2, 1e-4, 10.0, xtol=1e-14)
    assert isinstance(root, float)
    return root


def push(z: float, t: float, *, stretched: bool) -> float:
    """Horizontal force [N/m] of the wave on the line at x = 3, y = −4, along its direction."""
    k, omega, a = wavenumber(), 2 * math.pi / PERIOD, HEIGHT / 2
    way = 3 * math.cos(DIRECTION) - 4 * math.sin(DIRECTION)
    angle = omega * t - k * way + PHASE
    if stretched:
        eta = a * math.cos(angle)
        z = DEPTH * (z - eta) / (DEPTH + eta)
    profile = a * omega * math.cosh(k * (min(z, 0.0) + DEPTH)) / math.sinh(k * DEPTH)
    u, rate = profile * math.cos(angle), -omega * profile * math.sin(angle)
    drag = 0.5 * DENSITY * DRAG * DIAMETER * u * abs(u)
    return drag + (1 + ADDED) * DENSITY * math.pi * DIAMETER**2 / 4 * rate


def pull(t: float, low: float, top: float, *, stretched: bool) -> float:
    """Force [N] at the upper end of a string under this load, between two held ends.

    The load counts per unstretched length.
    """

    def share(z: float) -> float:
        return push(z, t, stretched=stretched) * (z - low) / (top - low)

    return SHORTENED * quad(share, low, top, epsabs=1e-9, epsrel=1e-10)[0]


@pytest.mark.verifies(
    "load of a regular wave on a taut line, near the surface and deep below",
    independent="Morison's equation with Airy's waves, by quadrature",
    tolerance="5e-3 of the amplitude",
)
@pytest.mark.parametrize(("low", "top"), [(-48.0, -1.5), (-48.0, -25.0)])
@pytest.mark.parametrize("stretching", ["linear", "wheeler"])
def test_a_wave_pushes_a_taut_line(
    low: float, top: float, stretching: Literal["linear", "wheeler"]
) -> None:
    """The line is so taut that its own waves are 60 times as fast as the sea's."""
    length = SHORTENED * (top - low)
    text = TAUT.format(
        stretching=stretching, drag=DRAG, added=ADDED, low=low, top=top, length=length
    )
    lines, place, rest = line_system(text), (3.0, -4.0, top), (0.0, 0.0, 0.0)
    lines.start([place], [rest])
    found, expected, step = [], [], 0.1
    for k in range(160):
        lines.advance(k * step, step, [place], [rest])
        if k * step >= PERIOD:
            found.append(lines.force[0][:2])
            whole = pull((k + 1) * step, low, top, stretched=stretching == "wheeler")
            expected.append((whole * math.cos(DIRECTION), whole * math.sin(DIRECTION)))
    lines.close()
    error = np.abs(np.array(found) - np.array(expected)).max(axis=0)
    assert (error < 5e-3 * np.ptp(expected, axis=0) / 2).all()
