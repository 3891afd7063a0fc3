"""Forces of a line whose fairlead moves smoothly, against those of ever shorter steps.

The line hangs between anchor and fairlead, clear of the seabed: a node that meets the seabed
stops within some milliseconds, whose place among MoorDyn's internal steps is in the forces.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.lines_in_waves import line_system

TEXT = """\
water: {density: 1025, depth: 300}
line_types:
  chain: {diameter: 0.09, mass_per_length: 50, axial_stiffness: 2.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.3, added_mass_coefficient: 1}
anchors: {anchor: [-180, -50]}
fairleads: [f]
lines:
  l: {type: chain, from: anchor, to: f, unstretched_length: 195, segments: 10}
solver: {time_step: 0.002}
"""
STOP, PERIOD, START = 6.0, 7.5, (-4.0, -2.0)


def place(t: float) -> tuple[float, float]:
    """A circle of 1 m, into which the fairlead is led within 3 s."""
    s = min(t / 3, 1.0)
    radius = s**3 * (10 - 15 * s + 6 * s * s)
    phase = 2 * math.pi * t / PERIOD
    return START[0] + radius * math.sin(phase), START[1] + radius * math.cos(phase)


def velocity(t: float, h: float = 1e-4) -> tuple[float, float]:
    """Central difference, off by h² times the jerk: 1e-8 m/s."""
    (x0, z0), (x1, z1) = place(t - h), place(t + h)
    return (x1 - x0) / (2 * h), (z1 - z0) / (2 * h)


WAVES = (
    "waves: {spectrum: jonswap, significant_height: 2, peak_period: 6, seed: 1, ramp_time: 2, "
    "components: 40}\n"
)


def forces(h: float, *, told: bool, text: str = TEXT) -> np.ndarray:
    """Forces (n, 2) every 0.2 s, in steps of `h`; `told` the velocity at the end of each or not."""
    lines = line_system(text)
    lines.start([place(0.0)], [(0.0, 0.0)])
    found = []
    for k in range(round(STOP / h)):
        (x0, z0), (x1, z1) = place(k * h), place((k + 1) * h)
        lines.advance(k * h, h, [(x0, z0)], [((x1 - x0) / h, (z1 - z0) / h)])
        if told:
            lines.settle([velocity((k + 1) * h)])
        found.append(lines.force[0])
    lines.close()
    return np.array(found)[round(0.2 / h) - 1 :: round(0.2 / h)]


@pytest.mark.verifies(
    "forces of a line whose fairlead moves smoothly, error over that of half the step: at least",
    analytic="finer step",
    tolerance="3.5",
)
def test_forces_converge():
    finest = forces(0.00625, told=True)
    errors = {
        told: [float(np.abs(forces(h, told=told) - finest).max()) for h in (0.1, 0.05, 0.025)]
        for told in (True, False)
    }
    for coarse, middle, fine in errors.values():
        assert coarse / middle > 3.5  # the next term of a second-order error is a part of it
        assert middle / fine > 3.5
    # extrapolated, the velocity at the end is off by h²/3 of the jerk; told, it is exact
    assert errors[True][0] < errors[False][0] / 10


@pytest.mark.verifies(
    "part of waves in the forces of a line, error over that of half the step: at least",
    analytic="finer step", tolerance="3.5",
)  # fmt: skip
def test_what_waves_add_to_forces_converges() -> None:
    def added(h: float) -> np.ndarray:
        return forces(h, told=True, text=TEXT + WAVES) - forces(h, told=True)

    finest = added(0.0125)
    errors = [float(np.abs(added(h) - finest).max()) for h in (0.1, 0.05)]
    assert errors[0] / errors[1] > 3.5
    assert errors[0] < 0.01 * np.abs(finest).max()
