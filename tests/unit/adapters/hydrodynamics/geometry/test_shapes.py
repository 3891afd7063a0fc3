"""Built-in shapes: exact for any number of panels, closed, symmetric, with lids."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.hulls import hull

from m4e_adapters.hydrodynamics.config import Shape
from m4e_adapters.hydrodynamics.geometry.checks import checked
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.solids import drawn_shape


def below(radius: float, height: float) -> float:
    """Area [m2] below the water of a disc whose centre is at that height, by its chords."""
    z = np.linspace(height - radius, min(0.0, height + radius), 200_001)
    chords = 2 * np.sqrt(np.maximum(radius**2 - (z - height) ** 2, 0.0))
    return float(np.trapezoid(chords, z))


def lying(z: float = 0.0, axis: str = "x") -> dict[str, Any]:
    return {"horizontal_cylinder": {"radius": 2, "length": 10, "axis": axis, "center_z": z}}


PI = math.pi
SHAPES: dict[str, tuple[dict[str, Any], float, float, float | None]] = {
    "cylinder": ({"cylinder": {"radius": 4, "draft": 3}}, 48 * PI, 16 * PI, -1.5),
    "half a ball": ({"sphere": {"radius": 5}}, 250 / 3 * PI, 25 * PI, -15 / 8),
    "most of a ball": ({"sphere": {"radius": 5, "center_z": -2}}, 392 / 3 * PI, 21 * PI, None),
    "a ball": ({"sphere": {"radius": 5, "center_z": -8}}, 500 / 3 * PI, 0.0, -8.0),
    "box": ({"box": {"length": 20, "width": 10, "draft": 4}}, 800.0, 200.0, -2.0),
    # a cylinder below a frustum, that the water cuts at its radius of 3 m
    "frustum": (
        {"revolved": {"profile": [[4, -3], [4, -2], [2, 2], [0, 2]]}},
        PI * (16 + 2 / 3 * (16 + 12 + 9)), 9 * PI, None,
    ),
    # a quarter of its height below its base
    "cone": ({"revolved": {"profile": [[0, -3], [4, 0]]}}, 16 * PI, 16 * PI, -0.75),
    "stepped": (
        {"revolved": {"profile": [[4, -6], [4, -5], [2, -5], [2, -3]]}},
        24 * PI, 0.0, (16 * -5.5 + 8 * -4.0) / 24,
    ),
    # of a hole, a frustum below a cylinder
    "submerged ring of revolution": (
        {"revolved": {"profile": [[3, -6], [5, -5], [5, -4]], "hole": 2}},
        PI * (49 / 3 + 5**2 - 2 * 2**2), 0.0, None,
    ),
    "submerged cylinder": (
        {"cylinder": {"radius": 4, "draft": 10, "top_z": -3}}, 112 * PI, 0.0, -6.5
    ),
    "submerged box": (
        {"box": {"length": 6, "width": 4, "draft": 5, "top_z": -2}}, 72.0, 0.0, -3.5
    ),
    "half a lying cylinder": (lying(), 20 * PI, 40.0, None),
    "along y, nearly submerged": (lying(-1.6, "y"), 10 * below(2, -1.6), 24.0, None),
    "a floating tube": (lying(1.2), 10 * below(2, 1.2), 32.0, None),
    "a pontoon": (lying(-4), 40 * PI, 0.0, -4.0),
}  # fmt: skip
"""Shape, its volume [m3] and waterplane [m2], the height [m] of its middle where that is exact."""
SUBMERGED = [name for name, (_, _, waterplane, _) in SHAPES.items() if not waterplane]
REVOLVED = ("cylinder", "sphere", "revolved")


def made(name: str, panels: int, x: float = 7.0) -> Hull:
    (kind, keys), *_ = SHAPES[name][0].items()
    return hull({kind: {**keys, "center_x": x}}, center=(x, 0.0, -0.6), panels=panels)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("panels", [48, 500])
def test_volume_and_waterplane_are_exact(name: str, panels: int) -> None:
    shape, volume, waterplane, middle = SHAPES[name]
    found = made(name, panels)
    assert checked(found.panels, "float") is found.panels
    assert 0.7 * panels < len(found.panels.faces) < 2.6 * panels
    assert found.axis == ((7.0, 0.0) if next(iter(shape)) in REVOLVED else None)
    water = found.hydrostatics
    assert water.volume == pytest.approx(volume, rel=1e-7)
    assert water.waterplane[0] == pytest.approx(waterplane, rel=1e-9, abs=1e-9)
    assert water.center_of_buoyancy[:2] == pytest.approx((7.0, 0.0), abs=1e-9)
    if middle is not None:
        assert water.center_of_buoyancy[2] == pytest.approx(middle, rel=1e-9)
    assert (found.lid is None) == (name in SUBMERGED)
    if found.lid is not None:
        assert hydrostatics_of(found.lid).waterplane[0] == pytest.approx(waterplane, rel=1e-9)
        assert np.all(found.lid.vertices[:, 2] == 0.0)


@pytest.mark.parametrize("name", SHAPES)
def test_surface_and_lid_are_symmetric_and_their_panels_are_not_thin(name: str) -> None:
    found = made(name, 300, x=0.0)
    for surface in filter(None, (found.panels, found.lid)):
        for axis in (0, 1):
            half = surface.half(axis)
            assert half is not None
            assert 2 * len(half.faces) == len(surface.faces)
    corners = found.panels.corners
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    assert np.max(sides**2 / (0.5 * np.linalg.norm(normals, axis=1))) < 40


def test_the_length_of_a_lying_cylinder_is_along_its_axis() -> None:
    for axis, extents in (("x", (10.0, 4.0)), ("y", (4.0, 10.0))):
        found = np.ptp(hull(lying(axis=axis), panels=300).panels.vertices, axis=0)[:2]
        assert tuple(found) == pytest.approx(extents)


@pytest.mark.parametrize(
    ("shape", "volume", "depth"),
    [
        ({"box": {"length": 20, "width": 8, "draft": 3, "freeboard": 2}}, 800.0, 3.0),
        ({"sphere": {"radius": 2.0, "center_z": 0.7}}, 32 / 3 * PI, 1.3),
        ({"cylinder": {"radius": 2.0, "draft": 3.0, "freeboard": 1.0}}, 16 * PI, 3.0),
        ({"revolved": {"profile": [[3, -6], [1, -2], [1, 4]]}}, PI * (4 / 3 * 13 + 6), 6.0),
        ({"revolved": {"profile": [[3, -6], [3, 4]], "hole": 2}}, PI * 5 * 10, 6.0),
    ],
)
def test_shapes_with_a_freeboard_are_closed(
    shape: dict[str, Any], volume: float, depth: float
) -> None:
    panels = drawn_shape(Shape.model_validate(shape))
    assert hydrostatics_of(panels).volume == pytest.approx(volume, rel=1e-9)
    # a ball is stretched to its volume
    assert -panels.vertices[:, 2].min() == pytest.approx(depth, abs=0.02)
