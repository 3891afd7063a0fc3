"""Animations of systems follow from their results alone, and show what was computed."""

from __future__ import annotations

import base64
import tracemalloc
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.floating_boxes import MODEL, floating_boxes

from m4e_fmi.cosim import Results, Series, load, load_system, run, scene_without_build
from m4e_fmi.errors import InputError
from m4e_fmi.report import animate_run
from m4e_fmi.report.animation.frames import frames_of
from m4e_fmi.report.animation.scene import Scene
from m4e_fmi.report.animation.scene_text import carried, scene_of_text
from m4e_fmi.results.series import SCENE
from m4e_fmus import sea

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


def planar_run(folder: Path) -> Results:
    (folder / "swing.model.yaml").write_text(SWING, encoding="ascii")
    (folder / "system.yaml").write_text(PLANAR, encoding="ascii")
    run(folder / "system.yaml", results=folder / "r.nc", build_directory=folder)
    return load(folder / "r.nc")


def page(results: Results, folder: Path) -> str:
    return animate_run(results, folder / "a.html").read_text(encoding="utf-8")


def with_parts(results: Results, **parts: dict[str, Series] | None) -> Results:
    """Results with other components, or without them."""
    components = {n: m for n, m in {**results.components, **parts}.items() if m is not None}
    return replace(results, components=components)


def test_the_surface_is_the_sea_of_the_results(boxes: Results, scene: Scene) -> None:
    """Spread waves from 40°, with their ramp: at a point of a component with the same sea."""
    assert scene.water is not None
    assert (scene.water.gauge, scene.floor) == ("hulls.wave.elevation", -20)
    recorded = boxes["sea.buoy.elevation"]
    assert np.ptp(recorded) > 0.2
    # ten digits of the waves
    assert scene.water.elevation(7, -3, boxes.time) == pytest.approx(recorded, abs=1e-8)


def test_waves_have_the_start_values_of_their_parameters(tmp_path: Path) -> None:
    results = planar_run(tmp_path)
    scene = scene_of_text(results.attributes[SCENE])
    assert scene.planar
    assert scene.water is not None
    recorded = results["sea.ahead.elevation"]
    assert np.ptp(recorded) > 1.2
    assert scene.water.elevation(11, 0, results.time) == pytest.approx(recorded, abs=1e-8)
    (rope,) = scene.ropes
    assert [end.at for end in rope.ends] == [(0, 0, -1), (3, 0, -2)]
    assert len(page(results, tmp_path)) < 60_000


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
connections: []
simulation: {stop_time: 1, step_size: 0.1}
"""
    (tmp_path / "s.yaml").write_text(text, encoding="ascii")
    scene = scene_without_build(load_system(tmp_path / "s.yaml"))
    assert scene is not None
    barge, pile = scene.bodies[3:]
    assert barge.motion == (1.0, 0.0, 0.0, 0.0, 0.0, pytest.approx(np.pi / 2))
    assert barge.surfaces[0].vertices.min(axis=0) == pytest.approx([-4, -2, -1])
    corners = pile.surfaces[0].vertices
    assert (corners.min(axis=0) + corners.max(axis=0)) / 2 == pytest.approx([1, 8, -2.5])


def test_bodies_and_nodes_are_where_the_results_have_them(boxes: Results, scene: Scene) -> None:
    shown = frames_of(scene, boxes.time, boxes.series, most=10_000)
    assert shown.times == pytest.approx(boxes.time)
    place = np.stack([boxes[f"boxes.body.cube.{axis}"] for axis in "xyz"], axis=1)
    assert shown.poses.places[:, 1] == pytest.approx(place)
    bow = np.stack([boxes[f"boxes.point.bow.{axis}"] for axis in "xyz"], axis=1)
    # the point of the body, by its pose and the file's numbers
    found = shown.poses.places[:, 0] + shown.poses.attitudes[:, 0] @ [-3, 0, -0.5]
    assert found == pytest.approx(bow, abs=1e-9)
    (line,) = shown.cables
    assert line.shape[1:] == (13, 3)
    assert line[:, 0] == pytest.approx(np.tile([-40.0, 0.0, -20.0], (len(line), 1)))
    # explicit coupling: the end of the line is one step of 0.05 s behind at 1 m/s
    assert line[:, -1] == pytest.approx(bow, abs=0.05)
    assert shown.exact == (True,)


def test_nodes_are_recorded_where_an_animation_is_wanted(tmp_path: Path) -> None:
    system = floating_boxes(tmp_path)
    system.write_text(system.read_text("ascii").replace("stop_time: 6", "stop_time: 0.1"), "ascii")
    names = []
    for animated in (False, True):
        path = tmp_path / f"{animated}.nc"
        chosen = ["sea.*"] if animated else []
        run(system, results=path, build_directory=tmp_path, animated=animated, variables=chosen)
        names.append(set(load(path).series))
    assert "mooring.line.node_x[1]" not in names[0]
    assert {"mooring.line.node_x[1]", "boxes.body.cube.psi", "sea.buoy.elevation"} <= names[1]
    assert "boxes.body.cube.vx" not in names[1]


def test_what_is_not_shown_as_computed_is_told(
    tmp_path: Path, boxes: Results, scene: Scene
) -> None:
    """Lines without nodes, other waves than recorded, rows without numbers, a run that failed."""
    text = page(boxes, tmp_path)
    assert "Two hulls &lt;in&gt; waves" in text
    assert not [word for word in ("http:", "https:", "src=", "import ", '"@') if word in text]
    assert "Dashed" not in text
    mooring = boxes.components["mooring"]
    less = with_parts(boxes, mooring={n: one for n, one in mooring.items() if ".node_" not in n})
    text = page(less, tmp_path)
    assert "Dashed straight lines (mooring.line): the places of their nodes" in text
    assert scene.water is not None
    (train,) = scene.water.trains
    other = replace(scene, water=replace(scene.water, trains=(replace(train, ramp=0.0),)))
    changed = replace(boxes, attributes={**boxes.attributes, **carried(other)})
    text = page(changed, tmp_path)
    assert "The water is drawn still: the waves of the scene differ by up to" in text
    place = boxes["mooring.line.node_z[3]"].copy()
    broken = with_parts(boxes, mooring={**mooring, "line.node_z[3]": place})
    place[40:] = np.nan
    text = page(broken, tmp_path)
    assert f"Shown until t = {boxes.time[39]:.6g} s: numbers after that are not finite" in text
    place[:] = np.nan
    with pytest.raises(InputError, match=r"boxes\.nc.*no rows of finite numbers"):
        page(broken, tmp_path)
    ended = replace(boxes, attributes={**boxes.attributes, "ended": "failed: hulls is nan"})
    told = "The run ended early (failed: hulls is nan); shown until t = 6 s."
    assert told in page(ended, tmp_path)


@pytest.mark.parametrize(
    ("scene_of_kind", "told"),
    [
        (lambda *_, **__: 1 / 0, "failed with ZeroDivisionError: division by"),  # pyrefly: ignore[division-by-zero]
        (lambda *_, **__: "box", "is a str, not a Shown"),
    ],
)
def test_a_kind_whose_scene_fails_does_not_stop_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene_of_kind: Callable[..., object], told: str
) -> None:
    monkeypatch.setattr(sea, "KIND", replace(sea.KIND, scene=scene_of_kind))
    text = page(planar_run(tmp_path), tmp_path)
    assert f"sea is not shown: the scene of kind &#x27;sea&#x27; {told}" in text


def test_results_that_show_nothing_are_refused(
    tmp_path: Path, boxes: Results, scene: Scene
) -> None:
    other = {name: text for name, text in boxes.attributes.items() if name != SCENE}
    floor = [carried(replace(scene, floor=number)) for number in (np.nan, np.inf)]
    short = [
        replace(
            boxes, time=boxes.time[:rows],
            components={c: {n: one[:rows] for n, one in m.items()}
                        for c, m in boxes.components.items()},
        ) for rows in (0, 1)
    ]  # fmt: skip
    for results, said in (
        (replace(boxes, attributes=other), "has no scene"),
        (replace(boxes, attributes={**other, SCENE: "eJyr"}), "its scene is damaged"),
        (replace(boxes, attributes={**other, **floor[0]}), "its scene has the number NaN"),
        (replace(boxes, attributes={**other, **floor[1]}), "its scene has the number Infinity"),
        (with_parts(boxes, boxes=None), r"it has no 'boxes\.body\.barge\.phi' and \d+ more"),
        (short[0], "no rows of finite numbers"),
        (short[1], "one row of finite numbers"),
    ):
        with pytest.raises(InputError, match=rf"boxes\.nc.*{said}"):
            page(results, tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"[" * 100_000, "its scene is damaged"),
        (b'{"format": 1', "its scene is damaged"),
        (b'{"format": 1}', "its scene is damaged"),
        # 0.4 MB, which would be 300 MB and as many lists
        (b"[" + 100_000_000 * b"[]," + b"0]", "more than 20 MB when unpacked"),
    ],
    ids=["deep", "cut", "empty", "large"],
)
def test_a_scene_that_is_damaged_or_too_large_is_refused(text: bytes, said: str) -> None:
    packed = zlib.compress(text, 9)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=said):
            scene_of_text(base64.b64encode(packed).decode("ascii"))
        assert tracemalloc.get_traced_memory()[1] < 60e6
    finally:
        tracemalloc.stop()
    with pytest.raises(InputError, match=r"its scene is damaged|more than 20 MB"):
        scene_of_text(base64.b64encode(packed[:-6]).decode("ascii"))
