"""Chrono's YAML files: the same motion as the paper's lists, and signs one by one.

Signs and defaults are those of Project Chrono's sources; see m4e_fmi/model/chrono.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from support import paper_listings
from support.chrono_files import FRAMES, chrono_model
from support.programs import Evaluated

from m4e_fmi.model import Model, load_model, model_from_lists
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import simulate

Data = dict[str, Any]


def saved(folder: Path, data: Any, name: str = "copy.yaml") -> Path:
    path = folder / name
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def loaded(folder: Path, data: Data) -> Model:
    return load_model(saved(folder, data))


def pendulum() -> Data:
    """A rod on a hinge, one metre below it, at rest."""
    return {
        "chrono-version": "10.0",
        "model": {
            "name": "one rod",
            "angle_degrees": False,
            "bodies": [
                {"name": "ground", "location": [0, 0, 0], "fixed": True},
                {"name": "rod", "location": [0, 0, -1], "mass": 2,
                 "inertia": {"moments": [7, 3, 7]}},
            ],
            "joints": [
                {"name": "hinge", "type": "REVOLUTE", "body1": "ground", "body2": "rod",
                 "location": [0, 0, 0], "axis": [0, 1, 0]},
            ],
        },
    }  # fmt: skip


def slider() -> Data:
    """A block that slides along X on the ground."""
    data = pendulum()
    data["model"]["bodies"][1]["location"] = [0, 0, 0]
    data["model"]["joints"][0] |= {"type": "PRISMATIC", "axis": [1, 0, 0]}
    return data


def rates(folder: Path, data: Data, **values: float) -> dict[str, float]:
    program = Evaluated(model_program(loaded(folder, data)))
    return program.rates(values)


@pytest.mark.parametrize("frames", FRAMES)
@pytest.mark.parametrize("degrees", [False, True])
@pytest.mark.parametrize(
    "name", ["small_double_pendulum", "double_pendulum", "cart", "spiderfloat"]
)
def test_the_same_motion_as_the_lists(
    tmp_path: Path, name: str, degrees: bool, frames: str
) -> None:
    """From a random pose with random velocities, so that every frame and every sign counts."""
    lists = getattr(paper_listings, name)()
    count = len(lists.get("ic", np.zeros(18)))
    rng = np.random.default_rng(4)
    ic = rng.uniform(-1.0, 1.0, count)
    if name == "spiderfloat":
        ic[:2] = 0  # there parent_cg_to_joint says where it starts
    lists["ic"] = ic
    lists.get("Force", {}).pop("CG", None)  # tested one by one, below
    expected = simulate(model_from_lists(lists), stop_time=1.0, output_interval=0.1)
    copy = loaded(tmp_path, chrono_model(lists, frames=frames, degrees=degrees))
    got = simulate(copy, stop_time=1.0, output_interval=0.1)
    for k in range(len(lists["joints"])):
        for quantity in ("x", "z", "omega"):
            # local errors of 1e-8 in different coordinates, over a motion that does not diverge
            wanted = expected[f"body.body_{k + 1}.{quantity}"]
            assert got[f"body.body_{k + 1}.{quantity}"] == pytest.approx(wanted, abs=2e-6)


def test_gravity_of_the_file_beside_and_without_one_chronos_own(tmp_path: Path) -> None:
    path = saved(tmp_path, pendulum(), "rod.yaml")
    assert load_model(path).gravity == 9.8
    data = {"chrono-version": 10.0, "type": "MBS", "model": "rod.yaml", "solver": "s.yaml",
            "simulation": {"end_time": 100, "gravity": [0, 0, -3.7]}}  # fmt: skip
    model = load_model(saved(tmp_path, data, "mbs.yaml"))  # which names its model
    assert (model.name, model.gravity) == ("one_rod", 3.7)
    path = saved(tmp_path, pendulum(), "rod.model.yaml")
    saved(tmp_path, {"simulation": {"gravity": [0, 0, -1.62]}}, "rod.simulation.yaml")
    assert load_model(path).gravity == 1.62


FORCE = {"name": "new", "type": "FORCE", "body": "rod", "load": [1, 0, 0], "point": [0, 0, -1]}
ENDS = {"name": "new", "body1": "ground", "body2": "rod"}
SPRING = ENDS | {"point1": [-1, 0, 0], "point2": [0, 0, 0], "spring_coefficient": 50}
CONSTANT = {"type": "CONSTANT", "value": 5}
MOTOR = ENDS | {"type": "LINEAR", "location": [0, 0, 0], "axis": [1, 0, 0],
                "actuation_type": "FORCE", "actuation_function": CONSTANT}  # fmt: skip
PULL = MOTOR | {"body1": "rod", "body2": "ground", "guide": "FREE"}
POLYNOMIAL = {"type": "POLYNOMIAL", "coefficients": [3, 0.1, 0]}
TURN = MOTOR | {"type": "ROTATION", "axis": [0, 1, 0], "spindle": "FREE",
                "actuation_function": POLYNOMIAL}  # fmt: skip
SIGNS: dict[str, tuple[Data, str, Data, dict[str, float], float]] = {
    "a torque is about Y": (
        pendulum(), "body_loads", FORCE | {"type": "torque", "load": [0, 7, 0]}, {}, 7 / (3 + 2)),
    # 1 N along the rod's own X at its lower end, two metres from the hinge
    "a local force": (pendulum(), "body_loads", FORCE, {}, -2 / 5),
    "a local force turns with the body": (pendulum(), "body_loads", FORCE, {"q": 1.3}, -2 / 5),
    "a force that keeps its direction": (
        pendulum(), "body_loads", FORCE | {"local_load": False}, {"q": 1.3},
        -2 * math.cos(1.3) / 5),
    # at its free length, 6 N push the block away from the wall on its left
    "a preload pushes": (
        slider(), "tsdas", SPRING | {"free_length": 1, "preload": 6}, {}, 6 / 2),
    "spring and damper in one": (
        slider(), "tsdas", SPRING | {"type": "TSDA", "damping_coefficient": 4, "free_length": 0.9,
                                     "visualization": {"type": "SPRING"}},
        {"u": 0.5}, (-50 * 0.1 - 4 * 0.5) / 2),
    "a motor on a joint that is there": (pendulum(), "motors", TURN, {"t": 4.0}, -(3 + 0.4) / 5),
}  # fmt: skip
FUNCTIONS: list[tuple[Data, float]] = [
    (CONSTANT, 5.0),
    ({"type": "RAMP", "slope": 2, "intercept": 1}, 2.6),
    ({"type": "POLY", "coefficients": [1, 0, 2]}, 1 + 2 * 0.64),
    ({"type": "SINE", "amplitude": 2, "frequency": 0.5, "phase": 0.1},
     2 * math.sin(2 * math.pi * 0.5 * 0.8 + 0.1)),
    ({"type": "DATA", "data": [[0, 0], [1, 10], [2, 0]]}, 8.0),
]  # fmt: skip
SIGNS |= {
    f"a force of {function['type']}": (
        slider(), "motors", PULL | {"actuation_function": function}, {"t": 0.8}, value / 2)
    for function, value in FUNCTIONS
}  # fmt: skip


class TestSigns:
    @pytest.mark.parametrize("case", SIGNS)
    def test_accelerations_by_hand(self, tmp_path: Path, case: str) -> None:
        data, group, entry, at, expected = SIGNS[case]
        data["model"][group] = [entry]
        data["simulation"] = {"gravity": [0, 0, 0]}
        program = Evaluated(model_program(loaded(tmp_path, data)))
        values = {f"joint.hinge.{name}": value for name, value in at.items() if name != "t"}
        found = program.rates(values, t=at.get("t", 0.0))["joint.hinge.u"]
        assert found == pytest.approx(expected)

    def test_a_local_force_is_in_the_axes_of_the_centroidal_frame(self, tmp_path: Path) -> None:
        """With com.orientation a quarter turn about Y, its Z is the world's X at the start."""
        data = slider()
        data["model"]["bodies"][1]["com"] = {"orientation": [0, math.pi / 2, 0]}
        data["model"]["body_loads"] = [FORCE | {"load": [0, 0, 4], "point": [0, 0, 0]}]
        assert rates(tmp_path, data)["joint.hinge.u"] == pytest.approx(2.0)

    @pytest.mark.parametrize(("body1", "sign"), [("rod", 1), ("ground", -1)])
    @pytest.mark.parametrize("direction", [1, -1])
    def test_a_motor_that_guides(
        self, tmp_path: Path, body1: str, sign: int, direction: int
    ) -> None:
        """+F along its axis on body1, −F on body2; it is the prismatic joint as well."""
        data = slider()
        data["model"]["joints"] = []
        ends = {"body1": body1, "body2": "ground" if body1 == "rod" else "rod"}
        data["model"]["motors"] = [MOTOR | ends | {"axis": [3 * direction, 0, 0]}]
        program = Evaluated(model_program(loaded(tmp_path, data)))
        assert program.outputs({})["body.rod.ax"] == pytest.approx(sign * direction * 5 / 2)

    def test_a_controllers_motor_is_an_input(self, tmp_path: Path) -> None:
        data = slider()
        data["model"]["joints"] = []
        controller = {"guide": "PRISMATIC", "actuation_function": {"type": "CONTROLLER"}}
        data["model"]["motors"] = [MOTOR | controller]
        program = model_program(loaded(tmp_path, data))
        assert "joint.new.effort" in {v.name for v in program.inputs}


class TestStructure:
    def test_a_locked_body(self, tmp_path: Path) -> None:
        """Two rods as one: J + m L² of both about the hinge."""
        data = pendulum()
        data["model"]["bodies"].append(
            {"name": "tip", "location": [0, 0, -3], "mass": 1, "inertia": {"moments": [3, 4, 3]}}
        )
        data["model"]["joints"].append(
            {"name": "weld", "type": "LOCK", "body1": "tip", "body2": "rod", "location": [0, 0, -2]}
        )
        q = 0.4
        torque = -9.8 * math.sin(q) * (2 * 1 + 1 * 3)
        expected = torque / (3 + 2 * 1 + 4 + 1 * 9)
        assert rates(tmp_path, data, **{"joint.hinge.q": q})["joint.hinge.u"] == pytest.approx(
            expected
        )

    def test_inertia_in_any_axes(self, tmp_path: Path) -> None:
        """Products count: a tensor in axes turned by 30° about X."""
        data = pendulum()
        data["model"]["bodies"][1] |= {
            "orientation": [0, 0, math.radians(30)],
            "inertia": {"moments": [7, 2, 8], "products": [0, 0, 0.5]},
        }
        y = np.array([0, math.cos(math.radians(30)), -math.sin(math.radians(30))])
        tensor = np.array([[7, 0, 0], [0, 2, 0.5], [0, 0.5, 8]])
        _, about_y, *_ = cast("tuple[float, ...]", loaded(tmp_path, data).bodies["rod"].inertia)
        assert about_y == pytest.approx(y @ tensor @ y)
