"""Shapes of bodies in space: from files and Python, mesh files; mistakes are in tests/corpus."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.model import Box, Cylinder, Mesh, Sphere, load_model
from m4e_fmi.model.shapes.mesh_files import MeshFileError, obj_triangles, read_triangles, reduced

TETRAHEDRON = """\
# four corners
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1/1 2/2 4/3
f -3 -2 -1
f 1//1 4//2 3//3
"""
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"


def model(folder: Path, shape: str, *, dimensions: int = 3) -> Path:
    inertia = "[1, 1, 1]" if dimensions == 3 else "1"
    path = folder / "m.model.yaml"
    path.write_text(
        f"name: m\ndimensions: {dimensions}\n"
        "parameters: {r: {value: 20, unit: cm}, m: {value: 2, unit: kg}}\n"
        "bodies:\n"
        f"  b: {{mass: m, inertia: {inertia}, shape: {shape}}}\n"
        "joints: {j: {type: floating, child: b}}\n",
        encoding="utf-8",
    )
    return path


def binary_stl(triangles: np.ndarray) -> bytes:
    rows = (struct.pack("<12fH", 0, 0, 0, *t.reshape(-1), 0) for t in triangles)
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + b"".join(rows)


def ball(rows: int) -> np.ndarray:
    """A sphere of radius 1 m by 2·rows² triangles or so."""
    down, around = np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, 2 * rows + 1)
    at = np.stack(
        [
            np.outer(np.sin(down), np.cos(around)),
            np.outer(np.sin(down), np.sin(around)),
            np.outer(np.cos(down), np.ones_like(around)),
        ],
        axis=-1,
    )
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    halves = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)])
    return halves.reshape(-1, 3, 3)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{box: {length: 2, width: r, height: 1}}", Box(2, "r", 1)),
        ("{sphere: {radius: r/2, center: [r, 0, 1]}}", Sphere("r/2", ("r", 0, 1))),
        ("{cylinder: {radius: r, height: 3, axis: [1, 0, 0]}}", Cylinder("r", 3, (1, 0, 0))),
    ],
)
def test_from_a_file(tmp_path: Path, text: str, expected: object) -> None:
    assert load_model(model(tmp_path, text)).bodies["b"].shape == expected


def test_a_mesh_is_next_to_its_model(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text(TETRAHEDRON, encoding="utf-8")
    shape = load_model(model(tmp_path, "{mesh: t.obj, mesh_origin: [0, r, 1]}")).bodies["b"].shape
    assert isinstance(shape, Mesh)
    assert shape.mesh_origin == (0, "r", 1)
    assert shape.triangles.shape == (4, 3, 3)


class TestMeshFiles:
    def test_stl_in_both_forms(self, tmp_path: Path) -> None:
        triangles = obj_triangles(TETRAHEDRON.encode())
        facets = "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x:g} {y:g} {z:g}\n" for x, y, z in t)
            + "endloop\nendfacet\n"
            for t in triangles
        )
        (tmp_path / "text.STL").write_text(f"solid t\n{facets}endsolid t\n", encoding="ascii")
        (tmp_path / "bytes.stl").write_bytes(binary_stl(triangles))
        for name in ("text.STL", "bytes.stl"):
            np.testing.assert_array_equal(read_triangles(tmp_path / name), triangles)

    def test_faces_of_four_corners(self) -> None:
        two = obj_triangles(SQUARE.encode())
        normals = np.cross(two[:, 1] - two[:, 0], two[:, 2] - two[:, 0])
        np.testing.assert_array_equal(normals, [[0, 0, 1], [0, 0, 1]])

    @pytest.mark.parametrize("content", [b"", b"solid\nvertex 1 2", b"nonsense", b"\0" * 90])
    def test_what_is_no_stl(self, tmp_path: Path, content: bytes) -> None:
        (tmp_path / "a.stl").write_bytes(content)
        with pytest.raises(MeshFileError):
            read_triangles(tmp_path / "a.stl")

    def test_a_fine_mesh_is_made_coarser(self) -> None:
        """Within a cell of the grid: for 1,000 triangles at most a fifteenth of the diameter."""
        fine = ball(60)
        coarse = reduced(fine, 1000)
        assert 200 < len(coarse) <= 1000
        distances = np.linalg.norm(coarse.reshape(-1, 3), axis=1)
        assert distances.min() > 1 - 2 / 15
        assert distances.max() <= 1 + 1e-12
        np.testing.assert_array_equal(reduced(fine, len(fine)), fine)
