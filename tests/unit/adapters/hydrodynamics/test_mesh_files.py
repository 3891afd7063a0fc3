"""Mesh files of all formats: units, frames, halves, and what is told of broken ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import mesh_writers

from m4e_adapters.hydrodynamics.config import Body, Cylinder
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hull
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.geometry.readers.mesh_files import read_mesh
from m4e_adapters.hydrodynamics.geometry.shapes import cylinder_panels
from m4e_fmi.errors import InputError


def hull() -> Panels:
    """A cylinder of triangles and quadrilaterals, aside of the axes."""
    return cylinder_panels(Cylinder(radius=3.0, draft=2.0, center_x=5.0), 60)


def made(folder: Path, name: str, **shape: object) -> Hull:
    body = {"shape": {"mesh": name, **shape}, "center_of_gravity": [5.0, -0.5]}
    return make_hull("float", Body.model_validate(body), folder, progress=lambda _: None)


@pytest.mark.parametrize("name", mesh_writers.WRITERS)
def test_every_format_is_read_panel_by_panel(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(mesh_writers.WRITERS[name](hull()))
    found, drawn = read_mesh(tmp_path / name), hull()
    assert len(found.vertices) == len(drawn.vertices)
    order = [np.lexsort(p.centers.round(6).T) for p in (found, drawn)]
    np.testing.assert_allclose(found.centers[order[0]], drawn.centers[order[1]], atol=1e-7)
    volumes = [hydrostatics_of(p).volume for p in (found, drawn)]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-7)


MANUAL = """\
$MeshFormat
4.1 0 8     MSH4.1, ASCII
$EndMeshFormat
$Nodes
1 6 1 6     1 entity bloc, 6 nodes total, min/max node tags: 1 and 6
2 1 0 6     2D entity (surface) 1, no parametric coordinates, 6 nodes
1
2
3
4
5
6
0. 0. 0.
1. 0. 0.
1. 1. 0.
0. 1. 0.
2. 0. 0.
2. 1. 0.
$EndNodes
$Elements
1 2 1 2     1 entity bloc, 2 elements total, min/max element tags: 1 and 2
2 1 3 2     2D entity (surface) 1, element type 3 (4-node quad), 2 elements
1 1 2 3 4
2 2 5 6 3
$EndElements
"""


def test_the_example_of_gmshs_manual(tmp_path: Path) -> None:
    """Gmsh's reference manual, MSH file format: two squares side by side."""
    (tmp_path / "a.msh").write_text(MANUAL)
    found = read_mesh(tmp_path / "a.msh")
    np.testing.assert_array_equal(found.centers, [[0.5, 0.5, 0.0], [1.5, 0.5, 0.0]])


@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)], ids=["ISX", "ISY", "ISX and ISY"])
def test_halves_of_wamit_are_completed(axes: tuple[int, ...], tmp_path: Path) -> None:
    whole = cylinder_panels(Cylinder(radius=3.0, draft=2.0), 60)
    part = whole
    for axis in axes:
        part = part.kept(part.centers[:, axis] > 0)
    (tmp_path / "a.gdf").write_text(mesh_writers.gdf(part, isx=0 in axes, isy=1 in axes))
    found = read_mesh(tmp_path / "a.gdf")
    assert len(found.faces) == len(whole.faces)
    assert hydrostatics_of(found).volume == pytest.approx(hydrostatics_of(whole).volume, rel=1e-7)
    assert made(tmp_path, "a.gdf", mesh_origin=[5.0, 0.0]).hydrostatics.volume > 50.0


@pytest.mark.parametrize("name", ["hull.gdf", "hull.obj", "four.msh"])
def test_a_mesh_in_mm_in_the_frame_of_its_body(name: str, tmp_path: Path) -> None:
    """`scale`, `frame: body` and `mesh_origin`, which is counted from the centre of gravity."""
    drawn = Panels(1000.0 * (hull().vertices - [5.0, 0.0, -0.5]), hull().faces)
    (tmp_path / name).write_text(mesh_writers.WRITERS[name](drawn))
    found = made(tmp_path, name, scale=0.001, frame="body").hydrostatics
    assert found.volume == pytest.approx(np.pi * 9.0 * 2.0, rel=1e-7)
    assert found.center_of_buoyancy == pytest.approx((5.0, 0.0, -1.0), abs=1e-7)
    moved = made(tmp_path, name, scale=0.001, frame="body", mesh_origin=[0.5, 0.25]).hydrostatics
    assert moved.volume == pytest.approx(np.pi * 9.0 * 1.75, rel=1e-7)
    assert moved.center_of_buoyancy == pytest.approx((5.5, 0.0, -0.875), abs=1e-7)


def test_a_mesh_in_feet_must_be_scaled(tmp_path: Path) -> None:
    drawn = Panels(hull().vertices / 0.3048, hull().faces)
    (tmp_path / "a.gdf").write_text(mesh_writers.gdf(drawn, gravity=32.174))
    with pytest.raises(InputError, match=r"line 2: a gravity of 32\.174 .*: add 'scale: 0\.3048'"):
        made(tmp_path, "a.gdf")
    volume = made(tmp_path, "a.gdf", scale=0.3048).hydrostatics.volume
    assert volume == pytest.approx(np.pi * 9.0 * 2.0, rel=1e-7)


def test_points_that_no_panel_uses_do_not_count(tmp_path: Path) -> None:
    text = mesh_writers.obj(hull()) + "v 0 0 500\n"
    (tmp_path / "a.obj").write_text(text)
    assert made(tmp_path, "a.obj").panels.size == pytest.approx(6.0, rel=0.1)


def test_a_mesh_of_nemoh_may_be_called_dat(tmp_path: Path) -> None:
    drawn = hull()
    rows = [f"{k} {x} {y} {z}" for k, (x, y, z) in enumerate(drawn.vertices.tolist(), start=1)]
    faces = [" ".join(str(c + 1) for c in face) for face in drawn.faces.tolist()]
    text = ["2 0", *rows, "0 0 0 0", *faces, "0 0 0 0", ""]
    (tmp_path / "a.dat").write_text("\n".join(text), "utf-8")
    volume = made(tmp_path, "a.dat").hydrostatics.volume
    assert volume == pytest.approx(np.pi * 9.0 * 2.0, rel=1e-7)


BROKEN = [
    ("a.dat", "nonsense", "no mesh of Nemoh: its first line is not '2 0' or '2 1'"),
    ("a.gdf", "t\n1 9.81\n0 0\n2\n" + "0 0 0\n" * 7, "24 coordinates, of which 21 are there"),
    ("a.gdf", "t\n1 9.81\n0 0\n1\n0 0 x\n", "line 5: 'x' is not a finite number"),
    ("a.gdf", "t\n1 9.81\n0 0\n", "line 4 does not begin with the number of panels"),
    ("a.gdf", "t\n1 9.81\n", "line 3 does not begin with symmetries ISX and ISY"),
    ("a.gdf", "t\n1\n", "line 2 does not begin with length and gravity"),
    ("a.gdf", "t\n1 9.81\n0 2\n0\n", "line 3: ISX and ISY are 0 2, known are 0 and 1"),
    ("a.gdf", "\n", "it is empty"),
    ("a.stl", "", "it is empty"),
    ("a.obj", "v 0 0 0\nf 1 2 9\n", "line 2 is neither a vertex nor a face: 'f 1 2 9'"),
    ("a.ply", "ply", "the format .ply is not known"),
    ("a", "v 0 0 0", "the format without a suffix is not known"),
    ("a.pnl", "nonsense", "it is damaged, or not of the format .pnl"),
    ("a.msh", "nonsense", "it has no section $MeshFormat"),
    ("a.msh", MANUAL.replace("4.1 0", "4.1 1"), "it is a binary file: save it as ASCII "
     "(Mesh.Binary = 0)"),
    ("a.msh", MANUAL.replace("4.1 0", "3 0"), "line 2: version 3 is none of 2 and 4.1 "
     "(Mesh.MshFileVersion)"),
    ("a.msh", MANUAL[: MANUAL.index("$EndElements")], "it ends within section $Elements"),
    ("a.msh", MANUAL.replace("2 2 5 6 3", "2 2 5 7 3"), "line 24: there is no node 7"),
    ("a.msh", MANUAL.replace("2 2 5 6 3\n", ""), "line 22: the block ends early"),
    ("a.msh", MANUAL.replace("1. 1. 0.", "1. 1."), "line 15: not 3 numbers"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content", "reason"), BROKEN)
def test_a_broken_file_is_told_in_words(
    name: str, content: str, reason: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError) as caught:
        made(tmp_path, name)
    (problem,) = caught.value.problems
    assert problem.message.startswith("body 'float': the mesh cannot be read: ")
    assert problem.message.endswith(reason)
    assert problem.remedy.startswith("formats: gdf (WAMIT)")
    assert problem.file == str(tmp_path / name)
