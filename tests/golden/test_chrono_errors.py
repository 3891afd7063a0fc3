"""Wrong Chrono files in space, and word for word what is said about each: chrono_errors.txt.

Each is a good file with one thing changed. `pytest --update` writes the messages anew.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.golden import check_messages, refused

from m4e_fmi.model import load_model

GOLDEN = Path(__file__).with_name("chrono_errors.txt")
GOOD = """\
chrono-version: "10.0"
simulation: {gravity: [0, 0, -9.81]}
model:
  name: crane
  bodies:
    - {name: base, location: [0, 0, 0], fixed: true}
    - name: tower
      location: [0, 0, 1]
      mass: 2
      inertia: {moments: [1, 1, 1]}
    - name: arm
      location: [1, 0, 2]
      orientation: [0, 0, 30]
      mass: 1
      inertia: {moments: [1, 1, 1], products: [0, 0.1, 0]}
    - name: hook
      location: [2, 0, 1]
      mass: 1
      inertia: {moments: [1, 2, 2.5]}
    - name: buoy
      location: [9, 0, 0]
      mass: 1
      inertia: {moments: [1, 1, 1]}
  joints:
    - {name: swing, type: REVOLUTE, body1: base, body2: tower, location: [0, 0, 0], axis: [0, 0, 1]}
    - name: lift
      type: UNIVERSAL
      body1: arm
      body2: tower
      location: [0, 0, 2]
      axis1: [1, 0, 0]
      axis2: [0, 1, 0]
    - {name: ball, type: SPHERICAL, body1: arm, body2: hook, location: [2, 0, 2]}
  rsdas:
    - {name: coil, body1: base, body2: tower, axis: [0, 0, 1], spring_coefficient: 1, free_angle: 0}
  motors:
    - name: drive
      type: ROTATION
      spindle: FREE
      body1: tower
      body2: base
      location: [0, 0, 0]
      axis: [0, 0, 1]
      actuation_type: FORCE
      actuation_function: {type: CONSTANT, value: 2}
  body_loads:
    - {name: wind, type: FORCE, body: hook, load: [0, 1, 0], point: [0, 0, 0]}
"""
COIL = "name: coil, body1: base, body2: tower, axis: [0, 0, 1]"
CASES = {
    "a joint that Chrono has and we have not": ("type: SPHERICAL", "type: POINT_PLANE"),
    "a joint that Chrono has not": ("type: SPHERICAL", "type: CYLINDRICAL"),
    "a hinge without an axis": (", axis: [0, 0, 1]}\n    - name: lift", "}\n    - name: lift"),
    "a hinge with an axis of no length": (
        "location: [0, 0, 0], axis: [0, 0, 1]}", "location: [0, 0, 0], axis: [0, 0, 0]}"),
    "a universal joint with one axis": ("      axis2: [0, 1, 0]\n", ""),
    "a universal joint with one axis twice": ("axis2: [0, 1, 0]", "axis2: [-2, 0, 0]"),
    "a spring about another axis": (COIL, COIL.replace("[0, 0, 1]", "[0, 1, 1]")),
    "a spring without a hinge": (COIL, COIL.replace("tower", "hook")),
    "a spring with an axis of no length": (COIL, COIL.replace("[0, 0, 1]", "[0, 0, 0]")),
    "a torque between moving bodies": (
        "body1: tower\n      body2: base", "body1: hook\n      body2: tower"),
    "a position": ("actuation_type: FORCE", "actuation_type: POSITION"),
    "a force that stays in space": (
        "load: [0, 1, 0],", "load: [0, 1, 0], local_point: false,"),
    "moments that no body has": ("moments: [1, 2, 2.5]", "moments: [1, 2, 3.5]"),
    "products that no body has": ("products: [0, 0.1, 0]", "products: [0, 3, 0]"),
    "a moment of zero": ("moments: [1, 2, 2.5]", "moments: [0, 2, 2]"),
    "a mass of zero": ("mass: 2", "mass: 0"),
    "an orientation of two angles": ("orientation: [0, 0, 30]", "orientation: [0, 30]"),
    "a quaternion of no length": ("orientation: [0, 0, 30]", "orientation: [0, 0, 0, 0]"),
    "an angular velocity across a hinge": (
        "mass: 2", "mass: 2\n      initial_angular_velocity: [0, 1, 2]"),
    "an angular velocity across a universal joint": (
        "orientation: [0, 0, 30]",
        "orientation: [0, 0, 30]\n      initial_angular_velocity: [0, 0, 2]"),
    "a velocity that a joint does not allow": (
        "mass: 2", "mass: 2\n      initial_linear_velocity: [0, 0, 2]"),
    "a loop": (
        "  rsdas:", "    - {name: tie, type: SPHERICAL, body1: hook, body2: base, "
        "location: [2, 0, 0]}\n  rsdas:"),
    "two dimensions": ("model:\n", "dimensions: 2\nmodel:\n"),
    "a vector of the plane": ("location: [2, 0, 2]", "location: [2, 2]"),
}  # fmt: skip


def test_messages(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    def message(change: tuple[str, str]) -> str:
        return refused(tmp_path / "crane.yaml", GOOD, dict([change]), load_model)

    check_messages(GOLDEN, CASES, message, request)


def test_the_good_file_is_good(tmp_path: Path) -> None:
    path = tmp_path / "crane.yaml"
    path.write_text(GOOD, "utf-8")
    assert load_model(path).dimensions == 3
