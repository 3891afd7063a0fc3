"""Righting arms of whole hulls, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Shape
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.geometry.solids import drawn_shape
from m4e_adapters.hydrodynamics.geometry.stability import (
    PITCH,
    WholeHull,
    turn,
)
from m4e_fmi.errors import InputError

LENGTH, WIDTH, DRAFT, FREEBOARD = 20.0, 8.0, 3.0, 2.0
BOX = {"box": {"length": LENGTH, "width": WIDTH, "draft": DRAFT, "freeboard": FREEBOARD}}
VOLUME = LENGTH * WIDTH * DRAFT
ROUNDING = 1e-9


def whole(shape: dict) -> Panels:
    return drawn_shape(Shape.model_validate(shape))


def box(center: tuple[float, float, float] = (0.0, 0.0, -0.5), volume: float = VOLUME) -> WholeHull:
    return WholeHull(whole(BOX), center, volume)


@pytest.mark.parametrize(("about", "breadth"), [("heel", WIDTH), (PITCH, LENGTH)])
@pytest.mark.parametrize("angle", [0.05, -0.2])
def test_a_box_while_its_walls_are_cut(about: str, breadth: float, angle: float) -> None:
    """Wall-sided formula: GZ = sin φ (GM + ½ BM tan² φ)."""
    if abs(math.tan(angle)) > 2 * FREEBOARD / breadth:
        angle = math.copysign(0.15, angle)
    found = box().arms([angle], about=about)
    bm = breadth**2 / (12 * DRAFT)
    gm = bm - DRAFT / 2 + 0.5
    exact = math.sin(angle) * (gm + 0.5 * bm * math.tan(angle) ** 2)
    assert found.arms[0] == pytest.approx(exact, abs=ROUNDING)
    assert math.isnan(found.flooded)


def test_the_curve_of_an_open_box_ends_where_water_enters() -> None:
    """At tan φ = 2 f/b, 26.6 deg."""
    closed = whole(BOX)
    without = Panels(closed.vertices, np.delete(closed.faces, 1, axis=0))
    angles = np.radians(np.arange(0.0, 41.0, 1.0)).tolist()
    for surface, flooded, last in ((closed, math.nan, 40.0), (without, 27.0, 26.0)):
        found = WholeHull(surface, (0.0, 0.0, -0.5), VOLUME).arms(angles)
        assert math.degrees(found.flooded) == pytest.approx(flooded, nan_ok=True)
        assert math.degrees(found.angles[-1]) == pytest.approx(last)


@pytest.mark.parametrize("center_z", [-1.5, 2.0])
def test_a_ball_turns_about_its_middle(center_z: float) -> None:
    """GZ = GM sin φ at any angle and draft, but for the panels, which are h²/8R off the ball."""
    surface = whole({"sphere": {"radius": 5.0, "center_z": center_z}})
    depth = 5.0 - center_z
    hull = WholeHull(surface, (0.0, 0.0, center_z - 2.0), math.pi * depth**2 * (15 - depth) / 3)
    angles = np.radians([10.0, 40.0, 90.0, 150.0])
    found = hull.arms(angles.tolist())
    assert np.abs(found.arms - 2.0 * np.sin(angles)).max() < 3 * (4 * math.pi * 25 / 3000) / (8 * 5)


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


def test_a_box_that_sinks() -> None:
    with pytest.raises(InputError, match="the hull sinks: it has 800 m3, 900 m3"):
        box(volume=900.0)
