"""Chrono's YAML files in space: attitudes and start values.

Accelerations beside an independent code: tests/verification/test_chrono_in_space.py.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from scipy.spatial.transform import Rotation
from support.programs import Evaluated

from m4e_fmi.model import Model, load_model
from m4e_fmi.multibody import model_program

Data = dict[str, Any]
MOMENTS = {"moments": [1.0, 2.0, 2.5]}


def file(*joints: Data, arm: Data | None = None, **groups: Any) -> Data:
    """A block on a vertical hinge at the origin, and an arm at [2, 3, 1]; at rest, in degrees."""
    bodies: list[Data] = [
        {"name": "base", "location": [0, 0, 0], "fixed": True},
        {"name": "block", "location": [1, 0, 0], "mass": 2, "inertia": MOMENTS},
        {"name": "arm", "location": [2, 3, 1], "mass": 1, "inertia": MOMENTS} | (arm or {}),
    ]
    hinge = {"name": "hinge", "type": "REVOLUTE", "body1": "block", "body2": "base",
             "location": [0, 0, 0], "axis": [0, 0, 2]}  # fmt: skip
    model = {"bodies": bodies, "joints": [hinge, *joints], **groups}
    return {"model": model, "simulation": {"gravity": [0, 0, 0]}}


def loaded(folder: Path, data: Data) -> Model:
    path = folder / "copy.yaml"
    path.write_text(json.dumps(data), encoding="utf-8")
    return load_model(path)


def tip(kind: str, **more: Any) -> Data:
    """A joint of block and arm at [2, 0, 1]."""
    return {"name": "tip", "type": kind, "body1": "block", "body2": "arm", "location": [2, 0, 1],
            **more}  # fmt: skip


def test_a_body_without_a_joint_floats(tmp_path: Path) -> None:
    arm = {"orientation": [30, 20, 10], "initial_linear_velocity": [1, 2, 3],
           "initial_angular_velocity": [0, 0, 4]}  # fmt: skip
    model = loaded(tmp_path, file(arm=arm))
    turn = Rotation.from_euler("ZYX", [30, 20, 10], degrees=True)
    expected = {"x": 2, "y": 3, "z": 1, "phi": math.radians(10), "theta": math.radians(20),
                "psi": math.radians(30), "vx": 1, "vy": 2, "vz": 3}  # fmt: skip
    omega = dict(zip(("omega_x", "omega", "omega_z"), turn.apply([0, 0, 4]), strict=True))
    joint = model.joints["arm_free"]
    assert (joint.type, joint.parent) == ("floating", "ground")
    assert joint.initial == pytest.approx(expected | omega)


@pytest.mark.parametrize("angles", [[25, 90, 40], [25, -90, 40], [0, 90, 0], [170, 91, 5]])
def test_a_pitch_of_ninety_degrees(tmp_path: Path, angles: list[float]) -> None:
    """Roll and yaw are not unique there; the attitude is."""
    start = loaded(tmp_path, file(arm={"orientation": angles})).joints["arm_free"].initial
    got = Rotation.from_euler("ZYX", [start[key] for key in ("psi", "theta", "phi")])
    wanted = Rotation.from_euler("ZYX", angles, degrees=True)
    assert (got.inv() * wanted).magnitude() < 1e-14


class TestAttitudes:
    def test_a_hinge_is_at_the_angle_of_its_childs_frame(self, tmp_path: Path) -> None:
        """While it is at zero the arm leads along its own frame's axes."""
        model = loaded(
            tmp_path, file(tip("REVOLUTE", axis=[0, 0, -1]), arm={"orientation": [90, 0, 0]})
        )
        joint = model.joints["tip"]
        assert joint.initial["q"] == pytest.approx(-math.pi / 2, abs=1e-13)
        assert joint.joint_to_child == (3, 0, 0)
        found = Evaluated(model_program(model)).outputs({})
        assert found["body.arm.psi"] == pytest.approx(math.pi / 2, abs=1e-13)
        assert [found[f"body.arm.{axis}"] for axis in "xyz"] == pytest.approx([2, 3, 1], abs=1e-12)


@pytest.mark.parametrize("first", ["block", "arm"])
def test_start_velocities(tmp_path: Path, first: str) -> None:
    """A block that turns at 2 rad/s about the vertical, and an arm that turns on it at 3 rad/s."""
    ends = {"body1": first, "body2": "arm" if first == "block" else "block"}
    data = file(tip("REVOLUTE", axis=[1, 0, 0], **ends))
    block, arm = data["model"]["bodies"][1:]
    block |= {"initial_angular_velocity": [0, 0, 2], "initial_linear_velocity": [0, 2, 0]}
    # ω = (3, 0, 2); at [2, 0, 1] the block moves with (0, 4, 0), and the arm's CG is [0, 3, 0] off
    arm |= {"initial_angular_velocity": [3, 0, 2], "initial_linear_velocity": [-6, 4, 9]}
    model = loaded(tmp_path, data)
    assert model.joints["hinge"].initial["u"] == pytest.approx(2)
    assert model.joints["tip"].initial["u"] == pytest.approx(3)
    del arm["initial_linear_velocity"]
    found = Evaluated(model_program(loaded(tmp_path, data))).outputs({})
    assert [found[f"body.arm.v{axis}"] for axis in "xyz"] == pytest.approx([-6, 4, 9])
