"""A flexible jumper, moved and in waves: six cases of Lowe and Langley (OMAE 2006).

Their curves were digitised for MoorDyn's own tests, which take 1 kN as the tolerance (paths, waves
and phases from there).
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from support.lines_in_waves import line_system

DATA = Path(__file__).parents[1] / "data" / "moordyn" / "lowe_langley_2006.csv"
JUMPER = """\
dimensions: 3
water: {density: 1000, depth: 100, gravity: 9.807}
line_types:
  jumper: {diameter: 0.396, mass_per_length: 165, axial_stiffness: 5.0e+8,
           bending_stiffness: 1.208e+5, axial_damping_ratio: 0.5,
           drag_coefficient: 1, added_mass_coefficient: 1}
anchors: {low: [-100, 0, -55]}
fairleads: {top: [0, 0, -5]}
lines: {jumper: {type: jumper, from: low, to: top, unstretched_length: 170, segments: 68}}
"""
PERIOD, LED = 27.0, 27.0  # [s] of the motion, and in which it begins
SETTLED = 20.0  # [s] of waves before they are looked at
STEP = 0.1


def published(case: int) -> np.ndarray:
    """Times [s] and tensions [kN] (n, 2) of a case."""
    with DATA.open(encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if row[0] == str(case)]
    return np.array(rows, dtype=float)[:, 1:]


def moved(case: int, t: float) -> tuple[float, ...]:
    """Where the upper end is: 10 m along x, y, or z."""
    s = min(t / LED, 1.0)
    place = [0.0, 0.0, -5.0]
    place[case - 1] += s**3 * (6 * s * s - 15 * s + 10) * 10 * math.sin(2 * math.pi * t / PERIOD)
    return tuple(place)


def tensions(text: str, case: int, *, after: float, times: np.ndarray) -> np.ndarray:
    """Tensions [kN] at the upper end at `times` behind `after` [s]."""
    lines = line_system(text)
    found = []

    def place(t: float) -> tuple[float, ...]:
        return moved(case, t) if case <= 3 else (0.0, 0.0, -5.0)

    lines.start([place(0.0)], [(0.0, 0.0, 0.0)])
    count = round((after + times[-1]) / STEP)
    for k in range(count):
        here, then = place(k * STEP), place((k + 1) * STEP)
        speed = tuple((b - a) / STEP for a, b in zip(here, then, strict=True))
        lines.advance(k * STEP, STEP, [here], [speed])
        found.append(1e-3 * lines.tensions()[0][0])
    lines.close()
    return np.interp(times, STEP * np.arange(1, count + 1) - after, found)


@pytest.mark.verifies(
    "tension of a flexible jumper whose upper end moves by 10 m, or in waves of 10 m",
    published="Lowe and Langley 2006, digitised for MoorDyn's tests",
    tolerance="1 kN of 11 to 21 kN",
)
@pytest.mark.parametrize("case", [1, 2, 3, 4, 5, 6])
def test_a_jumper_as_published(case: int) -> None:
    times, expected = published(case).T
    waves = ""
    if case > 3:
        phase = -math.radians((230.0, 165.0, 0.0)[case - 4])
        waves = (
            f"waves: {{spectrum: regular, height: 10, period: 10, phase: {phase!r}, "
            f"direction: {45 * (case - 4)}, ramp_time: 5}}\n"
        )
    found = tensions(JUMPER + waves, case, after=SETTLED if waves else LED, times=times)
    assert np.abs(found - expected).max() < 1.0
