"""Ranges of the motions from the reference pose: drafts, the surface, the sea bed."""

from __future__ import annotations

import math

import pytest
from support.hulls import checked_program

from m4e_fmi.program import Variable

BALL = "{shape: {sphere: {radius: 3, center_z: -8}}, center_of_gravity: [0, -8], panels: 100}"
BOX = "{shape: {box: {length: 12, width: 8, draft: 1.5}}, center_of_gravity: [0, -0.3], panels: 60}"
STILL = "spectrum: still"


def motions(body: str, *, depth: str = "deep", waves: str = STILL) -> dict[str, Variable]:
    text = f"water: {{depth: {depth}}}\nbodies:\n  float: {body}\nwaves: {{{waves}}}\n"
    outputs = checked_program(text).outputs
    names = ("surge", "heave", "pitch")
    return {v.name.removeprefix("float."): v for v in outputs if v.name.endswith(names)}


@pytest.mark.parametrize(
    ("body", "depth", "low", "high", "off"),
    [
        (BOX, "deep", -0.75, 0.75, 1e-9),
        (BOX, "1.6", -0.1, 0.75, 1e-9),
        # a ball of 3 m radius, 8 m deep; panels are within 0.3 m of it
        (BALL, "12", -1.0, 5.0, 0.3),
    ],
)
def test_heave_is_within_the_draft_the_surface_and_the_bed(
    body: str, depth: str, low: float, high: float, off: float
) -> None:
    heave = motions(body, depth=depth)["heave"]
    assert (heave.minimum, heave.maximum) == pytest.approx((low, high), abs=off)


def test_pitch_is_within_15_deg_and_surge_within_a_tenth_of_the_wave_length() -> None:
    """g T²/2π in deep water; in still water as far as bodies feel each other, or anywhere."""
    length = 9.81 * 6.0**2 / (2 * math.pi)
    surge = motions(BOX, waves="spectrum: jonswap, significant_height: 1, peak_period: 6")["surge"]
    assert surge.maximum == -surge.minimum == pytest.approx(0.1 * length, rel=1e-9)
    still = motions(BOX)
    assert still["surge"].maximum == math.inf
    assert still["pitch"].maximum == -still["pitch"].minimum == math.radians(15.0)
    other = BOX.replace("draft: 1.5", "draft: 1.5, center_x: 14").replace("[0, ", "[14, ")
    surge = motions(f"{BOX}\n  other: {other}")["surge"]
    assert surge.maximum == -surge.minimum == 3.5
