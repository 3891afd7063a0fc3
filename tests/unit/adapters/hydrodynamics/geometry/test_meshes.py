"""Meshes from files of all formats: units, frames, halves; what passes, and inner shells."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support import mesh_writers
from support.hulls import configured, hull, hulls

from m4e_adapters.hydrodynamics.build import frequency_table
from m4e_adapters.hydrodynamics.config import Box, Cylinder
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.lid import make_lid
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.mesh_files import read_mesh
from m4e_adapters.hydrodynamics.geometry.panels import Panels, grid, joined
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels, cylinder_panels
from m4e_fmi.errors import InputError


def cylinder() -> Panels:
    """A cylinder of triangles and quadrilaterals, aside of the axes."""
    return cylinder_panels(Cylinder(radius=3.0, draft=2.0, center_x=5.0), 60)


def box() -> Panels:
    return box_panels(Box(length=6.0, width=4.0, draft=2.0), 100)


def moved(panels: Panels, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Panels:
    return Panels(panels.vertices + np.array([x, y, z]), panels.faces)


def of_file(panels: Panels, folder: Path, name: str = "hull.gdf", **keys: object) -> Hull:
    """The hull of these panels in a file, its centre of gravity at (5, −0.5)."""
    content = mesh_writers.WRITERS[name](panels)
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return hull({"mesh": name, **keys}, folder, center=(5.0, -0.5))


@pytest.mark.parametrize("name", mesh_writers.WRITERS)
def test_every_format_is_read_panel_by_panel(name: str, tmp_path: Path) -> None:
    """And in mm in the frame of its body: `mesh_origin` is counted from the centre of gravity."""
    drawn = cylinder()
    volume = hydrostatics_of(drawn).volume
    assert of_file(drawn, tmp_path, name).hydrostatics.volume == pytest.approx(volume, rel=1e-6)
    found = read_mesh(tmp_path / name)
    assert len(found.vertices) == len(drawn.vertices)
    if not name.lower().endswith("stl"):  # which has triangles only
        order = [np.lexsort(p.centers.round(6).T) for p in (found, drawn)]
        np.testing.assert_allclose(found.centers[order[0]], drawn.centers[order[1]], atol=1e-7)
    in_mm = Panels(1000.0 * (drawn.vertices - [5.0, 0.0, -0.5]), drawn.faces)
    for origin, depth in (([0.0, 0.0], 2.0), ([0.5, 0.25], 1.75)):
        keys = {"scale": 0.001, "frame": "body", "mesh_origin": origin}
        water = of_file(in_mm, tmp_path, name, **keys).hydrostatics
        assert water.volume == pytest.approx(np.pi * 9.0 * depth, rel=1e-6)
        center = (5.0 + origin[0], 0.0, -depth / 2)
        assert water.center_of_buoyancy == pytest.approx(center, abs=1e-5)


@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)], ids=["ISX", "ISY", "ISX and ISY"])
def test_halves_of_wamit_are_completed(axes: tuple[int, ...], tmp_path: Path) -> None:
    whole = cylinder_panels(Cylinder(radius=3.0, draft=2.0), 60)
    part = whole
    for axis in axes:
        part = part.selected(part.centers[:, axis] > 0)
    (tmp_path / "a.gdf").write_text(mesh_writers.gdf(part, isx=0 in axes, isy=1 in axes))
    found = read_mesh(tmp_path / "a.gdf")
    assert len(found.faces) == len(whole.faces)
    assert hydrostatics_of(found).volume == pytest.approx(hydrostatics_of(whole).volume, rel=1e-7)


def test_a_mesh_is_cut_at_the_water_without_what_no_panel_uses(tmp_path: Path) -> None:
    made = of_file(moved(box(), z=0.5), tmp_path)
    assert made.hydrostatics.volume == pytest.approx(6 * 4 * 1.5, rel=1e-6)
    assert made.hydrostatics.waterplane[0] == pytest.approx(24.0, rel=1e-6)
    assert made.lid is not None
    x, y = np.linspace(-3, 3, 4), np.linspace(-2, 2, 3)
    deck = grid(np.array([[[u, v, 0.0] for v in y] for u in x]))
    decked = of_file(joined(box(), deck), tmp_path)
    assert decked.hydrostatics.volume == pytest.approx(48, rel=1e-6)
    (tmp_path / "a.obj").write_text(mesh_writers.obj(box()) + "v 0 0 500\n")
    assert hull({"mesh": "a.obj"}, tmp_path).panels.size == pytest.approx(6.0, rel=0.1)


def smaller(*, z: float = 0.0, closed: bool = True) -> Panels:
    """A box of 3 by 2 m, 1 m deep, whose top, a lid if `closed`, is at `z`."""
    lower = box_panels(Box(length=3.0, width=2.0, draft=1.0), 60)
    lid = make_lid(lower)
    assert lid is not None
    return moved(joined(lower, lid.reversed) if closed else lower, z=z)


@pytest.mark.parametrize("inner", [smaller(z=-0.5).reversed, smaller(closed=False)])
def test_closed_shells_inside_the_hull_are_refused(inner: Panels, tmp_path: Path) -> None:
    """A tank, and a box through the waterline: they made the volume smaller and larger."""
    with pytest.raises(InputError, match="a closed shell is inside the hull near x = "):
        of_file(joined(box(), inner), tmp_path)


def test_hulls_of_one_body_side_by_side_are_a_mesh(tmp_path: Path) -> None:
    """One of the hulls with its normals turned round is not, small as it may be."""
    aside = moved(smaller(), y=5.0)
    both = of_file(joined(box(), aside), tmp_path)
    assert both.hydrostatics.volume == pytest.approx(48 + 6, rel=1e-6)
    with pytest.raises(InputError, match=r"normals point out of the water near x = .*, y = [456]"):
        of_file(joined(box(), aside.reversed), tmp_path)


def test_the_waterplane_of_a_closed_mesh_below_the_water_is_rounding(tmp_path: Path) -> None:
    """Not a size: frequencies end where k (a + d) = 4.5, and not at 10,000 rad/s. Turned, so that
    the sum of its panels' areas is not exactly 0."""
    lower = box()
    lid = make_lid(lower)
    assert lid is not None
    closed = joined(lower, lid.reversed)
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]) / 3.0
    deep = Panels(closed.vertices @ turn.T - [0, 0, 4.0], closed.faces)
    (tmp_path / "hull.gdf").write_text(mesh_writers.gdf(deep))
    body = {"shape": {"mesh": "hull.gdf"}, "center_of_gravity": [0, -4.3]}
    config = configured({"bodies": {"deep": body}})
    size = (1.5 * 48 / 27 / np.pi) ** (1 / 3) + 4.0
    highest = frequency_table(config, hulls(config, tmp_path))[-1]
    assert highest == pytest.approx(np.sqrt(4.5 * 9.81 / size), rel=1e-6)


def test_a_waterline_not_visible_from_its_centre_gets_capytaines_lid() -> None:
    x, z = np.linspace(0, 1, 5), np.linspace(-2, 0, 3)
    corners = np.array([[0, 0], [8, 0], [8, 8], [7, 8], [7, 1], [0, 1], [0, 0]], dtype=float)
    walls = []
    for start, end in pairwise(corners):
        along = start + x[:, None] * (end - start)
        walls.append(grid(np.array([[[*point, height] for height in z] for point in along])))
    for (x1, x2), (y1, y2) in (((0, 8), (0, 1)), ((7, 8), (1, 8))):
        us, vs = (np.linspace(a, b, 2 * (b - a) + 1) for a, b in ((y1, y2), (x1, x2)))
        walls.append(grid(np.array([[[v, u, -2.0] for v in vs] for u in us])))
    lid = make_lid(joined(*walls))
    assert lid is not None
    area = hydrostatics_of(lid).waterplane[0]
    # whole panels of about half a metre on an L of 8 + 7 m2, its edge 32 m long
    assert 15.0 - 0.5 * 32 / 2 < area < 15.0 + 0.5 * 32 / 2
