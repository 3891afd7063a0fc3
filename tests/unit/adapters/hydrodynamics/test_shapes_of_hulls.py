"""Horizontal cylinders, rings, submerged cylinders and boxes: exact for any number of panels."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Body
from m4e_adapters.hydrodynamics.geometry.checks import checked
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hull


def below(radius: float, height: float) -> float:
    """Area [m2] below the water of a disc whose centre is at that height, by its chords."""
    z = np.linspace(height - radius, min(0.0, height + radius), 200_001)
    chords = 2 * np.sqrt(np.maximum(radius**2 - (z - height) ** 2, 0.0))
    return float(np.trapezoid(chords, z))


SHAPES = {
    "submerged cylinder": (
        {"cylinder": {"radius": 4, "draft": 10, "top_z": -3}}, 112 * math.pi, 0.0, -6.5
    ),
    "submerged box": (
        {"box": {"length": 6, "width": 4, "draft": 5, "top_z": -2}}, 72.0, 0.0, -3.5
    ),
    "half immersed": (
        {"horizontal_cylinder": {"radius": 2, "length": 10}}, 20 * math.pi, 40.0, None
    ),
    "along y, nearly submerged": (
        {"horizontal_cylinder": {"radius": 2, "length": 10, "axis": "y", "center_z": -1.6}},
        10 * below(2, -1.6), 24.0, None,
    ),
    "a floating tube": (
        {"horizontal_cylinder": {"radius": 2, "length": 10, "center_z": 1.2}},
        10 * below(2, 1.2), 32.0, None,
    ),
    "a pontoon": (
        {"horizontal_cylinder": {"radius": 2, "length": 10, "center_z": -4}},
        40 * math.pi, 0.0, -4.0,
    ),
    "ring": (
        {"torus": {"radius": 6, "tube_radius": 1.5}},
        12 * math.pi * below(1.5, 0.0), math.pi * (7.5**2 - 4.5**2), None,
    ),
    "submerged ring": (
        {"torus": {"radius": 6, "tube_radius": 1.5, "center_z": -3}},
        12 * math.pi**2 * 1.5**2, 0.0, -3.0,
    ),
}  # fmt: skip
"""Shape, its volume [m3] and waterplane [m2], the height [m] of its middle where that is exact."""


def made(shape: dict, panels: int, x: float = 7.0) -> Hull:
    (kind, keys), *_ = shape.items()
    body = {"shape": {kind: {**keys, "center_x": x}}, "center_of_gravity": [x, 0.0, -0.6]}
    body["panels"] = panels
    return make_hull("float", Body.model_validate(body), Path(), progress=lambda _: None)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("panels", [48, 500])
def test_volume_and_waterplane_are_exact(name: str, panels: int) -> None:
    shape, volume, waterplane, middle = SHAPES[name]
    hull = made(shape, panels)
    assert checked(hull.panels, "float") is hull.panels
    assert 0.7 * panels < len(hull.panels.faces) < 2.6 * panels
    found = hull.hydrostatics
    assert found.volume == pytest.approx(volume, rel=1e-7)
    assert found.waterplane[0] == pytest.approx(waterplane, rel=1e-12, abs=1e-9)
    assert found.center_of_buoyancy[:2] == pytest.approx((7.0, 0.0), abs=1e-9)
    if middle is not None:
        assert found.center_of_buoyancy[2] == pytest.approx(middle, rel=1e-9)
    if waterplane:
        assert hull.lid is not None
        assert hydrostatics_of(hull.lid).waterplane[0] == pytest.approx(waterplane, rel=1e-9)


@pytest.mark.parametrize("name", SHAPES)
def test_surface_and_lid_are_symmetric_and_their_panels_are_not_thin(name: str) -> None:
    hull = made(SHAPES[name][0], 300, x=0.0)
    for surface in filter(None, (hull.panels, hull.lid)):
        for axis in (0, 1):
            assert surface.half(axis) is not None
    corners = hull.panels.corners
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    assert np.max(sides**2 / (0.5 * np.linalg.norm(normals, axis=1))) < 40


def test_the_length_of_a_horizontal_cylinder_is_along_its_axis() -> None:
    for axis, extents in (("x", (10.0, 4.0)), ("y", (4.0, 10.0))):
        shape = {"horizontal_cylinder": {"radius": 2, "length": 10, "axis": axis}}
        found = np.ptp(made(shape, 300).panels.vertices, axis=0)[:2]
        assert tuple(found) == pytest.approx(extents)


def test_a_ring_is_a_body_of_revolution() -> None:
    assert made(SHAPES["ring"][0], 100).axis == (7.0, 0.0)
    assert made(SHAPES["half immersed"][0], 100).axis is None
