"""Chrono's YAML of a system in the paper's lists, at any pose and with any velocities.

Poses and velocities come from support/maximal_coordinates.py, so that nothing of m4e_fmi is used.
JSON is YAML.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from support.maximal_coordinates import MaximalCoordinates, _point

FRAMES = ("cg", "origin", "turned")
"""Where a body's frame is: at its CG; at the world's origin; at its CG with axes turned about X."""


def chrono_model(
    lists: Mapping[str, Any], *, frames: str = "cg", degrees: bool = False
) -> dict[str, Any]:
    """The data of a Chrono file with the poses and velocities of `ic`, springs and dampers."""
    system = MaximalCoordinates(lists)
    q = system.start_positions()
    v = system.start_velocities(q)
    poses, rates = q.reshape(-1, 3), v.reshape(-1, 3)
    bodies: list[dict[str, Any]] = [{"name": "base", "location": [1, 0, 2], "fixed": True}]
    for k, ((x, z, theta), (vx, vz, omega)) in enumerate(zip(poses, rates, strict=True)):
        inertia = float(np.ravel(lists["J0"])[k])
        body: dict[str, Any] = {
            "name": f"body {k + 1}",
            "mass": float(np.ravel(lists["m0"])[k]),
            "inertia": {"moments": [9.0, inertia, 9.0]},
            "initial_linear_velocity": [vx, 0.0, vz],
            "initial_angular_velocity": [0.0, omega, 0.0],
        }
        angle = math.degrees(theta) if degrees else theta
        if frames == "origin":
            c, s = math.cos(theta), math.sin(theta)
            body |= {"location": [0, 0, 0], "orientation": [0, angle, 0],
                     "com": {"location": [x * c - z * s, 0, x * s + z * c]}}  # fmt: skip
        elif frames == "turned":  # a quarter turn about X first: then Y is the body's -Z
            quarter, half = math.sqrt(0.5), theta / 2
            body |= {"location": [x, 0, z], "orientation": [
                quarter * math.cos(half), quarter * math.cos(half),
                quarter * math.sin(half), -quarter * math.sin(half)]}  # fmt: skip
            body["inertia"] = {"moments": [9.0, 9.0, inertia]}
            body["initial_angular_velocity"] = [0.0, 0.0, -omega]
        else:
            body |= {"location": [x, 0, z], "orientation": [0, angle, 0]}
        bodies.append(body)
    model: dict[str, Any] = {"name": "copy", "bodies": bodies}
    if not degrees:  # which are the default
        model["angle_degrees"] = False
    model["joints"] = [
        joint for row in range(len(lists["joints"])) if (joint := _joint(lists, system, poses, row))
    ]
    model |= _loads(lists, system, poses, degrees)
    data = {"chrono-version": "10.0", "model": model}
    return data | {"simulation": {"gravity": [0, 0, -float(lists["g"])]}}


def _world(system: MaximalCoordinates, poses: np.ndarray, body: int, at: Any) -> list[float]:
    if body == 0:
        x, z = system.origin + at
    else:
        px, pz, theta = poses[body - 1]
        c, s = math.cos(theta), math.sin(theta)
        x, z = px + c * at[0] + s * at[1], pz + c * at[1] - s * at[0]
    return [float(x), 0.0, float(z)]


def _name(body: int) -> str:
    return f"body {body}" if body else "base"


def _joint(
    lists: Mapping[str, Any], system: MaximalCoordinates, poses: np.ndarray, row: int
) -> dict[str, Any] | None:
    parent, child = lists["joints"][row]
    kind = lists["types"][row]
    if kind == "F":
        return None
    _, to_child = system.arms[row]
    ends = [_name(parent), _name(child)]
    if row % 2:  # Chrono does not care which of the two comes first
        ends.reverse()
    joint = {"name": f"joint-{row}", "body1": ends[0], "body2": ends[1],
             "location": _world(system, poses, child, -to_child)}  # fmt: skip
    if kind == "R":
        return joint | {"type": "revolute", "axis": [0, -2, 0]}
    dx, dz = lists["prismatic_direction"][row]
    theta = poses[parent - 1][2] if parent else 0.0
    c, s = math.cos(theta), math.sin(theta)
    return joint | {"type": "PRISMATIC", "axis": [c * dx + s * dz, 0, c * dz - s * dx]}


def _loads(
    lists: Mapping[str, Any], system: MaximalCoordinates, poses: np.ndarray, degrees: bool
) -> dict[str, Any]:
    """Springs and dampers; every second rotational one about -Y."""
    force, points = lists.get("Force", {}), lists.get("Initial_Points", {})
    tsdas, rsdas = [], []
    for k, (ends, (length, stiffness)) in enumerate(force.get("TensionSpring", [])):
        tsdas.append(_tsda(system, poses, points, f"spring {k}", ends)
                     | {"spring_coefficient": stiffness, "free_length": length})  # fmt: skip
    for k, (ends, damping) in enumerate(force.get("TensionDamper", [])):
        tsdas.append(_tsda(system, poses, points, f"damper {k}", ends)
                     | {"damping_coefficient": damping})  # fmt: skip
    for k, (ends, (rest, stiffness)) in enumerate(force.get("TorsionSpring", [])):
        angles = [poses[body - 1][2] if body else 0.0 for body in ends]
        sense = -1 if k % 2 else 1
        free = sense * (rest - (angles[1] - angles[0]))  # Chrono's angle is 0 at the start
        rsdas.append({
            "name": f"coil {k}", "body1": _name(ends[0]), "body2": _name(ends[1]),
            "axis": [0, sense, 0], "spring_coefficient": stiffness,
            "free_angle": math.degrees(free) if degrees else free,
        })  # fmt: skip
    for k, (ends, damping) in enumerate(force.get("TorsionDamper", [])):
        rsdas.append({"name": f"oil {k}", "body1": _name(ends[0]), "body2": _name(ends[1]),
                      "axis": [0, 1, 0], "damping_coefficient": damping})  # fmt: skip
    return {"tsdas": tsdas, "rsdas": rsdas}


def _tsda(
    system: MaximalCoordinates, poses: np.ndarray, points: Any, name: str, ends: Any
) -> dict[str, Any]:
    result: dict[str, Any] = {"name": name}
    for k, end in enumerate(ends, start=1):
        body, at = _point(end, points)
        result |= {f"body{k}": _name(body), f"point{k}": _world(system, poses, body, at)}
    return result
