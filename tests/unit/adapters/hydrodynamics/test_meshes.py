"""Meshes from files and of the built-in shapes: what passes, what is refused, symmetry, lids."""

import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.build import check_config, frequency_table
from m4e_adapters.hydrodynamics.config import Body, Box, Cylinder, HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.flow.bem import resolved_frequency, warn_of_coarse_panels
from m4e_adapters.hydrodynamics.geometry.checks import checked
from m4e_adapters.hydrodynamics.geometry.clearance import narrowest_gap, overlap
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.lid import make_lid, waterline
from m4e_adapters.hydrodynamics.geometry.mesh import (
    Hull,
    hulls_and_problems,
    make_hull,
    make_hulls,
)
from m4e_adapters.hydrodynamics.geometry.panels import Panels, grid, joined
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels, cylinder_panels
from m4e_fmi.cosim import prepare
from m4e_fmi.errors import InputError, Problem

SHAPES = [
    {"cylinder": {"radius": 4.0, "draft": 3.0}},
    {"sphere": {"radius": 5.0}},
    {"sphere": {"radius": 5.0, "center_z": -2.0}},
    {"sphere": {"radius": 5.0, "center_z": -8.0}},
    {"box": {"length": 20.0, "width": 10.0, "draft": 4.0}},
    {"revolved": {"profile": [[4.0, -3.0], [4.0, -2.0], [2.0, 2.0], [0.0, 2.0]]}},
    {"revolved": {"profile": [[0.0, -3.0], [4.0, 0.0]]}},
    {"revolved": {"profile": [[4.0, -6.0], [4.0, -5.0], [2.0, -5.0], [2.0, -3.0]]}},
]
SUBMERGED = (SHAPES[3], SHAPES[7])


def box() -> Panels:
    return box_panels(Box(length=6.0, width=4.0, draft=2.0), 100)


def written(panels: Panels, path: Path) -> Path:
    """`panels` as a WAMIT .gdf file."""
    lines = ["test", "1.0 9.81", "0 0", str(len(panels.faces))]
    lines += [" ".join(f"{x:.9g}" for x in corner) for face in panels.corners for corner in face]
    path.write_text("\n".join(lines) + "\n")
    return path


def hull(panels: Panels, folder: Path):
    written(panels, folder / "hull.gdf")
    body = Body.model_validate({"shape": {"mesh": "hull.gdf"}, "center_of_gravity": [0, -1]})
    return make_hull("float", body, folder, progress=lambda _: None)


@pytest.mark.parametrize("shape", SHAPES)
def test_built_in_shapes_are_closed_and_symmetric(shape: dict) -> None:
    body = Body.model_validate({"shape": shape, "center_of_gravity": [0, -1], "panels": 200})
    made = make_hull("float", body, Path(), progress=lambda _: None)
    assert checked(made.panels, "float") is made.panels
    for surface in (made.panels, made.lid):
        if surface is None:
            assert shape in SUBMERGED  # they need no lid
            continue
        for axis in (0, 1):
            half = surface.half(axis)
            assert half is not None
            assert 2 * len(half.faces) == len(surface.faces)


@pytest.mark.parametrize("shape", [SHAPES[0], SHAPES[1], SHAPES[4], SHAPES[5], SHAPES[6]])
def test_a_lid_covers_the_waterplane_facing_down(shape: dict) -> None:
    body = Body.model_validate({"shape": shape, "center_of_gravity": [0, -1], "panels": 200})
    made = make_hull("float", body, Path(), progress=lambda _: None)
    assert made.lid is not None
    covered = hydrostatics_of(made.lid).waterplane[0]
    assert covered == pytest.approx(made.hydrostatics.waterplane[0], rel=1e-12)
    assert np.all(made.lid.vertices[:, 2] == 0.0)


@pytest.mark.parametrize(
    ("shape", "volume", "middle", "radius"),
    [
        # a cylinder below a frustum, that the water cuts at its radius of 3 m
        (SHAPES[5], math.pi * (16 + 2 / 3 * (16 + 12 + 9)), None, 3.0),
        (SHAPES[6], math.pi * 16, -0.75, 4.0),  # a cone: a quarter of its height below its base
        (SHAPES[7], math.pi * (16 + 4 * 2), (16 * -5.5 + 8 * -4.0) / 24, 0.0),
    ],
)
@pytest.mark.parametrize("panels", [48, 600])
def test_a_body_of_revolution_has_its_exact_volume(
    shape: dict, volume: float, middle: float | None, radius: float, panels: int
) -> None:
    shape = {"revolved": {**shape["revolved"], "center_x": 7.0}}
    body = Body.model_validate({"shape": shape, "center_of_gravity": [7, 0, -1], "panels": panels})
    made = make_hull("float", body, Path(), progress=lambda _: None)
    assert made.axis == (7.0, 0.0)
    assert panels <= len(made.panels.faces) < 2.2 * panels
    found = made.hydrostatics
    assert found.volume == pytest.approx(volume, rel=1e-12)
    assert found.waterplane[0] == pytest.approx(math.pi * radius**2, rel=1e-12, abs=1e-9)
    assert found.center_of_buoyancy[:2] == pytest.approx((7.0, 0.0))
    if middle is not None:
        assert found.center_of_buoyancy[2] == pytest.approx(middle, rel=1e-9)


def test_a_waterline_not_visible_from_its_centre_gets_capytaines_lid() -> None:
    x, z = np.linspace(0, 1, 5), np.linspace(-2, 0, 3)
    corners = np.array([[0, 0], [8, 0], [8, 8], [7, 8], [7, 1], [0, 1], [0, 0]], dtype=float)
    walls = []
    for start, end in pairwise(corners):
        along = start + x[:, None] * (end - start)
        walls.append(grid(np.array([[[*point, height] for height in z] for point in along])))
    for xs, ys in (((0, 8), (0, 1)), ((7, 8), (1, 8))):
        us, vs = (
            np.linspace(*ys, 2 * (ys[1] - ys[0]) + 1),
            np.linspace(*xs, 2 * (xs[1] - xs[0]) + 1),
        )
        walls.append(grid(np.array([[[v, u, -2.0] for v in vs] for u in us])))
    lid = make_lid(joined(*walls))
    assert lid is not None
    area = hydrostatics_of(lid).waterplane[0]
    # whole panels of about half a metre on an L of 8 + 7 m2, its edge 32 m long
    assert 15.0 - 0.5 * 32 / 2 < area < 15.0 + 0.5 * 32 / 2


def test_a_file_is_read_cut_at_the_water_and_measured(tmp_path: Path) -> None:
    lower = box()
    raised = Panels(lower.vertices + np.array([0, 0, 0.5]), lower.faces)
    made = hull(raised, tmp_path)
    assert made.hydrostatics.volume == pytest.approx(6 * 4 * 1.5, rel=1e-6)
    assert made.hydrostatics.waterplane[0] == pytest.approx(24.0, rel=1e-6)
    assert made.lid is not None


def test_a_deck_in_the_water_level_is_left_out(tmp_path: Path) -> None:
    x, y = np.linspace(-3, 3, 4), np.linspace(-2, 2, 3)
    deck = grid(np.array([[[u, v, 0.0] for v in y] for u in x]))
    assert hull(joined(box(), deck), tmp_path).hydrostatics.volume == pytest.approx(48, rel=1e-6)


def flipped(panels: Panels, which: np.ndarray) -> Panels:
    faces = panels.faces.copy()
    faces[which] = faces[which][:, ::-1]
    return Panels(panels.vertices, faces)


def test_bad_meshes_are_refused_with_a_remedy(tmp_path: Path) -> None:
    good = box()
    everything = np.ones(len(good.faces), dtype=bool)
    lowest = np.argmin(good.centers[:, 2])
    one = np.arange(len(good.faces)) == lowest
    cases = [
        (good.kept(~one), "not watertight"),
        (flipped(good, everything), "inverted"),
        (flipped(good, one), "face opposite ways"),
        (Panels(good.vertices + np.array([0, 0, 3.0]), good.faces), "above the water"),
    ]
    for panels, message in cases:
        with pytest.raises(InputError, match=message) as caught:
            hull(panels, tmp_path)
        assert caught.value.problems[0].remedy


def test_doubled_panels_are_refused() -> None:
    good = box()
    wall = good.faces[np.argmin(good.centers[:, 2])][None, :]
    with pytest.raises(InputError, match="more than two panels"):
        checked(Panels(good.vertices, np.concatenate([good.faces, wall])), "float")


def smaller(*, draft: float = 1.0, z: float = 0.0, closed: bool = True) -> Panels:
    """A box of 3 by 2 m whose top, a lid if `closed`, is at `z`."""
    lower = box_panels(Box(length=3.0, width=2.0, draft=draft), 60)
    lid = make_lid(lower)
    assert lid is not None
    whole = joined(lower, lid.reversed) if closed else lower
    return Panels(whole.vertices + np.array([0, 0, z]), whole.faces)


@pytest.mark.parametrize(
    "inner",
    [
        smaller(z=-0.5),
        smaller(z=-0.5).reversed,
        smaller(closed=False),
        smaller(closed=False).reversed,
        smaller(z=-0.5, draft=4.0),
    ],
    ids=["a box", "a tank", "a box through the waterline", "a double skin", "partly inside"],
)
def test_closed_shells_inside_the_hull_are_refused(inner: Panels, tmp_path: Path) -> None:
    """They made the displaced volume larger or smaller by their own."""
    with pytest.raises(InputError, match="a closed shell is inside the hull near x = ") as caught:
        hull(joined(box(), inner), tmp_path)
    (problem,) = caught.value.problems
    assert problem.remedy.startswith("remove it")
    assert problem.file == str(tmp_path / "hull.gdf")


def test_hulls_of_one_body_side_by_side_and_moonpools_are_meshes(tmp_path: Path) -> None:
    """One of the hulls with its normals turned round is not, small as it may be."""
    aside = Panels(smaller().vertices + np.array([0, 5.0, 0]), smaller().faces)
    made = hull(joined(box(), aside), tmp_path)
    assert made.hydrostatics.volume == pytest.approx(48 + 6, rel=1e-6)
    with pytest.raises(InputError, match=r"normals point out of the water near x = .*, y = [456]"):
        hull(joined(box(), aside.reversed), tmp_path)
    assert hull(ring_of_panels(), tmp_path).hydrostatics.volume > 0


def test_a_missing_or_unreadable_file(tmp_path: Path) -> None:
    body = Body.model_validate({"shape": {"mesh": "none.gdf"}, "center_of_gravity": [0, 0]})
    with pytest.raises(InputError, match="no such mesh file"):
        make_hull("float", body, tmp_path)
    (tmp_path / "none.gdf").write_text("nonsense")
    with pytest.raises(InputError, match="cannot be read"):
        make_hull("float", body, tmp_path)


def two_hulls(second: dict) -> int:
    """Number of hulls of a box of 6 by 4 by 2 m at x = 0 and another body."""
    first = {"box": {"length": 6.0, "width": 4.0, "draft": 2.0}}
    bodies = {
        name: {"shape": shape, "center_of_gravity": [0, -1], "panels": 150}
        for name, shape in (("first", first), ("second", second))
    }
    config = HydrodynamicsConfig.model_validate({"bodies": bodies})
    return len(make_hulls(config, Path(), progress=lambda _: None))


@pytest.mark.parametrize(
    "second",
    [
        {"box": {"length": 6.0, "width": 4.0, "draft": 2.0}},
        {"box": {"length": 6.0, "width": 4.0, "draft": 2.0, "center_x": 5.0}},
        {"sphere": {"radius": 0.5, "center_z": -1.0}},
        {"cylinder": {"radius": 20.0, "draft": 5.0}},
    ],
    ids=["the same place", "side by side", "one within the other", "the other way round"],
)
def test_bodies_that_overlap_are_refused(second: dict) -> None:
    with pytest.raises(InputError, match="bodies 'first' and 'second' overlap") as caught:
        two_hulls(second)
    assert "center_x" in caught.value.problems[0].remedy


def test_each_of_many_bodies_at_one_place_is_told_once() -> None:
    """Not each pair of them, which takes time as the square of their number."""
    body = {"shape": {"sphere": {"radius": 2}}, "center_of_gravity": [0, 0], "panels": 48}
    config = HydrodynamicsConfig.model_validate({"bodies": dict.fromkeys("abcde", body)})
    _, problems = hulls_and_problems(config, Path(), progress=lambda _: None)
    assert [problem.keys[1] for problem in problems] == list("bcde")


def stl(panels: Panels, *, binary: bool) -> bytes:
    """`panels` as an STL file; the binary one begins with "solid", as those of some tools do."""
    triangles = panels.triangles
    distinct = [len({tuple(p) for p in t.tolist()}) == 3 for t in triangles]
    triangles = triangles[distinct].astype("<f4")
    if not binary:
        corners = "\n".join(
            "facet normal 0 0 0 outer loop "
            + " ".join("vertex " + " ".join(f"{x:.9g}" for x in p) for p in t.tolist())
            + " endloop endfacet"
            for t in triangles
        )
        return f"solid hull\n{corners}\nendsolid hull\n".encode()
    facets = np.zeros((len(triangles), 50), dtype=np.uint8)
    facets[:, 12:48] = np.ascontiguousarray(triangles.reshape(-1, 9)).view(np.uint8)
    return b"solid hull".ljust(80) + len(triangles).to_bytes(4, "little") + facets.tobytes()


@pytest.mark.parametrize("binary", [True, False])
def test_stl_files_are_read(tmp_path: Path, binary: bool) -> None:
    (tmp_path / "hull.STL").write_bytes(stl(box(), binary=binary))
    body = Body.model_validate({"shape": {"mesh": "hull.STL"}, "center_of_gravity": [0, -1]})
    made = make_hull("float", body, tmp_path, progress=lambda _: None)
    assert made.hydrostatics.volume == pytest.approx(48.0, rel=1e-6)
    content = (tmp_path / "hull.STL").read_bytes()
    (tmp_path / "hull.STL").write_bytes(content[:-20].replace(b"solid", b"dilos"))
    with pytest.raises(InputError, match="cannot be read"):
        make_hull("float", body, tmp_path)


def test_a_mesh_in_the_frame_of_its_body_is_moved_to_its_place(tmp_path: Path) -> None:
    """Drawn about the centre of gravity; without `mesh_origin` it floats higher, at x = 0, and
    that the centre of gravity is not above it is told."""
    place, told = np.array([20.0, 0.0, -0.5]), []
    written(Panels(box().vertices - [0, 0, -0.5], box().faces), tmp_path / "hull.gdf")
    shape = {"mesh": "hull.gdf"}
    given = {"shape": shape, "center_of_gravity": [place[0], place[2]]}
    made = make_hull("float", Body.model_validate(given), tmp_path, progress=told.append)
    assert made.hydrostatics.volume == pytest.approx(6 * 4 * 1.5, rel=1e-6)
    assert "(x = 20 m) is not above or below its hull (x = -3 to 3 m)" in told[-1]
    assert "mesh_origin" in told[-1]
    told.clear()
    given["shape"] = {**shape, "mesh_origin": [20.0, -0.5]}
    made = make_hull("float", Body.model_validate(given), tmp_path, progress=told.append)
    assert not told
    assert made.hydrostatics.volume == pytest.approx(48.0, rel=1e-6)
    assert made.hydrostatics.center_of_buoyancy == pytest.approx((20.0, 0.0, -1.0), abs=1e-5)


def test_the_waterplane_of_a_closed_mesh_below_the_water_is_rounding(tmp_path: Path) -> None:
    """Not a size: frequencies end where k (a + d) = 4.5, and not at 10,000 rad/s. Turned, so that
    the sum of its panels' areas is not exactly 0."""
    lower = box()
    lid = make_lid(lower)
    assert lid is not None
    closed = joined(lower, Panels(lid.vertices, lid.faces[:, ::-1]))
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]) / 3.0
    written(Panels(closed.vertices @ turn.T - [0, 0, 4.0], closed.faces), tmp_path / "hull.gdf")
    body = {"shape": {"mesh": "hull.gdf"}, "center_of_gravity": [0, -4.3]}
    config = HydrodynamicsConfig.model_validate({"bodies": {"deep": body}})
    hulls = make_hulls(config, tmp_path, progress=lambda _: None)
    size = (1.5 * 48 / 27 / np.pi) ** (1 / 3) + 4.0
    highest = frequency_table(config, hulls)[-1]
    assert highest == pytest.approx(np.sqrt(4.5 * 9.81 / size), rel=1e-6)


def test_all_that_is_wrong_is_told_at_once_before_anything_is_built(tmp_path: Path) -> None:
    """With line and column; the model of the first component is not built either."""
    (tmp_path / "hull.gdf").write_text("nonsense")
    (tmp_path / "s.system.yaml").write_text(SYSTEM)
    (tmp_path / "mass.model.yaml").write_text(MODEL)
    built: list[str] = []
    with pytest.raises(InputError) as caught:
        prepare(tmp_path / "s.system.yaml", build_directory=tmp_path / "b", tell=built.append)
    found = {p.line: p for p in caught.value.problems}
    assert "the sea bed is at z = -20 m" in found[9].message
    assert "no such mesh file" in found[12].message
    assert "cannot be read" in found[15].message
    assert "frequencies.minimum 0.1 rad/s is too low" in found[17].message
    assert "(2.5 peak frequencies)" in found[18].message
    assert len(found) == 5
    assert all(p.column and p.remedy for p in found.values())
    assert not any("building" in line for line in built)


MODEL = """\
name: mass
bodies: {m: {mass: 1.0, inertia: 1.0}}
joints: {j: {type: floating, child: m}}
"""
SYSTEM = """\
name: wrong
components:
  mass: {model: mass.model.yaml}
  hydro:
    kind: hydrodynamics
    water: {depth: 20}
    bodies:
      deep:
        shape: {cylinder: {radius: 4, draft: 30}}
        center_of_gravity: [0, -1]
      missing:
        shape: {mesh: missing.stl}
        center_of_gravity: [0, -1]
      nonsense:
        shape: {mesh: hull.gdf}
        center_of_gravity: [0, -1]
    frequencies: {minimum: 0.1,
      maximum: 1.0}
    waves: {spectrum: jonswap, significant_height: 1, peak_period: 5}
connections: []
simulation: {stop_time: 1, step_size: 0.1}
"""


def counted(count: int, **more: float) -> Problem | None:
    """The problem of a cylinder of 60 panels, coarse above 2.03 rad/s, with so many frequencies."""
    shape = {"cylinder": {"radius": 4, "draft": 4}}
    body = {"shape": shape, "center_of_gravity": [0, -0.1], "panels": 60}
    frequencies = {"count": count, **more}
    given = {"bodies": {"a": body}, "frequencies": frequencies}
    try:
        check_config(HydrodynamicsConfig.model_validate(given), folder=Path())
    except InputError as error:
        (problem,) = error.problems
        return problem
    return None


@pytest.mark.parametrize("more", [{}, {"maximum": 8.0}, {"minimum": 0.3}])
def test_too_few_frequencies_are_told_with_a_number_that_works(more: dict) -> None:
    problem = counted(12, **more)
    assert problem is not None
    assert problem.keys == ("frequencies", "count")
    assert ("where the panels resolve the waves" in problem.message) == ("maximum" not in more)
    assert ("use more panels" in problem.remedy) == ("maximum" not in more)
    enough = int(re.findall(r"frequencies.count of (\d+)", problem.remedy)[0])
    assert counted(enough, **more) is None
    assert counted(enough - 1, **more) is not None


def test_frequencies_that_begin_too_high_are_told() -> None:
    problem = counted(12, minimum=3.5, maximum=8.0)
    assert problem is not None
    assert problem.keys == ("frequencies", "minimum")
    assert "leave out frequencies.minimum" in problem.remedy
    assert "0 of the 12 frequencies" in problem.message


def coarse(depth: float, needed: float) -> list[str]:
    """Warnings of a barge of 100 m beside a buoy of 1 m, with waves up to `needed` [rad/s]."""
    shapes = {
        "barge": {"box": {"length": 100.0, "width": 60.0, "draft": 20.0}},
        "buoy": {"sphere": {"radius": 1.0, "center_x": 60.0}},
    }
    bodies = {
        name: {"shape": shape, "center_of_gravity": [60.0 * (name == "buoy"), -0.3], "panels": 400}
        for name, shape in shapes.items()
    }
    config = HydrodynamicsConfig.model_validate({"bodies": bodies, "water": {"depth": depth}})
    told: list[str] = []
    warn_of_coarse_panels(
        make_hulls(config, Path(), progress=lambda _: None),
        water=config.water,
        highest=6.6,
        needed=needed,
        progress=told.append,
    )
    return [text for text in told if "barge" in text]


def test_panels_are_compared_with_the_waves_that_matter_to_their_body() -> None:
    """The barge radiates up to 1.07 rad/s, the buoy to 6.6: that asked for 510,000 panels."""
    assert coarse(300.0, needed=0.0) == []
    (text,) = coarse(300.0, needed=1.4)
    assert "that matter to it are of 1.4:" in text
    panels = int(re.findall(r"about (\d+)", text)[0])
    assert 300 < panels < 2000
    # of the panels at the limit, w² = g k and 8 radii in a wave: a barge's are alike
    radius, limit = (float(re.findall(rf"{word} ([\d.]+)", text)[0]) for word in ("to", "above"))
    assert radius == pytest.approx(2 * np.pi / 8 * 9.80665 / limit**2, rel=0.01)
    (text,) = coarse(300.0, needed=6.6)
    assert "use more panels or a lower frequencies.maximum" in text


def test_the_waterline_is_one_loop_around_the_hull() -> None:
    panels = box()
    edges = waterline(panels)
    assert sorted(a for a, _ in edges) == sorted(b for _, b in edges)
    length = sum(np.linalg.norm(panels.vertices[b] - panels.vertices[a]) for a, b in edges)
    assert length == pytest.approx(20.0, rel=1e-12)


def test_a_centre_of_gravity_below_the_hull_is_told(tmp_path: Path) -> None:
    """A mesh in the frame of its body, read as one in world coordinates, may be far too high."""
    told: list[str] = []
    written(box(), tmp_path / "hull.gdf")
    given = {"shape": {"mesh": "hull.gdf"}, "center_of_gravity": [0, -5]}
    make_hull("float", Body.model_validate(given), tmp_path, progress=told.append)
    assert "(z = -5 m) is below its hull (lowest point at z = -2 m)" in told[-1]
    assert "mesh_origin" in told[-1]


def boxes(apart: float, folder: Path = Path(), **more: object) -> list[str]:
    """Problems and warnings of two boxes, 6 m long, whose middles are so far [m] apart."""
    size = {"length": 6.0, "width": 4.0, "draft": 2.0}
    bodies = {
        name: {"shape": {"box": {**size, "center_x": x}}, "center_of_gravity": [x, -1], **more}
        for name, x in (("a", 0.0), ("b", apart))
    }
    told: list[str] = []
    config = HydrodynamicsConfig.model_validate({"bodies": bodies})
    _, problems = hulls_and_problems(config, folder, progress=told.append)
    assert all(p.keys == ("bodies", "b", "shape", "box") and p.remedy for p in problems)
    return [p.message for p in problems] + told


def test_bodies_that_overlap_or_nearly_touch_are_refused_before_any_flow_is_computed() -> None:
    """Panels of 1.2 m: in gaps of 0.2 m they make damping that is negative by several times its
    largest value; from half a side to 2.5, a warning tells that they are inaccurate."""
    assert boxes(20.0, panels=100) == []
    assert boxes(9.2, panels=100) == []
    for apart in (0.0, 1.0, 5.8):
        (text,) = boxes(apart, panels=100)
        assert text.startswith("bodies 'a' and 'b' overlap near x = ")
    (text,) = boxes(5.95, panels=100)
    assert text.startswith("the gap between bodies 'a' and 'b' is too narrow for their panels")
    for apart, width in ((6.0, "0"), (6.2, "0.2")):
        (text,) = boxes(apart, panels=100)
        assert f"gap between bodies 'a' and 'b' is about {width} m wide near x = 3" in text
    (text,) = boxes(6.5, panels=100)
    assert text.startswith("warning: the gap between bodies 'a' and 'b' is about 0.5 m wide")
    (text,) = boxes(8.0, panels=100)
    needed = re.search(r"use about (\d+) and (\d+) panels, so that the gap has 2.5 of", text)
    assert needed
    assert needed[1] == needed[2]
    more = round(1.5 * int(needed[1]))  # edges have whole numbers of panels
    assert boxes(8.0, panels=more) == []


@pytest.mark.parametrize(("gap", "message"), [(0.01, "the gap between"), (-0.5, "bodies 'first'")])
def test_panels_of_a_round_body_reach_beyond_it(gap: float, message: str) -> None:
    """A ball 1 cm below a flat bottom does not overlap, though its panels, as large in volume, do:
    they are too coarse for the gap. Half a metre is an overlap."""
    ball = {"sphere": {"radius": 1.0, "center_z": -3.0 - gap}}
    with pytest.raises(InputError) as caught:
        two_hulls(ball)
    (problem,) = caught.value.problems
    assert problem.message.startswith(message)
    assert ("use more panels" in problem.remedy) == (gap > 0)


def ring_of_panels() -> Panels:
    """A ring of 4 to 6 m, 2 m deep: one surface with an opening."""
    angle = np.linspace(0.0, 2 * np.pi, 33)
    rim = [(6.0, 0.0), (6.0, -1.0), (6.0, -2.0), (5.0, -2.0), (4.0, -2.0), (4.0, -1.0), (4.0, 0.0)]
    points = [[[r * np.cos(a), r * np.sin(a), z] for r, z in rim] for a in angle[::-1]]
    return grid(np.array(points)).merged()


def test_a_body_in_the_opening_of_another_does_not_overlap() -> None:
    """A spar in a ring: closed by its mirror image, the ring is not filled."""
    ring = ring_of_panels()
    assert hydrostatics_of(ring).volume > 0

    def spar(radius: float) -> Panels:
        return cylinder_panels(Cylinder(radius=radius, draft=10.0), 400)

    assert overlap(spar(2.0), ring) is None
    assert narrowest_gap(spar(1.0), ring) is None
    gap = narrowest_gap(spar(3.7), ring)
    assert gap is not None
    assert gap.width == pytest.approx(0.3, abs=0.1)
    assert overlap(spar(5.0), ring) is not None
    assert overlap(ring, spar(7.0)) is not None


@pytest.mark.parametrize(("top", "height"), [(-2.0, 2.0), (-8.0, 0.5)])
def test_tall_panels_far_below_need_not_resolve_short_waves(top: float, height: float) -> None:
    """A ring of panels of 2 m below rings of 0.5 m: in 8 m it feels no wave that it is coarse for.

    Of those that matter the waves are at least eight radii long.
    """
    rings = [top - 2.0, *np.arange(top, 0.1, 0.5)]
    angles = np.linspace(0.0, 2 * math.pi, 25)
    panels = grid(np.array([[[math.cos(a), math.sin(a), z] for z in rings] for a in angles]))
    made = Hull("float", panels, None, (0.0, -1.0), hydrostatics_of(panels))
    shortest = 2 * math.pi * 9.81 / resolved_frequency(made, Water()) ** 2
    width = 2 * math.sin(math.pi / 24)
    assert shortest == pytest.approx(8 * 0.5 * math.hypot(width, height), rel=1e-9)
