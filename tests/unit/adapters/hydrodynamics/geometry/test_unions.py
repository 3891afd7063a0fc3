"""Unions of shapes: volumes, even panels, symmetry; what uses them."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import mesh_writers
from support.hulls import hull, silent

from m4e_adapters.hydrodynamics.config import Body, Box, Water
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry import remeshing
from m4e_adapters.hydrodynamics.geometry.checks import checked
from m4e_adapters.hydrodynamics.geometry.drawn_hulls import drawn_hulls
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels
from m4e_adapters.hydrodynamics.pressure.closed_hull import closed_hull
from m4e_adapters.hydrodynamics.pressure.config import HullBody
from m4e_fmi.errors import InputError

SPAR = [
    {"cylinder": {"radius": 4, "draft": 15, "freeboard": 6}},
    {"cylinder": {"radius": 9, "draft": 18, "top_z": -15}},
]
STACKED = [
    {"cylinder": {"radius": 4, "draft": 3, "freeboard": 2}},
    {"cylinder": {"radius": 4, "draft": 8, "top_z": -3}},
]
COLUMNS = [
    {"cylinder": {"radius": 3, "draft": 11, "freeboard": 5, "center_x": x, "center_y": y}}
    for x in (-10, 10)
    for y in (-12, 12)
]
SEMI = [
    *(
        {"box": {"length": 30, "width": 9, "draft": 14, "top_z": -10, "center_y": y}}
        for y in (-12, 12)
    ),
    {"box": {"length": 4, "width": 24, "draft": 13, "top_z": -11}},
    *COLUMNS,
]
VOLUMES = {
    "spar": (SPAR, math.pi * (16 * 15 + 81 * 3), 16 * math.pi),
    "stacked": (STACKED, 128 * math.pi, 16 * math.pi),
    "semi": (SEMI, 2 * 30 * 9 * 4 + 4 * 15 * 2 + 4 * math.pi * 9 * 10, 36 * math.pi),
    "columns": (COLUMNS, 4 * math.pi * 9 * 11, 36 * math.pi),
}
"""Parts, their volume [m3] below the water, and the waterplane [m2]."""


def made(parts: list[dict[str, Any]], panels: int, folder: Path = Path()) -> Hull:
    return hull({"union": parts}, folder, center=(0.0, -3.0), panels=panels)


@pytest.mark.parametrize("name", VOLUMES)
def test_volume_waterplane_and_panels(name: str) -> None:
    """Of the solid's facets to 1e-4; its triangles enclose exactly that, and are not thin."""
    parts, volume, waterplane = VOLUMES[name]
    found = made(parts, 700)
    assert checked(found.panels, "float") is found.panels
    assert 600 < len(found.panels.faces) < 1700
    assert found.hydrostatics.volume == pytest.approx(volume, rel=2e-4)
    assert found.hydrostatics.waterplane[0] == pytest.approx(waterplane, rel=2e-4)
    own = hydrostatics_of(found.panels)
    assert own.volume == pytest.approx(found.hydrostatics.volume, rel=1e-9)
    assert own.waterplane[0] == pytest.approx(waterplane, rel=5e-3)
    assert remeshing.thinness(found.panels.corners[:, :3]) < 40
    assert found.lid is not None
    assert hydrostatics_of(found.lid).waterplane[0] == pytest.approx(own.waterplane[0], rel=1e-9)
    for surface in (found.panels, found.lid):
        assert surface.half(0) is not None
        assert surface.half(1) is not None
    # a body of revolution turns without moving the water
    assert found.axis == ((0.0, 0.0) if name in ("spar", "stacked") else None)
    if name == "columns":  # the same panels each time
        np.testing.assert_array_equal(made(parts, 700).panels.corners, found.panels.corners)


@pytest.mark.verifies(
    "added mass, damping and force of a cylinder as a union of two, 400 triangles",
    independent="the cylinder itself, 900 panels",
    tolerance="5e-2",
)
def test_two_stacked_cylinders_are_one() -> None:
    """Surge and heave, over the largest value: within what so many panels resolve."""
    whole = hull({"cylinder": {"radius": 4, "draft": 8}}, center=(0, -3), panels=900)
    one, two = (
        solve_hulls([h], water=Water(), omega=np.array([0.6, 1.1]), progress=silent)
        for h in (whole, made(STACKED, 400))
    )
    np.testing.assert_allclose(two.hydrostatic_stiffness[1, 1], one.hydrostatic_stiffness[1, 1])
    for name in ("added_mass", "radiation_damping", "added_mass_inf"):
        found, right = (getattr(c, name)[..., [0, 1], [0, 1]] for c in (two, one))
        assert np.all(np.abs(found - right) < 0.05 * np.abs(right).max(axis=0))
    scale = np.abs(one.excitation[:, :2]).max(axis=0)
    assert np.all(np.abs(two.excitation - one.excitation)[:, :2] < 0.03 * scale)


def test_meshes_are_parts_too_and_drawn(tmp_path: Path) -> None:
    """A box in a file that is open at the waterline, and a keel; and a box aside of a spar."""
    panels = box_panels(Box(length=8, width=6, draft=3), 60)
    (tmp_path / "a.gdf").write_text(mesh_writers.gdf(panels))
    keel = {"box": {"length": 4, "width": 1, "draft": 6, "top_z": -2}}
    water = made([{"mesh": "a.gdf"}, keel], 300, tmp_path).hydrostatics
    assert water.volume == pytest.approx(8 * 6 * 3 + 4 * 3, rel=1e-9)
    assert water.waterplane[0] == pytest.approx(48, rel=1e-9)
    panels = box_panels(Box(length=2, width=2, draft=1, top_z=-0.5, center_x=50), 60)
    (tmp_path / "a.gdf").write_text(mesh_writers.gdf(panels))
    shape = {"union": [*SPAR, {"mesh": "a.gdf"}]}
    body = Body.model_validate({"shape": shape, "center_of_gravity": [0, -8]})
    (drawn,) = drawn_hulls({"spar": body}, tmp_path)
    low, high = drawn.surface.vertices.min(axis=0), drawn.surface.vertices.max(axis=0)
    np.testing.assert_allclose(low, [-9, -9, -18 + 8], atol=1e-9)
    np.testing.assert_allclose(high, [51, 9, 6 + 8], atol=1e-9)
    assert max(map(max, drawn.surface.faces)) == len(drawn.surface.vertices) - 1


def test_the_pressure_takes_the_whole_union() -> None:
    body = {"shape": {"union": SPAR}, "center_of_gravity": [0, -12]}
    volume = hydrostatics_of(closed_hull("spar", HullBody.model_validate(body), Path())).volume
    assert volume == pytest.approx(math.pi * (16 * 21 + 81 * 3), rel=2e-4)


@pytest.mark.parametrize("library", ["manifold3d", "mmgpy"])
def test_a_missing_library_is_named(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=f"a union of shapes needs the library {library}"):
        made(SPAR, 300)
