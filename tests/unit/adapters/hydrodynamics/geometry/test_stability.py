"""Righting arms and poses at rest of whole hulls, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Shape
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.geometry.stability import (
    PITCH,
    WholeHull,
    heel_and_trim,
    turn,
)
from m4e_adapters.hydrodynamics.stability_report import whole_shape
from m4e_fmi.errors import InputError

LENGTH, WIDTH, DRAFT, FREEBOARD = 20.0, 8.0, 3.0, 2.0
BOX = {"box": {"length": LENGTH, "width": WIDTH, "draft": DRAFT, "freeboard": FREEBOARD}}
VOLUME = LENGTH * WIDTH * DRAFT
ROUNDING = 1e-9


def whole(shape: dict, panels: int = 600) -> Panels:
    found = whole_shape(Shape.model_validate(shape), panels)
    assert found is not None
    return found


def box(center: tuple[float, float, float] = (0.0, 0.0, -0.5), volume: float = VOLUME) -> WholeHull:
    return WholeHull(whole(BOX), center, volume)


@pytest.mark.parametrize(("about", "breadth"), [("heel", WIDTH), (PITCH, LENGTH)])
@pytest.mark.parametrize("angle", [0.05, -0.2])
def test_a_box_while_its_walls_are_cut(about: str, breadth: float, angle: float) -> None:
    """Wall-sided formula: GZ = sin φ (GM + ½ BM tan² φ); the deck goes under at tan φ = 2 f/b."""
    if abs(math.tan(angle)) > 2 * FREEBOARD / breadth:
        angle = math.copysign(0.15, angle)
    found = box().arms([angle], about=about)
    bm = breadth**2 / (12 * DRAFT)
    gm = bm - DRAFT / 2 + 0.5
    exact = math.sin(angle) * (gm + 0.5 * bm * math.tan(angle) ** 2)
    assert found.arms[0] == pytest.approx(exact, abs=ROUNDING)
    assert math.isnan(found.deck)


def test_the_deck_edge_of_a_box_with_a_deck_and_without() -> None:
    """At tan φ = 2 f/b, searched to 1e-4 rad; the curve of an open box ends there."""
    closed = whole(BOX)
    without = Panels(closed.vertices, np.delete(closed.faces, 1, axis=0))
    angles, edge = np.radians(np.arange(0.0, 41.0, 1.0)).tolist(), math.atan(2 * FREEBOARD / WIDTH)
    for surface, deck, flooded, last in (
        (closed, edge, math.nan, 40.0),
        (without, math.nan, edge, 26.0),
    ):
        found = WholeHull(surface, (0.0, 0.0, -0.5), VOLUME).arms(angles)
        assert found.deck == pytest.approx(deck, abs=2e-4, nan_ok=True)
        assert found.flooded == pytest.approx(flooded, abs=2e-4, nan_ok=True)
        assert math.degrees(found.angles[-1]) == pytest.approx(last)


@pytest.mark.parametrize("center_z", [-1.5, 2.0])
def test_a_ball_turns_about_its_middle(center_z: float) -> None:
    """GZ = GM sin φ at any angle and draft; the error is of second order in the panels' size."""
    errors = []
    for panels in (400, 1600):
        shape = {"sphere": {"radius": 5.0, "center_z": center_z}}
        surface = whole(shape, panels)
        depth = 5.0 - center_z
        hull = WholeHull(surface, (0.0, 0.0, center_z - 2.0), math.pi * depth**2 * (15 - depth) / 3)
        angles = np.radians([10.0, 40.0, 90.0, 150.0])
        found = hull.arms(angles.tolist())
        errors.append(np.abs(found.arms - 2.0 * np.sin(angles)).max())
    # panels of the side h are up to h²/8R off the ball; three of these
    assert errors[0] < 3 * (4 * math.pi * 25 / 400) / (8 * 5)
    assert errors[1] < errors[0] / 2.5


def test_arms_are_the_slope_of_the_potential_energy() -> None:
    """∫GZ dφ is the rise of G over B: no closed form of GZ takes part.

    A box off its middle, through the immersion of its deck. Gauss's rule on short parts.
    """
    hull = box((1.0, 0.4, 0.8))
    nodes, weights = np.polynomial.legendre.leggauss(3)
    start, end = 0.1, 1.1
    edges = np.linspace(start, end, 16)
    middles, halves = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    angles = (middles[:, None] + halves[:, None] * nodes).ravel()
    work = float(hull.arms(angles.tolist()).arms @ np.outer(halves, weights).ravel())
    poses = [hull.afloat(turn((angle, 0.0, 0.0))) for angle in (start, end)]
    levels = [pose.height - pose.hydrostatics.center_of_buoyancy[2] for pose in poses]
    assert work == pytest.approx(levels[1] - levels[0], abs=1e-4)


def test_rest_of_a_box_with_its_weight_off_the_middle() -> None:
    """tan φ (BM + ½ BM tan² φ + B − G) = the lever, while the walls are cut."""
    lever, g = 0.3, -0.5
    rest = box((0.0, -lever, g)).at_rest()
    assert rest is not None
    found, rotation = rest
    heel, trim = heel_and_trim(rotation)
    bm = WIDTH**2 / (12 * DRAFT)
    t = math.tan(heel)
    # B and G on one plumb line: y_B + lever = -(z_B - z_G) tan φ in the box's axes
    assert bm * t * (1 + 0.5 * t**2) - lever == pytest.approx((DRAFT / 2 + g) * t, abs=1e-8)
    assert heel > 0  # weight towards -Y puts this side down
    assert trim == pytest.approx(0.0, abs=ROUNDING)
    assert found.hydrostatics.volume == pytest.approx(VOLUME, rel=1e-9)


def test_a_box_that_is_not_stable_lolls() -> None:
    """Of G = GM0 below zero: tan² φ = −2 GM/BM (wall-sided)."""
    bm = WIDTH**2 / (12 * DRAFT)
    g = -DRAFT / 2 + bm + 0.05
    rest = box((0.0, 0.0, g)).at_rest()
    assert rest is not None
    heel, _ = heel_and_trim(rest[1])
    assert math.tan(heel) ** 2 == pytest.approx(2 * 0.05 / bm, rel=1e-6)


def test_a_box_that_capsizes_or_sinks_has_no_rest() -> None:
    assert box((0.0, 0.0, 6.0)).at_rest() is None
    with pytest.raises(InputError, match="the hull sinks: it has 800 m3, 900 m3"):
        box(volume=900.0)
