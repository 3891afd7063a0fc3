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


def test_a_floating_body_moves_by_half_its_draft() -> None:
    """Deep water, and water whose bed is below that."""
    for depth in ("deep", "10"):
        heave = motions(BOX, depth=depth)["heave"]
        assert (heave.minimum, heave.maximum) == pytest.approx((-0.75, 0.75), rel=1e-9)
        assert heave.description.endswith("for motions within 0.5 of the mean draft")


def test_the_keel_stays_above_the_sea_bed() -> None:
    heave = motions(BOX, depth="1.6")["heave"]
    assert (heave.minimum, heave.maximum) == pytest.approx((-0.1, 0.75), rel=1e-9)
    assert "and the sea bed 0.1 m below it" in heave.description


def test_a_submerged_body_stays_below_the_surface() -> None:
    """A ball of 3 m radius, 8 m deep; panels are within 0.3 m of it."""
    heave = motions(BALL)["heave"]
    assert heave.maximum == -heave.minimum == pytest.approx(5.0, abs=0.3)
    assert "its surface is" in heave.description
    shallow = motions(BALL, depth="12")["heave"]
    assert shallow.minimum == pytest.approx(-1.0, abs=0.3)


def test_pitch_is_within_15_deg() -> None:
    pitch = motions(BOX)["pitch"]
    assert pitch.maximum == -pitch.minimum == math.radians(15.0)


def test_surge_is_within_a_tenth_of_the_wave_length() -> None:
    """g T²/2π in deep water, at the peak of a sea; a single body in still water may go anywhere."""
    length = 9.81 * 6.0**2 / (2 * math.pi)
    jonswap = "spectrum: jonswap, significant_height: 1, peak_period: 6"
    for waves in ("spectrum: regular, height: 1, period: 6", jonswap):
        surge = motions(BOX, waves=waves)["surge"]
        assert surge.maximum == -surge.minimum == pytest.approx(0.1 * length, rel=1e-9)
        assert "within 0.1 of their length of 56.21 m" in surge.description
    assert motions(BOX)["surge"].maximum == math.inf


def test_bodies_in_still_water_stay_where_they_feel_each_other() -> None:
    other = BOX.replace("draft: 1.5", "draft: 1.5, center_x: 14").replace("[0, ", "[14, ")
    surge = motions(f"{BOX}\n  other: {other}")["surge"]
    assert surge.maximum == -surge.minimum == 3.5
    assert "distance of 14 m" in surge.description
