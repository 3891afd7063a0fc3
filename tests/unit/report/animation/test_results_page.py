"""Animations of systems follow from their results alone, and show what was computed."""

from __future__ import annotations

import base64
import tracemalloc
import zlib
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from support.floating_boxes import MODEL, floating_boxes

from m4e_fmi.cosim import Results, load, load_system, run, scene_without_build
from m4e_fmi.cosim.system.component import kind_module
from m4e_fmi.errors import InputError
from m4e_fmi.report import animate_run
from m4e_fmi.report.animation.frames import frames_of
from m4e_fmi.report.animation.scene import Scene, Train
from m4e_fmi.report.animation.scene_text import carried, scene_of_text
from m4e_fmi.results.dataset import SCENE

PLANAR = """\
name: pendulum_at_sea
components:
  swing: {model: swing.model.yaml}
  sea:
    kind: sea
    water: {density: 1000, depth: 8}
    waves: {spectrum: regular, height: 1.0, period: 5.0}
    points: {ahead: [11, 0]}
    start: {wave.height: 1.4, wave.period: 4.0, "wave.phase[1]": 0.7, wave.ramp_time: 3}
simulation: {stop_time: 8, step_size: 0.1}
"""
SWING = """\
name: swing
bodies: {rod: {mass: 1, inertia: 1}}
joints: {pin: {type: revolute, child: rod, joint_to_child: [0, -1], initial: {q: 1}}}
parameters: {reach: {value: 3, unit: m, description: Place of the anchor}}
points: {end: {body: rod, at: [0, -1]}, wall: {body: ground, at: [reach, -2]}}
loads: {rope: {type: tension_spring, points: [end, wall], stiffness: 5, length: 2}}
"""


@pytest.fixture(scope="module")
def boxes(tmp_path_factory: pytest.TempPathFactory) -> Results:
    folder = tmp_path_factory.mktemp("boxes")
    run(floating_boxes(folder), results=folder / "boxes.nc", build_directory=folder, animated=True)
    return load(folder / "boxes.nc")


@pytest.fixture(scope="module")
def scene(boxes: Results) -> Scene:
    return scene_of_text(boxes.attributes[SCENE])


def test_the_surface_is_the_sea_of_the_results(boxes: Results, scene: Scene) -> None:
    """Spread waves from 40°, with their ramp: at a point of a component with the same sea."""
    assert scene.water is not None
    assert (scene.water.gauge, scene.floor) == ("hulls.wave.elevation", -20)
    recorded = boxes["sea.buoy.elevation"]
    assert np.ptp(recorded) > 0.2
    # ten digits of the waves
    assert scene.water.elevation(7, -3, boxes.time) == pytest.approx(recorded, abs=1e-8)


def test_waves_have_the_start_values_of_their_parameters(tmp_path: Path) -> None:
    (tmp_path / "swing.model.yaml").write_text(SWING, encoding="ascii")
    (tmp_path / "system.yaml").write_text(PLANAR, encoding="ascii")
    run(tmp_path / "system.yaml", results=tmp_path / "r.nc", build_directory=tmp_path)
    results = load(tmp_path / "r.nc")
    scene = scene_of_text(results.attributes[SCENE])
    assert scene.planar
    assert scene.water is not None
    recorded = results["sea.ahead.elevation"]
    assert np.ptp(recorded) > 1.2
    assert scene.water.elevation(11, 0, results.time) == pytest.approx(recorded, abs=1e-8)
    (rope,) = scene.ropes
    assert [end.at for end in rope.ends] == [(0, 0, -1), (3, 0, -2)]
    assert animate_run(results, tmp_path / "r.html").stat().st_size < 60_000


def test_a_wave_by_hand() -> None:
    one = np.ones(1)
    train = Train(2 * one, 0.5 * one, 3 * one, 0.1 * one, np.pi / 2 * one, ramp=4.0)
    height = 3 * np.cos(2 * 1.0 + 0.1 - 0.5 * 7.0) * (1 - np.cos(np.pi / 4)) / 2
    assert train.elevation(100.0, 7.0, np.array([1.0])) == pytest.approx(height)


def test_hulls_are_on_the_bodies_that_they_move_with(scene: Scene) -> None:
    """In the axes of the body, about its centre of gravity."""
    barge, cube, mast = scene.bodies
    assert [body.name for body in scene.bodies] == ["boxes.barge", "boxes.cube", "boxes.mast"]
    (hull,) = barge.surfaces
    assert np.ptp(hull.vertices, axis=0) == pytest.approx([6, 4, 2])
    assert len(cube.surfaces) == len(mast.surfaces) == 1
    corners = cube.surfaces[0].vertices  # of the mesh, in triangles
    assert sorted(map(tuple, corners)) == [*product((-1, 1), repeat=3)]
    assert {len(face) for face in cube.surfaces[0].faces} == {3}


def test_a_shape_of_the_model_is_shown_and_not_the_hull(tmp_path: Path) -> None:
    system = floating_boxes(tmp_path)
    model = tmp_path / "boxes.model.yaml"
    own = "4.0e3], shape: {sphere: {radius: 0.8}}}"
    model.write_text(model.read_text().replace("4.0e3]}", own), encoding="ascii")
    scene = scene_without_build(load_system(system))
    assert scene is not None
    (ball,) = scene.bodies[1].surfaces
    assert np.ptp(ball.vertices, axis=0) == pytest.approx([1.6, 1.6, 1.6])


def test_fixed_hulls_stand_where_the_heading_turns_them(tmp_path: Path) -> None:
    """About the middle of the moving bodies; the radius and the profile are the file's."""
    (tmp_path / "boxes.model.yaml").write_text(MODEL, encoding="ascii")
    text = """
name: s
components:
  boxes: {model: boxes.model.yaml}
  hydro:
    kind: hydrodynamics
    dimensions: 3
    heading: 90
    bodies:
      barge: {shape: {box: {length: 6, width: 4, draft: 1}}, center_of_gravity: [1, 0, 0]}
      pile: {shape: {cylinder: {radius: 1, draft: 5, center_x: 9}}, fixed: true}
      ring: {shape: {torus: {radius: 3, tube_radius: 0.5, center_x: 30}}, fixed: true}
connections: []
simulation: {stop_time: 1, step_size: 0.1}
"""
    (tmp_path / "s.yaml").write_text(text, encoding="ascii")
    scene = scene_without_build(load_system(tmp_path / "s.yaml"))
    assert scene is not None
    assert [body.name for body in scene.bodies[3:]] == [
        "hydro.barge", "hydro.pile (fixed)", "hydro.ring (fixed)"
    ]  # fmt: skip
    barge, pile, ring = scene.bodies[3:]
    assert barge.motion == (1.0, 0.0, 0.0, 0.0, 0.0, pytest.approx(np.pi / 2))
    assert barge.surfaces[0].vertices.min(axis=0) == pytest.approx([-4, -2, -1])
    corners = pile.surfaces[0].vertices
    assert (corners.min(axis=0) + corners.max(axis=0)) / 2 == pytest.approx([1, 8, -2.5])
    corners = ring.surfaces[0].vertices
    assert np.ptp(corners, axis=0) == pytest.approx([7, 7, 2 * 0.5 * np.sin(np.radians(72))])


def test_bodies_and_nodes_are_where_the_results_have_them(boxes: Results, scene: Scene) -> None:
    shown = frames_of(scene, boxes.time, boxes.series, most=10_000)
    assert shown.times == pytest.approx(boxes.time)
    place = np.stack([boxes[f"boxes.body.cube.{axis}"] for axis in "xyz"], axis=1)
    assert shown.poses.places[:, 1] == pytest.approx(place)
    bow = np.stack([boxes[f"boxes.point.bow.{axis}"] for axis in "xyz"], axis=1)
    # the point of the body, by its pose and the file's numbers
    assert shown.poses.places[:, 0] + shown.poses.attitudes[:, 0] @ [-3, 0, -0.5] == pytest.approx(
        bow, abs=1e-9
    )
    (line,) = shown.cables
    assert line.shape[1:] == (13, 3)
    assert line[:, 0] == pytest.approx(np.tile([-40.0, 0.0, -20.0], (len(line), 1)))
    # explicit coupling: the end of the line is one step of 0.05 s behind at 1 m/s
    assert line[:, -1] == pytest.approx(bow, abs=0.05)
    assert shown.exact == (True,)


def test_lines_without_nodes_are_straight_and_told(tmp_path: Path, boxes: Results) -> None:
    mooring = {
        name: one for name, one in boxes.components["mooring"].items() if ".node_" not in name
    }
    less = replace(boxes, components={**boxes.components, "mooring": mooring})
    text = animate_run(less, tmp_path / "a.html").read_text(encoding="utf-8")
    assert "Dashed straight lines (mooring.line): the places of their nodes" in text
    assert "Dashed" not in animate_run(boxes, tmp_path / "b.html").read_text(encoding="utf-8")


def test_nodes_are_recorded_where_an_animation_is_wanted(tmp_path: Path) -> None:
    system = floating_boxes(tmp_path)
    run(system, results=tmp_path / "a.nc", build_directory=tmp_path)
    names = set(load(tmp_path / "a.nc").series)
    assert "mooring.line.node_x[1]" not in names
    run(system, results=tmp_path / "b.nc", build_directory=tmp_path, animated=True,
        variables=["sea.*"])  # fmt: skip
    names = set(load(tmp_path / "b.nc").series)
    assert {"mooring.line.node_x[1]", "boxes.body.cube.psi", "sea.buoy.elevation"} <= names
    assert "boxes.body.cube.vx" not in names


def test_waves_that_differ_from_those_recorded_are_told(
    tmp_path: Path, boxes: Results, scene: Scene
) -> None:
    assert scene.water is not None
    (train,) = scene.water.trains
    other = replace(scene, water=replace(scene.water, trains=(replace(train, ramp=0.0),)))
    changed = replace(boxes, attributes={**boxes.attributes, **carried(other)})
    text = animate_run(changed, tmp_path / "a.html").read_text(encoding="utf-8")
    assert "The water is drawn still: the waves of the scene differ by up to" in text


@pytest.mark.parametrize(
    ("scene_of_kind", "told"),
    [
        (lambda *_, **__: 1 / 0, "failed with ZeroDivisionError: division by"),
        (lambda *_, **__: "box", "is a str, not a Shown"),
    ],
)
def test_a_kind_whose_scene_fails_does_not_stop_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene_of_kind: Callable[..., object], told: str
) -> None:
    monkeypatch.setattr(kind_module("sea"), "scene", scene_of_kind)
    (tmp_path / "swing.model.yaml").write_text(SWING, encoding="ascii")
    (tmp_path / "system.yaml").write_text(PLANAR, encoding="ascii")
    run(tmp_path / "system.yaml", results=tmp_path / "r.nc", build_directory=tmp_path)
    text = animate_run(tmp_path / "r.nc", tmp_path / "r.html").read_text(encoding="utf-8")
    assert f"sea is not shown: the scene of kind &#x27;sea&#x27; {told}" in text


def test_texts_cannot_become_code(tmp_path: Path, boxes: Results) -> None:
    text = animate_run(boxes, tmp_path / "a.html").read_text(encoding="utf-8")
    assert "Two hulls &lt;in&gt; waves" in text
    for word in ("http:", "https:", "src=", "import ", '"@'):
        assert word not in text


@pytest.mark.parametrize("rows", [0, 1])
def test_results_of_too_few_rows_are_refused(tmp_path: Path, boxes: Results, rows: int) -> None:
    components = {
        component: {name: one[:rows] for name, one in members.items()}
        for component, members in boxes.components.items()
    }
    short = replace(boxes, time=boxes.time[:rows], components=components)
    with pytest.raises(InputError, match=r"boxes\.nc.*(no rows|one row) of finite numbers"):
        animate_run(short, tmp_path / "a.html")


def test_results_that_show_nothing_are_refused(tmp_path: Path, boxes: Results) -> None:
    other = {name: text for name, text in boxes.attributes.items() if name != SCENE}
    with pytest.raises(InputError, match=r"boxes\.nc.*has no scene"):
        animate_run(replace(boxes, attributes=other), tmp_path / "a.html")
    with pytest.raises(InputError, match="its scene is damaged"):
        animate_run(replace(boxes, attributes={**other, SCENE: "eJyr"}), tmp_path / "a.html")
    components = {n: m for n, m in boxes.components.items() if n != "boxes"}
    with pytest.raises(InputError, match=r"it has no 'boxes\.body\.barge\.phi' and \d+ more"):
        animate_run(replace(boxes, components=components), tmp_path / "a.html")
    with pytest.raises(InputError, match=r"cannot be written as '\.gif'"):
        animate_run(boxes, tmp_path / "a.gif")
    assert not list(tmp_path.iterdir())


def test_a_scene_that_unpacks_to_too_much_is_refused() -> None:
    """0.4 MB of text, which would be 300 MB and as many lists."""
    packed = zlib.compress(b"[" + 100_000_000 * b"[]," + b"0]", 9)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="more than 20 MB when unpacked"):
            scene_of_text(base64.b64encode(packed).decode("ascii"))
        assert tracemalloc.get_traced_memory()[1] < 60e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("broken", [b"[" * 100_000, b'{"format": 1', b'{"format": 1}'])
def test_a_scene_that_is_damaged_is_refused(broken: bytes) -> None:
    with pytest.raises(InputError, match="its scene is damaged"):
        scene_of_text(base64.b64encode(zlib.compress(broken)).decode("ascii"))
    whole = zlib.compress(broken)
    with pytest.raises(InputError, match="its scene is damaged"):
        scene_of_text(base64.b64encode(whole[:-6]).decode("ascii"))


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_scene_with_a_number_that_is_not_finite_is_refused(
    tmp_path: Path, boxes: Results, scene: Scene, number: float
) -> None:
    changed = replace(
        boxes, attributes={**boxes.attributes, **carried(replace(scene, floor=number))}
    )
    with pytest.raises(InputError, match=r"boxes\.nc.*its scene has the number (NaN|Infinity)"):
        animate_run(changed, tmp_path / "a.html")


def test_rows_from_the_first_with_a_node_that_is_not_a_number_are_left_out(
    tmp_path: Path, boxes: Results
) -> None:
    place = boxes["mooring.line.node_z[3]"].copy()
    place[40:] = np.nan
    components = {n: dict(m) for n, m in boxes.components.items()}
    components["mooring"]["line.node_z[3]"] = place
    broken = replace(boxes, components=components)
    text = animate_run(broken, tmp_path / "a.html").read_text(encoding="utf-8")
    assert f"Shown until t = {boxes.time[39]:.6g} s: numbers after that are not finite" in text
    place[:] = np.nan
    with pytest.raises(InputError, match=r"boxes\.nc.*no rows of finite numbers"):
        animate_run(broken, tmp_path / "a.html")


def test_a_run_that_ended_early_says_so(tmp_path: Path, boxes: Results) -> None:
    ended = replace(boxes, attributes={**boxes.attributes, "ended": "failed: hulls is nan"})
    text = animate_run(ended, tmp_path / "a.html").read_text(encoding="utf-8")
    assert "The run ended early (failed: hulls is nan); shown until t = 6 s." in text
