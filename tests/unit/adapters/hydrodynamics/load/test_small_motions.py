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
    ("body", "depth", "low", "high", "said"),
    [
        (BOX, "deep", -0.75, 0.75, "for motions within 0.5 of the mean draft"),
        (BOX, "10", -0.75, 0.75, "for motions within 0.5 of the mean draft"),
        (BOX, "1.6", -0.1, 0.75, "and the sea bed 0.1 m below it"),
        # a ball of 3 m radius, 8 m deep; panels are within 0.3 m of it
        (BALL, "deep", -5.0, 5.0, "its surface is"),
        (BALL, "12", -1.0, 1.0, ""),
    ],
)
def test_heave_is_within_the_draft_the_surface_and_the_bed(
    body: str, depth: str, low: float, high: float, said: str
) -> None:
    heave = motions(body, depth=depth)["heave"]
    off = 1e-9 if body == BOX else 0.3
    assert heave.minimum == pytest.approx(low, abs=off)
    assert heave.maximum == pytest.approx(high, abs=off) or not said
    assert said in heave.description


def test_pitch_is_within_15_deg_and_surge_within_a_tenth_of_the_wave_length() -> None:
    """g T²/2π in deep water, at the peak of a sea; a single body in still water may go anywhere."""
    length = 9.81 * 6.0**2 / (2 * math.pi)
    jonswap = "spectrum: jonswap, significant_height: 1, peak_period: 6"
    for waves in ("spectrum: regular, height: 1, period: 6", jonswap):
        surge = motions(BOX, waves=waves)["surge"]
        assert surge.maximum == -surge.minimum == pytest.approx(0.1 * length, rel=1e-9)
        assert "within 0.1 of their length of 56.21 m" in surge.description
    still = motions(BOX)
    assert still["surge"].maximum == math.inf
    assert still["pitch"].maximum == -still["pitch"].minimum == math.radians(15.0)


def test_bodies_in_still_water_stay_where_they_feel_each_other() -> None:
    other = BOX.replace("draft: 1.5", "draft: 1.5, center_x: 14").replace("[0, ", "[14, ")
    surge = motions(f"{BOX}\n  other: {other}")["surge"]
    assert surge.maximum == -surge.minimum == 3.5
    assert "distance of 14 m" in surge.description
