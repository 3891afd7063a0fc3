"""Chrono's YAML files: the same motion as the paper's lists, and signs one by one.

Signs and defaults are those of Project Chrono's sources; see m4e_fmi/model/chrono.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

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


class TestGravity:
    def test_absent_gravity_is_chronos_own(self, tmp_path: Path) -> None:
        assert loaded(tmp_path, pendulum()).gravity == 9.8

    def test_gravity_of_the_file_beside(self, tmp_path: Path) -> None:
        path = saved(tmp_path, pendulum(), "rod.model.yaml")
        simulation = {"simulation": {"time_step": 0.1, "gravity": [0, 0, -1.62]}}
        saved(tmp_path, simulation, "rod.simulation.yaml")
        assert load_model(path).gravity == 1.62

    def test_a_simulation_file_that_names_its_model(self, tmp_path: Path) -> None:
        saved(tmp_path, pendulum(), "rod.yaml")
        data = {"chrono-version": 10.0, "type": "MBS", "model": "rod.yaml", "solver": "s.yaml",
                "simulation": {"end_time": 100, "gravity": [0, 0, -3.7]}}  # fmt: skip
        model = load_model(saved(tmp_path, data, "mbs.yaml"))
        assert (model.name, model.gravity) == ("one_rod", 3.7)


class TestSigns:
    def test_a_torque_is_about_y(self, tmp_path: Path) -> None:
        data = pendulum()
        data["model"]["body_loads"] = [
            {"name": "turn", "type": "torque", "body": "rod", "load": [0, 7, 0]}
        ]
        data["simulation"] = {"gravity": [0, 0, 0]}
        assert rates(tmp_path, data)["joint.hinge.u"] == pytest.approx(7 / (3 + 2))

    def test_a_local_force_turns_with_the_body(self, tmp_path: Path) -> None:
        """1 N along the rod's own X at its lower end, two metres from the hinge."""
        data = pendulum()
        data["model"]["body_loads"] = [
            {"name": "jet", "type": "FORCE", "body": "rod", "load": [1, 0, 0], "point": [0, 0, -1]}
        ]
        data["simulation"] = {"gravity": [0, 0, 0]}
        for angle in (0.0, 1.3):
            result = rates(tmp_path, data, **{"joint.hinge.q": angle})
            assert result["joint.hinge.u"] == pytest.approx(-2.0 / 5)
        data["model"]["body_loads"][0]["local_load"] = False
        result = rates(tmp_path, data, **{"joint.hinge.q": 1.3})
        assert result["joint.hinge.u"] == pytest.approx(-2.0 * math.cos(1.3) / 5)

    def test_a_local_force_is_in_the_axes_of_the_centroidal_frame(self, tmp_path: Path) -> None:
        """With com.orientation a quarter turn about Y, its Z is the world's X at the start."""
        data = slider()
        data["model"]["bodies"][1]["com"] = {"orientation": [0, math.pi / 2, 0]}
        data["model"]["body_loads"] = [
            {"name": "push", "type": "FORCE", "body": "rod", "load": [0, 0, 4], "point": [0, 0, 0]}
        ]
        assert rates(tmp_path, data)["joint.hinge.u"] == pytest.approx(2.0)

    @pytest.mark.parametrize("axis", [1, -1])
    def test_free_angle_is_from_the_start_about_the_axis(self, tmp_path: Path, axis: int) -> None:
        data = pendulum()
        data["model"]["bodies"][1] |= {"location": [-math.sin(0.3), 0, -math.cos(0.3)],
                                       "orientation": [0, 0.3, 0]}  # fmt: skip
        data["model"]["rsdas"] = [
            {"name": "coil", "body1": "ground", "body2": "rod", "axis": [0, axis, 0],
             "spring_coefficient": 10, "free_angle": 0.2}
        ]  # fmt: skip
        spring = loaded(tmp_path, data).loads["coil"]
        assert spring.angle == pytest.approx(0.3 + axis * 0.2)  # type: ignore[union-attr]

    def test_free_angle_in_degrees_is_the_default(self, tmp_path: Path) -> None:
        data = pendulum()
        del data["model"]["angle_degrees"]
        data["model"]["rsdas"] = [
            {"name": "coil", "body1": "ground", "body2": "rod", "axis": [0, 1, 0],
             "spring_coefficient": 10, "free_angle": 90}
        ]  # fmt: skip
        spring = loaded(tmp_path, data).loads["coil"]
        assert spring.angle == pytest.approx(math.pi / 2)  # type: ignore[union-attr]

    def test_a_preload_pushes(self, tmp_path: Path) -> None:
        """At its free length, 6 N push the block away from the wall on its left."""
        data = slider()
        data["model"]["tsdas"] = [
            {"name": "spring", "body1": "ground", "body2": "rod", "point1": [-1, 0, 0],
             "point2": [0, 0, 0], "spring_coefficient": 50, "free_length": 1, "preload": 6}
        ]  # fmt: skip
        assert rates(tmp_path, data)["joint.hinge.u"] == pytest.approx(6 / 2)

    def test_spring_and_damper_in_one(self, tmp_path: Path) -> None:
        data = slider()
        data["model"]["tsdas"] = [
            {"name": "leg", "type": "TSDA", "body1": "ground", "body2": "rod",
             "point1": [-1, 0, 0], "point2": [0, 0, 0], "spring_coefficient": 50,
             "damping_coefficient": 4, "free_length": 0.9, "visualization": {"type": "SPRING"}}
        ]  # fmt: skip
        result = rates(tmp_path, data, **{"joint.hinge.u": 0.5})
        assert result["joint.hinge.u"] == pytest.approx((-50 * 0.1 - 4 * 0.5) / 2)

    @pytest.mark.parametrize(("body1", "sign"), [("rod", 1), ("ground", -1)])
    @pytest.mark.parametrize("direction", [1, -1])
    def test_a_motor_that_guides(
        self, tmp_path: Path, body1: str, sign: int, direction: int
    ) -> None:
        """+F along its axis on body1, −F on body2; it is the prismatic joint as well."""
        data = slider()
        data["model"]["joints"] = []
        body2 = "ground" if body1 == "rod" else "rod"
        data["model"]["motors"] = [
            {"name": "drive", "type": "LINEAR", "body1": body1, "body2": body2,
             "location": [0, 0, 0], "axis": [3 * direction, 0, 0], "actuation_type": "force",
             "actuation_function": {"type": "CONSTANT", "value": 5}}
        ]  # fmt: skip
        program = Evaluated(model_program(loaded(tmp_path, data)))
        assert program.outputs({})["body.rod.ax"] == pytest.approx(sign * direction * 5 / 2)

    def test_a_motor_that_doubles_a_joint(self, tmp_path: Path) -> None:
        """Same bodies, place and axis: the joint is there once, the torque acts."""
        data = pendulum()
        data["simulation"] = {"gravity": [0, 0, 0]}
        data["model"]["motors"] = [
            {"name": "drive", "type": "ROTATION", "body1": "ground", "body2": "rod",
             "location": [0, 0, 0], "axis": [0, 1, 0], "actuation_type": "FORCE", "guide": "FREE",
             "actuation_function": {"type": "POLYNOMIAL", "coefficients": [3, 0.1, 0]}}
        ]  # fmt: skip
        program = Evaluated(model_program(loaded(tmp_path, data)))
        assert program.rates({}, t=4.0)["joint.hinge.u"] == pytest.approx(-(3 + 0.4) / 5)

    def test_a_controllers_motor_is_an_input(self, tmp_path: Path) -> None:
        data = slider()
        data["model"]["joints"] = []
        data["model"]["motors"] = [
            {"name": "drive", "type": "LINEAR", "guide": "PRISMATIC", "body1": "rod",
             "body2": "ground", "location": [0, 0, 0], "axis": [1, 0, 0],
             "actuation_type": "FORCE", "actuation_function": {"type": "CONTROLLER"}}
        ]  # fmt: skip
        program = model_program(loaded(tmp_path, data))
        assert "joint.drive.effort" in {v.name for v in program.inputs}

    @pytest.mark.parametrize(
        ("function", "value"),
        [
            ({"type": "CONSTANT", "value": 3}, 3.0),
            ({"type": "RAMP", "slope": 2, "intercept": 1}, 2.6),
            ({"type": "POLY", "coefficients": [1, 0, 2]}, 1 + 2 * 0.64),
            ({"type": "SINE", "amplitude": 2, "frequency": 0.5, "phase": 0.1},
             2 * math.sin(2 * math.pi * 0.5 * 0.8 + 0.1)),
            ({"type": "DATA", "data": [[0, 0], [1, 10], [2, 0]]}, 8.0),
        ],
    )  # fmt: skip
    def test_functions_of_the_time(self, tmp_path: Path, function: Data, value: float) -> None:
        data = slider()
        data["model"]["motors"] = [
            {"name": "push", "type": "LINEAR", "guide": "FREE", "body1": "rod", "body2": "ground",
             "location": [0, 0, 0], "axis": [1, 0, 0], "actuation_type": "FORCE",
             "actuation_function": function}
        ]  # fmt: skip
        program = Evaluated(model_program(loaded(tmp_path, data)))
        assert program.rates({}, t=0.8)["joint.hinge.u"] == pytest.approx(value / 2)


class TestStructure:
    def test_a_locked_body(self, tmp_path: Path) -> None:
        """Two rods as one: J + m L² of both about the hinge."""
        data = pendulum()
        data["model"]["bodies"].append(
            {"name": "tip", "location": [0, 0, -3], "mass": 1, "inertia": {"moments": [1, 4, 1]}}
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

    def test_inertia_about_y_in_any_axes(self, tmp_path: Path) -> None:
        """Products count: a tensor in axes turned by 30° about X."""
        data = pendulum()
        data["model"]["bodies"][1] |= {
            "orientation": [0, 0, math.radians(30)],
            "inertia": {"moments": [5, 2, 8], "products": [0, 0, 0.5]},
        }
        y = np.array([0, math.cos(math.radians(30)), -math.sin(math.radians(30))])
        tensor = np.array([[5, 0, 0], [0, 2, 0.5], [0, 0.5, 8]])
        assert loaded(tmp_path, data).bodies["rod"].inertia == pytest.approx(y @ tensor @ y)

    def test_a_body_without_a_joint_floats(self, tmp_path: Path) -> None:
        data = pendulum()
        data["model"]["joints"] = []
        data["model"]["bodies"][1] |= {"orientation": [0, 0.2, 0],
                                       "initial_linear_velocity": [1, 0, 2]}  # fmt: skip
        (joint,) = loaded(tmp_path, data).joints.values()
        assert joint.initial == {
            "x": 0, "z": -1, "theta": pytest.approx(0.2), "vx": 1, "vz": 2, "omega": 0
        }  # fmt: skip

    def test_names_become_names(self, tmp_path: Path) -> None:
        data = pendulum()
        data["model"]["bodies"][1]["name"] = "2nd rod (steel)"
        data["model"]["joints"][0]["body2"] = "2nd rod (steel)"
        assert list(loaded(tmp_path, data).bodies) == ["n2nd_rod_steel"]

    def test_kinds_have_names_of_their_own(self, tmp_path: Path) -> None:
        """Every element named "a": all of them are there."""
        data = slider()
        ends = {"name": "a", "body1": "ground", "body2": "rod"}
        data["model"]["tsdas"] = [
            {**ends, "point1": [1, 0, 0], "point2": [0, 0, 0], "spring_coefficient": 1,
             "damping_coefficient": 2, "free_length": 1}
        ]  # fmt: skip
        data["model"]["rsdas"] = [{**ends, "axis": [0, 1, 0], "damping_coefficient": 3}]
        function = {"type": "DATA", "data": [[0, 1], [1, 2]]}
        data["model"]["body_loads"] = [
            {"name": "a", "type": "FORCE", "body": "rod", "load": [1, 0, 0],
             "modulation_function": function}
        ]  # fmt: skip
        data["model"]["joints"][0]["name"] = "a"
        data["model"]["bodies"].append(
            {"name": "b", "location": [2, 0, 0], "mass": 1, "inertia": {"moments": [1, 1, 1]}}
        )
        data["model"]["motors"] = [
            {"name": "a", "type": "LINEAR", "body1": "b", "body2": "rod", "location": [2, 0, 0],
             "axis": [0, 0, 1], "actuation_type": "FORCE", "actuation_function": function}
        ]  # fmt: skip
        model = loaded(tmp_path, data)
        assert list(model.joints) == ["a", "a_2"]
        assert list(model.loads) == ["a", "a_damper", "a_2", "a_3", "a_4"]
        assert list(model.tables) == ["a", "a_2"]
        assert list(model.points) == ["a_1", "a_2", "a"]


def put(*path: Any, value: Any) -> Callable[[Data], None]:
    def change(data: Data) -> None:
        *parents, last = ("model", *path)
        target: Any = data
        for key in parents:
            target = target.setdefault(key, {}) if isinstance(target, dict) else target[key]
        target[last] = value

    return change


def added(group: str, **entry: Any) -> Callable[[Data], None]:
    return lambda data: data["model"].setdefault(group, []).append({"name": "new", **entry})


ROD, ENDS = ("bodies", 1), {"body1": "ground", "body2": "rod"}
MOTOR = {
    **ENDS,
    "type": "LINEAR",
    "location": [0, 0, 0],
    "axis": [1, 0, 0],
    "actuation_type": "FORCE",
    "actuation_function": {"type": "CONSTANT", "value": 1},
}
TSDA = {**ENDS, "point1": [1, 0, 0], "point2": [0, 0, -1]}


IN_SPACE = {
    "joint": put("joints", 0, "type", value="SPHERICAL"),
    "axis": put("joints", 0, "axis", value=[0, 1, 0.1]),
    "slide": lambda data: data["model"]["joints"][0].update(type="PRISMATIC", axis=[1, 1, 0]),
    "line": added("tsdas", **{**TSDA, "point1": [1, 1, 0]}, damping_coefficient=1),
    "torque": added("body_loads", type="TORQUE", body="rod", load=[1, 7, 0]),
    "force": added("body_loads", type="FORCE", body="rod", load=[0, 1, 0]),
    "motor": added("motors", **{**MOTOR, "guide": "FREE", "body1": "rod", "body2": "ground",
                                "axis": [0, 1, 0]}),
    "gravity": lambda data: data.update(simulation={"gravity": [1, 0, -9.8]}),
    "velocity": lambda data: data["model"].update(joints=[], bodies=[
        {**data["model"]["bodies"][1], "initial_linear_velocity": [0, 1, 0]}]),
    "angular velocity": lambda data: data["model"].update(joints=[], bodies=[
        {**data["model"]["bodies"][1], "initial_angular_velocity": [1, 0, 0]}]),
    "another plane": lambda data: data["model"]["bodies"].append(
        {"name": "far", "location": [0, 3, 0], "mass": 1, "inertia": {"moments": [1, 1, 1]}}),
    "products of inertia": lambda data: data["model"].update(joints=[], bodies=[
        {"name": "rod", "location": [0, 0, 0], "mass": 1,
         "inertia": {"moments": [1, 1, 1], "products": [0.3, 0, 0]}}]),
    "the file's word": lambda data: data.update(dimensions=3),
}  # fmt: skip


@pytest.mark.parametrize("case", IN_SPACE)
def test_what_leaves_the_plane_is_in_space(tmp_path: Path, case: str) -> None:
    data = pendulum()
    assert loaded(tmp_path, data).dimensions == 2
    IN_SPACE[case](data)
    assert loaded(tmp_path, data).dimensions == 3
