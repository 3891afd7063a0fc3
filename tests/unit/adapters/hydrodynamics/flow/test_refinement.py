"""Convergence studies: the families of meshes, the limit, and the statement of errors."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import mesh_writers
from support.hulls import configured, hull, silent
from support.refined_cases import stored

from m4e_adapters.hydrodynamics.config import Box
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels
from m4e_adapters.hydrodynamics.refinement import similar_hulls, study

BOX = {"box": {"length": 8.0, "width": 6.0, "draft": 3.0}}


def counts(shape: dict, folder: Path, **body: object) -> list[int]:
    given = {"shape": shape, "center_of_gravity": [0, -1], **body}
    config = configured({"bodies": {"float": given}})
    meshes = similar_hulls(config, folder, progress=silent)
    return [len(made.panels.faces) for (made,) in meshes]


SHAPES = [
    BOX,
    {"cylinder": {"radius": 4, "draft": 3}},
    {"cylinder": {"radius": 4, "draft": 9, "top_z": -2}},
    {"sphere": {"radius": 4, "center_z": -1}},
    {"horizontal_cylinder": {"radius": 2, "length": 10, "center_z": -1}},
    {"revolved": {"profile": [[2, -4], [4, -1], [4, 0]]}},
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: next(iter(shape)))
def test_finer_meshes_of_a_shape_are_similar(shape: dict) -> None:
    """Four and nine times the panels, of the same volume."""
    hulls = [hull(shape, panels=50, finer=finer) for finer in (1, 2, 3)]
    counts = [len(each.panels.faces) for each in hulls]
    assert [counts[0] * k for k in (1, 4, 9)] == pytest.approx(counts, rel=0.02)
    for each in hulls[1:]:
        volume, first = each.hydrostatics.volume, hulls[0].hydrostatics.volume
        assert volume == pytest.approx(first, rel=1e-9)


@pytest.mark.parametrize(("panels", "parts"), [(432, (1, 2, 3)), (768, (2, 3, 4))])
def test_meshes_of_a_shape(panels: int, parts: tuple[int, ...]) -> None:
    found = counts(BOX, Path(), panels=panels)
    assert found == [panels // parts[-1] ** 2 * k**2 for k in parts]


def test_meshes_of_a_file_and_of_a_union(tmp_path: Path) -> None:
    """The coarsest mesh is that of a build."""
    panels = box_panels(Box(length=8, width=6, draft=3), 60)
    for drawn in (panels, panels.divided(3)):
        (tmp_path / "a.gdf").write_text(mesh_writers.gdf(drawn))
        count = len(drawn.faces)
        assert counts({"mesh": "a.gdf"}, tmp_path)[:2] == [count, 4 * count]
    keel = {"box": {"length": 9, "width": 9, "draft": 5, "top_z": -3}}
    parts = [{"cylinder": {"radius": 4, "draft": 3}}, keel]
    first, second, *_ = counts({"union": parts}, Path(), panels=100)
    assert 60 < first < 400
    assert second == 4 * first


def test_a_power_law_is_found() -> None:
    """Of tables that are x₀ + c h^p: order, limit, and the error of the finest mesh."""
    base = stored("pile")
    counts, power = (100, 225, 400), 2.0
    tables = [
        replace(c, added_mass=c.added_mass * 0 + 7.0 + 3.0 * np.eye(3) * n ** (-power / 2))
        for n, c in zip(counts, base.meshes, strict=True)
    ]
    found = study(counts, tables)
    np.testing.assert_allclose(found.limit.added_mass, 7.0, rtol=1e-12)
    assert found.added_mass.order[0, 0] == pytest.approx(power, abs=0.03)
    assert math.isnan(found.added_mass.order[0, 1])  # no mesh differs
    true = 3.0 / counts[-1]
    assert true < found.added_mass.error[1, 1] < 3 * true
    assert found.added_mass.remaining[0, 1] < 1e-12
    two = study(counts[1:], tables[1:])
    assert np.all(np.isnan(two.added_mass.order))
    gap = abs(two.limit.added_mass[0, 0, 0] - 7.0)
    assert gap < two.added_mass.remaining[0, 0] < 5 * gap
