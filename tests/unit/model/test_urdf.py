"""Robots from URDF files: accelerations beside Pinocchio's, and what becomes of each element."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.programs import Evaluated

from m4e_fmi.model import Model, Parameter, load_model
from m4e_fmi.multibody import model_program

DATA = Path(__file__).parents[2] / "data" / "robots"
ARM = Path(__file__).parents[3] / "examples" / "arm" / "arm.urdf"


@pytest.mark.verifies(
    "accelerations of robots from URDF files",
    independent="Pinocchio 4.1, its own parser and recursion", tolerance="1e-12",
)  # fmt: skip
@pytest.mark.parametrize("path", [ARM, DATA / "many_joints.urdf"], ids=lambda path: path.stem)
def test_accelerations(path: Path) -> None:
    model = load_model(path)
    undamped = {f"{name}": 0.0 for name in model.parameters if name.endswith("_damping")}
    evaluated = Evaluated(model_program(model))
    table = np.genfromtxt(
        DATA / f"{path.stem}_accelerations.csv", delimiter=",", names=True, deletechars=""
    )
    for row in table:
        given = dict(zip(table.dtype.names or (), map(float, row), strict=True))
        values = {f"joint.{key}": value for key, value in given.items() if key[-1] != "a"}
        rates = evaluated.rates(values | undamped)
        expected = {key[:-2]: value for key, value in given.items() if key[-1] == "a"}
        largest = max(map(abs, expected.values()))
        for joint, value in expected.items():
            assert rates[f"joint.{joint}.u"] == pytest.approx(value, abs=1e-12 * largest)


def written(folder: Path, joint: str, *, mass: str = '<mass value="2"/>') -> Model:
    inertia = '<inertia ixx="1" iyy="1.1" izz="1.2" ixy="0" ixz="0" iyz="0"/>'
    path = folder / "one.urdf"
    path.write_text(
        f'<robot name="one"><link name="world"/><link name="b"><inertial>'
        f'<origin xyz="0.1 0.2 0.3"/>{mass}{inertia}</inertial></link>{joint}</robot>',
        "utf-8",
    )
    return load_model(path)


def joint(kind: str, more: str = "") -> str:
    return (
        f'<joint name="j" type="{kind}"><parent link="world"/><child link="b"/>'
        f'<origin xyz="1 2 3"/><axis xyz="0 0 2"/>{more}</joint>'
    )


def test_a_floating_base_starts_where_it_is_drawn(tmp_path: Path) -> None:
    model = written(tmp_path, joint("floating"))
    start = model.joints["j"].initial
    assert [start[axis] for axis in "xyz"] == pytest.approx([1.1, 2.2, 3.3], rel=1e-15)


def test_a_planar_joint_slides_along_the_axes_of_its_frame(tmp_path: Path) -> None:
    planar = written(tmp_path, joint("planar")).joints["j"]
    assert planar.axis == (0.0, 0.0, 1.0)
    assert planar.direction == (1.0, 0.0, 0.0)


def test_damping_and_friction_are_loads_with_parameters(tmp_path: Path) -> None:
    model = written(tmp_path, joint("continuous", '<dynamics damping="0.5" friction="0.2"/>'))
    assert dict(model.parameters) == {
        "j_damping": Parameter(0.5, "N.m.s/rad"),
        "j_friction": Parameter(0.2, "N.m"),
        "j_creep": Parameter(0.01, "rad/s"),
    }
    found = Evaluated(model_program(model)).outputs({"joint.j.u": 2.0})
    assert found["load.j_damper.effort"] == pytest.approx(-1.0)
    assert found["load.j_friction.effort"] == pytest.approx(-0.2)
