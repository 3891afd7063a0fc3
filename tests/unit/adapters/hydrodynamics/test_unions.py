"""Unions of shapes: volumes, even panels, symmetry, what is refused."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from support import mesh_writers

from m4e_adapters.hydrodynamics import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.build import check_config
from m4e_adapters.hydrodynamics.config import Body, Box, Water
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.checks import checked
from m4e_adapters.hydrodynamics.geometry.drawn_hulls import drawn_hulls
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hull
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels
from m4e_adapters.hydrodynamics.geometry.unions import remeshing
from m4e_adapters.hydrodynamics.geometry.unions.remeshing import thinness
from m4e_adapters.hydrodynamics.pressure.closed_hull import closed_hull
from m4e_adapters.hydrodynamics.pressure.config import HullBody
from m4e_adapters.hydrodynamics.stability_report import stability_of
from m4e_fmi.errors import InputError

SPAR = [
    {"cylinder": {"radius": 4, "draft": 15, "freeboard": 6}},
    {"cylinder": {"radius": 9, "draft": 18, "top_z": -15}},
]
STACKED = [
    {"cylinder": {"radius": 4, "draft": 3, "freeboard": 2}},
    {"cylinder": {"radius": 4, "draft": 8, "top_z": -3}},
]
PONTOONS = [
    *(
        {"box": {"length": 30, "width": 9, "draft": 14, "top_z": -10, "center_y": y}}
        for y in (-12, 12)
    ),
    {"box": {"length": 4, "width": 24, "draft": 13, "top_z": -11}},
]
COLUMNS = [
    {"cylinder": {"radius": 3, "draft": 11, "freeboard": 5, "center_x": x, "center_y": y}}
    for x in (-10, 10)
    for y in (-12, 12)
]
SEMI = [*PONTOONS, *COLUMNS]
VOLUMES = {
    "spar": (SPAR, math.pi * (16 * 15 + 81 * 3), 16 * math.pi),
    "stacked": (STACKED, 128 * math.pi, 16 * math.pi),
    "semi": (SEMI, 2 * 30 * 9 * 4 + 4 * 15 * 2 + 4 * math.pi * 9 * 10, 36 * math.pi),
    "columns": (COLUMNS, 4 * math.pi * 9 * 11, 36 * math.pi),
}
"""Parts, their volume [m3] below the water, and the waterplane [m2]."""


def made(parts: list[dict], panels: int, center: tuple[float, ...] = (0.0, -3.0)) -> Hull:
    body = {"shape": {"union": parts}, "center_of_gravity": center, "panels": panels}
    return make_hull("float", Body.model_validate(body), Path(), progress=lambda _: None)


@pytest.mark.parametrize("name", VOLUMES)
def test_volume_waterplane_and_panels(name: str) -> None:
    """Of the solid's facets to 1e-4; its triangles enclose exactly that, and are not thin."""
    parts, volume, waterplane = VOLUMES[name]
    hull = made(parts, 700)
    assert checked(hull.panels, "float") is hull.panels
    assert 600 < len(hull.panels.faces) < 1700
    assert hull.hydrostatics.volume == pytest.approx(volume, rel=2e-4)
    assert hull.hydrostatics.waterplane[0] == pytest.approx(waterplane, rel=2e-4)
    own = hydrostatics_of(hull.panels)
    assert own.volume == pytest.approx(hull.hydrostatics.volume, rel=1e-9)
    assert own.waterplane[0] == pytest.approx(waterplane, rel=5e-3)
    assert thinness(hull.panels.corners[:, :3]) < 40
    assert hull.lid is not None
    assert hydrostatics_of(hull.lid).waterplane[0] == pytest.approx(own.waterplane[0], rel=1e-9)
    for surface in (hull.panels, hull.lid):
        assert surface.half(0) is not None
        assert surface.half(1) is not None


def test_the_same_panels_each_time() -> None:
    first, second = (made(COLUMNS, 700).panels for _ in range(2))
    np.testing.assert_array_equal(first.corners, second.corners)


def test_a_union_of_bodies_of_revolution_turns_without_moving_the_water() -> None:
    assert made(STACKED, 400).axis == (0.0, 0.0)
    assert made(COLUMNS, 700).axis is None


@pytest.mark.verifies(
    "added mass, damping and force of a cylinder as a union of two, 400 triangles",
    independent="the cylinder itself, 900 panels",
    tolerance="5e-2",
)
def test_two_stacked_cylinders_are_one() -> None:
    """Surge and heave, over the largest value: within what so many panels resolve."""
    omega = np.array([0.6, 1.1])
    whole = {"shape": {"cylinder": {"radius": 4, "draft": 8}}, "center_of_gravity": [0, -3]}
    body = Body.model_validate({**whole, "panels": 900})
    hulls = (
        make_hull("float", body, Path(), progress=lambda _: None),
        made(STACKED, 400),
    )
    one, two = (
        solve_hulls([hull], water=Water(), omega=omega, progress=lambda _: None) for hull in hulls
    )
    np.testing.assert_allclose(two.hydrostatic_stiffness[1, 1], one.hydrostatic_stiffness[1, 1])
    for name in ("added_mass", "radiation_damping", "added_mass_inf"):
        found, right = (getattr(c, name)[..., [0, 1], [0, 1]] for c in (two, one))
        assert np.all(np.abs(found - right) < 0.05 * np.abs(right).max(axis=0))
    scale = np.abs(one.excitation[:, :2]).max(axis=0)
    assert np.all(np.abs(two.excitation - one.excitation)[:, :2] < 0.03 * scale)


def test_meshes_are_parts_too(tmp_path: Path) -> None:
    """A box in a file that is open at the waterline, and a keel."""
    (tmp_path / "a.gdf").write_text(
        mesh_writers.gdf(box_panels(Box(length=8, width=6, draft=3), 60))
    )
    keel = {"box": {"length": 4, "width": 1, "draft": 6, "top_z": -2}}
    body = {
        "shape": {"union": [{"mesh": "a.gdf"}, keel]},
        "center_of_gravity": [0, -1],
        "panels": 300,
    }
    hull = make_hull("float", Body.model_validate(body), tmp_path, progress=lambda _: None)
    assert hull.hydrostatics.volume == pytest.approx(8 * 6 * 3 + 4 * 3, rel=1e-9)
    assert hull.hydrostatics.waterplane[0] == pytest.approx(48, rel=1e-9)


def test_righting_arms_and_pressure_take_the_whole_union() -> None:
    config = {"shape": {"union": SEMI}, "center_of_gravity": [0, -8]}
    (found,) = stability_of(
        HydrodynamicsConfig.model_validate({"bodies": {"semi": {**config, "panels": 800}}}), Path()
    )
    assert found.rest == pytest.approx((0, 0, 0), abs=1e-4)
    heights = (
        found.hydrostatics.transverse_metacentric_height(found.center),
        found.hydrostatics.metacentric_height(found.center),
    )
    for curve, height in zip(found.curves.values(), heights, strict=True):
        assert curve.arms[1] == pytest.approx(height * math.sin(curve.angles[1]), rel=0.01)
    body = HullBody.model_validate({"shape": {"union": SPAR}, "center_of_gravity": [0, -8]})
    surface = closed_hull("spar", body, Path())
    volume = hydrostatics_of(surface).volume
    assert volume == pytest.approx(math.pi * (16 * 21 + 81 * 3), rel=2e-4)


def test_pictures_have_all_parts(tmp_path: Path) -> None:
    (tmp_path / "a.gdf").write_text(
        mesh_writers.gdf(box_panels(Box(length=2, width=2, draft=1, top_z=-0.5, center_x=50), 60))
    )
    shape = {"union": [*SPAR, {"mesh": "a.gdf"}]}
    body = Body.model_validate({"shape": shape, "center_of_gravity": [0, -8]})
    (hull,) = drawn_hulls({"spar": body}, tmp_path)
    low, high = hull.surface.vertices.min(axis=0), hull.surface.vertices.max(axis=0)
    np.testing.assert_allclose(low, [-9, -9, -18 + 8], atol=1e-9)
    np.testing.assert_allclose(high, [51, 9, 6 + 8], atol=1e-9)
    assert max(map(max, hull.surface.faces)) == len(hull.surface.vertices) - 1


def problems(shape: dict, folder: Path, **more: object) -> list[str]:
    body = {"shape": shape, "center_of_gravity": [0, -1], "panels": 300}
    config = HydrodynamicsConfig.model_validate({**more, "bodies": {"a": body}})
    with pytest.raises(InputError) as caught:
        check_config(config, folder=folder)
    return [f"{'.'.join(map(str, p.keys))}: {p.message}" for p in caught.value.problems]


REFUSED = {
    "inside": (
        [{"cylinder": {"radius": 4, "draft": 8}}, {"sphere": {"radius": 1, "center_z": -4}}],
        "bodies.a.shape.union.1.sphere: body 'a': part 2 of the union, a sphere, lies inside",
    ),
    "aside": (
        [COLUMNS[1], {"cylinder": {"radius": 3, "draft": 11, "center_x": -10, "center_y": -12}}],
        "bodies.a.shape.union: body 'a': the union is not its own mirror image in the X-Z plane",
    ),
    "narrow": (
        [
            {"cylinder": {"radius": 4, "draft": 8}},
            {"box": {"length": 9, "width": 9, "draft": 12, "top_z": -8.05}},
        ],
        "bodies.a.shape.union: the gap between parts of the union of body 'a' is about 0.05 m",
    ),
    "edge": (
        [
            {"box": {"length": 4, "width": 4, "draft": 2}},
            {"box": {"length": 4, "width": 4, "draft": 4, "top_z": -2, "center_x": 4}},
        ],
        "bodies.a.shape.union: body 'a': parts of the union touch along an edge only, near x = 2,",
    ),
    "twice": (
        [{"sphere": {"radius": 2}}, {"sphere": {"radius": 2}}],
        "bodies.a.shape.union.0.sphere: body 'a': part 1 of the union, a sphere, lies inside",
    ),
    "missing": (
        [{"mesh": "gone.stl"}, {"sphere": {"radius": 1}}, {"mesh": "open.gdf"}],
        "bodies.a.shape.union.0.mesh: body 'a': no such mesh file",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_wrong_parts(name: str, tmp_path: Path) -> None:
    box = box_panels(Box(length=8, width=6, draft=3), 60)
    lowest = int(np.argmin(box.centers[:, 2]))
    holed = box.kept(np.arange(len(box.faces)) != lowest)
    (tmp_path / "open.gdf").write_text(mesh_writers.gdf(holed))
    parts, message = REFUSED[name]
    found = problems({"union": parts}, tmp_path)
    assert found[0].startswith(message)
    if name == "missing":
        assert "bodies.a.shape.union.2.mesh: body 'a': the mesh is not watertight: 4" in found[1]
    assert len(found) == (2 if name == "missing" else 1)


def test_where_no_even_panels_are_found_the_body_and_its_panels_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remeshing, "TRIALS", 0)
    told = "body 'a': no even panels were found on the union of shapes with about 300 panels"
    assert problems({"union": SPAR}, tmp_path) == [f"bodies.a.shape.union: {told}"]
    body = HullBody.model_validate({"shape": {"union": SPAR}, "center_of_gravity": [0, -8]})
    with pytest.raises(InputError, match="body 'b': no even panels") as caught:
        closed_hull("b", body, tmp_path)
    assert caught.value.problems[0].keys == ("bodies", "b", "shape", "union")


@pytest.mark.parametrize("library", ["manifold3d", "mmgpy"])
def test_a_missing_library_is_named(
    library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    assert problems({"union": SPAR}, tmp_path) == [
        f"bodies.a.shape.union: a union of shapes needs the library {library}"
    ]


@pytest.mark.parametrize(
    ("union", "message"),
    [
        ([SPAR[0]], "the union has 1 of at least two parts"),
        ([{"union": SPAR}, SPAR[0]], "Extra inputs"),
        ([{}, SPAR[0]], "a part of a union has one shape, got none"),
    ],
)
def test_wrong_lists(union: list, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Body.model_validate({"shape": {"union": union}, "center_of_gravity": [0, -1]})


def test_a_dry_part_has_one_message() -> None:
    parts = [{"sphere": {"radius": 1, "center_z": 2}}, SPAR[0]]
    with pytest.raises(ValueError, match="does not touch the water") as caught:
        Body.model_validate({"shape": {"union": parts}, "center_of_gravity": [0, -1]})
    assert len(caught.value.errors()) == 1  # pyright: ignore[reportAttributeAccessIssue]


def test_pressure_needs_the_freeboard_of_each_part() -> None:
    parts = [{"cylinder": {"radius": 4, "draft": 15}}, SPAR[1]]
    with pytest.raises(ValueError, match="a cylinder needs a 'freeboard'"):
        HullBody.model_validate({"shape": {"union": parts}, "center_of_gravity": [0, -8]})
