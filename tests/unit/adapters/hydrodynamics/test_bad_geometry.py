"""Bad geometry: each mistake has one message, and all are told at once, with file and line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from support import mesh_writers

from m4e_adapters.hydrodynamics.build import check_config
from m4e_adapters.hydrodynamics.config import Box, HydrodynamicsConfig
from m4e_adapters.hydrodynamics.geometry import clearance
from m4e_adapters.hydrodynamics.geometry.panels import Panels, joined
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels, turned
from m4e_fmi.cosim import prepare
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document


def box() -> Panels:
    return box_panels(Box(length=6.0, width=4.0, draft=2.0), 100)


def bad_files() -> dict[str, tuple[bytes, str]]:
    """Content of mesh files, and what is told of them."""
    good = box()
    lowest = np.arange(len(good.faces)) == np.argmin(good.centers[:, 2])
    corners = good.vertices[good.faces[lowest][0]]
    middle = 0.5 * (corners[0] + corners[1])
    line = np.array([[len(good.vertices) + k for k in (0, 1, 2, 2)]])
    flat = Panels(
        np.concatenate([good.vertices, [corners[0], middle, corners[1]]]),
        np.concatenate([good.faces, line]),
    )

    turned = good.faces.copy()
    turned[5] = turned[5][::-1]
    deep = box_panels(Box(length=6, width=4, draft=60, top_z=-40), 100)

    def gdf(panels: Panels) -> bytes:
        return mesh_writers.gdf(panels).encode()

    return {
        "open.gdf": (gdf(good.kept(~lowest)), "the mesh is not watertight: 4 edges"),
        "inside.gdf": (gdf(good.reversed), "the mesh is inverted: the normals point out"),
        "above.gdf": (gdf(raised(good)), "above the water"),
        "mm.gdf": (gdf(Panels(1000 * good.vertices, good.faces)), "measures 6000 m, hulls have up"),
        "deep.gdf": (
            gdf(deep),
            "the sea bed is at z =",
        ),
        "flat.gdf": (gdf(flat), "1 panels have no area, the first near x = "),
        "empty.stl": (b"", "cannot be read: it is empty"),
        "short.gdf": (gdf(good)[:-40], "cannot be read: it ends early"),
        "half.stl": (b"solid".ljust(80) + (9).to_bytes(4, "little") + bytes(60), "whole binary"),
        "hull.ply": (b"ply", "cannot be read: the format .ply is not known"),
        "twice.gdf": (gdf(joined_twice(good)), "more than two panels meet in an edge"),
        "tank.gdf": (gdf(tank(good)), "a closed shell is inside the hull near x = "),
        "turned.gdf": (gdf(Panels(good.vertices, turned)), "panels face opposite ways near x = "),
        "level.gdf": (gdf(raised(good, 2.0)), "above the water (lowest point at z = 0 m)"),
        "none.obj": (b"v 0 0 0\n", "the mesh has no panels"),
    }


def raised(panels: Panels, height: float = 3.0) -> Panels:
    return Panels(panels.vertices + np.array([0, 0, height]), panels.faces)


def tank(panels: Panels) -> Panels:
    inner = box_panels(Box(length=2, width=2, draft=1.8, top_z=-0.8), 60).reversed
    return joined(panels, inner)


def joined_twice(panels: Panels) -> Panels:
    return Panels(panels.vertices, np.concatenate([panels.faces, panels.faces[:1]]))


BODIES = {
    "missing": ("{mesh: gone.stl}", "no such mesh file"),
    "ignored": ("{mesh: gone.stl}, panels: 99", "'panels' has no effect on a mesh file"),
    "left": ("{box: {length: 6, width: 4, draft: 2, center_x: 100}}", ""),
    "right": ("{box: {length: 6, width: 4, draft: 2, center_x: 106}}", "is about 0 m wide near x"),
    "within": (
        "{sphere: {radius: 1, center_x: 106, center_z: -1}}",
        "and 'within' overlap",
    ),
    "in_bed": ("{cylinder: {radius: 2, draft: 60, center_x: 200}}", "reaches down to z = -60 m"),
}


def system(folder: Path) -> tuple[Path, dict[int, str]]:
    """A system file with all of these bodies, and the message of each of its lines."""
    lines = ["name: bad", "components:", "  hydro:", "    kind: hydrodynamics"]
    lines += ["    water: {depth: 50}", "    bodies:"]
    messages: dict[int, str] = {}
    wanted = dict(BODIES)
    for name, (content, message) in bad_files().items():
        (folder / name).write_bytes(content)
        wanted[name.replace(".", "_")] = (f"{{mesh: {name}}}", message)
    for name, (shape, message) in wanted.items():
        shape, _, panels = shape.partition(", panels")
        x = {"left": 100, "right": 106, "within": 106, "in_bed": 200}.get(name, 0)
        lines += [f"      {name}:", f"        shape: {shape}"]
        if message and not panels:
            messages[len(lines)] = message
        if panels:
            messages[len(lines)] = "no such mesh file"
            lines.append(f"        panels{panels}")
            messages[len(lines)] = message
        lines.append(f"        center_of_gravity: [{x}, -1]")
    lines += ["connections: []", "simulation: {stop_time: 1, step_size: 0.1}"]
    (folder / "bad.system.yaml").write_text("\n".join(lines) + "\n")
    return folder / "bad.system.yaml", messages


def test_all_is_told_at_once_with_file_and_line(tmp_path: Path) -> None:
    """Whose mesh files are not hulls does not overlap with others."""
    path, messages = system(tmp_path)
    with pytest.raises(InputError) as caught:
        prepare(path, build_directory=tmp_path / "b", tell=lambda _: None)
    found = {problem.line: problem for problem in caught.value.problems}
    assert len(found) == len(caught.value.problems)  # one each
    assert found.keys() == messages.keys()
    for line, problem in found.items():
        assert messages[line] in problem.message, problem.message
        assert Path(problem.file).name == path.name
        assert problem.remedy
        assert problem.column


@pytest.mark.parametrize("name", [name for name in bad_files() if name != "hull.ply"])
def test_each_alone_has_one_message(name: str, tmp_path: Path) -> None:
    content, message = bad_files()[name]
    (tmp_path / name).write_bytes(content)
    body = {"shape": {"mesh": name}, "center_of_gravity": [0, -1]}
    problem = only({"water": {"depth": 50}, "bodies": {"float": body}}, tmp_path)
    assert message in problem.message
    assert problem.remedy


def only(config: dict, folder: Path) -> Problem:
    with pytest.raises(InputError) as caught:
        check_config(HydrodynamicsConfig.model_validate(config), folder=folder)
    (problem,) = caught.value.problems
    return problem


def test_the_remedy_of_a_mesh_in_mm_works(tmp_path: Path) -> None:
    content, _ = bad_files()["mm.gdf"]
    (tmp_path / "mm.gdf").write_bytes(content)
    body = {"shape": {"mesh": "mm.gdf"}, "center_of_gravity": [0, -1]}
    assert "'scale: 0.001'" in only({"bodies": {"float": body}}, tmp_path).remedy
    body = {"shape": {"mesh": "mm.gdf", "scale": 0.001}, "center_of_gravity": [0, -1]}
    check_config(HydrodynamicsConfig.model_validate({"bodies": {"a": body}}), folder=tmp_path)


FIXED = """\
water: {depth: 10}
bodies:
  float: {shape: {sphere: {radius: 1}}, center_of_gravity: [0, 0]}
  pile:
    shape: {mesh: gone.stl, frame: body}
    center_of_gravity: [9, 0]
    drag: {surge: 1}
    fixed: true
"""


def test_keys_that_a_fixed_body_does_not_have(tmp_path: Path) -> None:
    """Beside the missing file, which they do not hide."""
    config = Document.parse(FIXED).validate(HydrodynamicsConfig)
    with pytest.raises(InputError) as caught:
        check_config(config, folder=tmp_path)
    found = {problem.keys[2:]: problem.message for problem in caught.value.problems}
    assert found.keys() == {
        ("shape", "mesh"),
        ("shape", "frame"),
        ("center_of_gravity",),
        ("drag",),
    }
    assert found["drag",] == "'drag' has no effect on a fixed body"
    assert "no such mesh file" in found["shape", "mesh"]


@pytest.mark.parametrize(
    ("shape", "sizes"),
    [
        ("cylinder", {"radius": 1e-300, "draft": 3}),
        ("cylinder", {"radius": 3, "draft": 1e-50}),
        ("sphere", {"radius": 1e-300}),
        ("torus", {"radius": 3, "tube_radius": 1e-300}),
        ("box", {"length": 1e-50, "width": 3, "draft": 1}),
        ("box", {"length": 3, "width": 1e-50, "draft": 1}),
        ("horizontal_cylinder", {"radius": 3, "length": 1e-110, "axis": "y"}),
    ],
)
def test_lengths_that_have_no_panels(shape: str, sizes: dict[str, Any]) -> None:
    body = {"shape": {shape: sizes}, "center_of_gravity": [0, -1]}
    content = {"bodies": {"float": body}, "waves": {"spectrum": "still"}}
    with pytest.raises(ValidationError, match=r"greater than or equal to 0\.0001"):
        HydrodynamicsConfig.model_validate(content)


def test_a_profile_without_a_volume() -> None:
    line = np.array([0.0, 1e-300, 0.0])
    with pytest.raises(InputError, match="a volume of 0 m3 is too small to compute with"):
        turned(line, np.array([-2.0, -1.0, 0.0]), 12, 0.0, pivot=0.0)


def test_bodies_that_are_one_in_another_are_found_by_few_points(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried, seen = 0, clearance._seen

    def counted(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        nonlocal tried
        tried += len(points)
        return seen(points, triangles)

    monkeypatch.setattr(clearance, "_seen", counted)
    hull = box()
    assert len(hull.faces) > 2 * clearance.FEW
    assert clearance.overlap(hull, hull) is not None
    assert tried == clearance.FEW
