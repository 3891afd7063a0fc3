"""Chrono's YAML of mechanisms in space, with joints and loads of all kinds."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

Data = dict[str, Any]
KINDS = (
    "REVOLUTE", "PRISMATIC", "SPHERICAL", "UNIVERSAL", "LOCK", "SPINDLE", "CYLINDRICAL", "GUIDE",
    "FREE",
)  # fmt: skip
SINE = {"type": "SINE", "amplitude": 3.0, "frequency": 0.7, "phase": 0.4}


def _body(rng: np.random.Generator, name: str, degrees: bool) -> Data:
    """A body somewhere, in frames of any orientation, with a tensor that a body can have."""
    own, com = Rotation.from_rotvec(rng.uniform(-2, 2, (2, 3)))
    places = rng.uniform(-1, 1, (6, 3))
    tensor = np.sum([p @ p * np.eye(3) - np.outer(p, p) for p in places], axis=0)
    return {
        "name": name,
        "location": _vector(rng),
        "orientation": own.as_quat(scalar_first=True).tolist(),
        "mass": float(rng.uniform(1, 3)),
        "com": {
            "location": _vector(rng),
            "orientation": com.as_euler("ZYX", degrees=degrees).tolist(),
        },
        "inertia": {
            "moments": np.diag(tensor).tolist(),
            "products": [tensor[0, 1], tensor[0, 2], tensor[1, 2]],
        },
    }


def _vector(rng: np.random.Generator) -> list[float]:
    return rng.uniform(-1, 1, 3).tolist()


def _ends(first: str, second: str, turned: bool) -> Data:
    first, second = (second, first) if turned else (first, second)
    return {"body1": first, "body2": second}


def spatial_mechanism(kind: str, seed: int) -> Data:
    """A tower on a hinge, an arm on it by a joint of this kind, a hand; with loads of all kinds.

    The tower's frame is turned about its hinge if `seed` is even; if it is odd the second body of
    every pair is the first.
    """
    rng, turned, degrees = np.random.default_rng(seed), bool(seed % 2), seed % 3 > 0
    hinge = {**_ends("base", "tower", turned), "location": _vector(rng), "axis": _vector(rng)}
    tip = {**_ends("tower", "arm", turned), "location": _vector(rng)}
    model: Data = {
        "name": "chain",
        "angle_degrees": degrees,
        "bodies": [
            {"name": "base", "location": _vector(rng), "fixed": True},
            _body(rng, "arm", degrees),
            _body(rng, "tower", degrees),
            _body(rng, "hand", degrees),
        ],
        "joints": [
            {"name": "hinge", "type": "REVOLUTE", **hinge},
            {"name": "wrist", "type": "REVOLUTE", **_ends("arm", "hand", turned),
             "location": _vector(rng), "axis": _vector(rng)},
        ],
        "tsdas": [
            {"name": "leg", **_ends("base", "arm", turned), "point1": _vector(rng),
             "point2": _vector(rng), "spring_coefficient": 7.0, "damping_coefficient": 2.0,
             "free_length": 0.5, "preload": 3.0},
        ],
        "rsdas": [
            {"name": "coil", **_ends("base", "tower", not turned), "axis": hinge["axis"],
             "spring_coefficient": 5.0, "damping_coefficient": 1.5, "free_angle": 0.2,
             "preload": 0.4},
        ],
        "motors": [
            {"name": "drive", "type": "ROTATION", "spindle": "FREE", "actuation_type": "FORCE",
             "actuation_function": SINE, **hinge, "axis": [-2 * c for c in hinge["axis"]]},
            {"name": "wind", "type": "LINEAR", "guide": "FREE", "actuation_type": "FORCE",
             "actuation_function": {"type": "CONSTANT", "value": 2.0}, "body1": "arm",
             "body2": "base", "location": _vector(rng), "axis": _vector(rng)},
            {"name": "stir", "type": "ROTATION", "spindle": "FREE", "actuation_type": "FORCE",
             "actuation_function": SINE, **_ends("arm", "base", turned), "location": _vector(rng),
             "axis": _vector(rng)},
        ],
        "body_loads": [
            {"name": "jet", "type": "FORCE", "body": "arm", "load": _vector(rng),
             "point": _vector(rng), "modulation_function": SINE},
            {"name": "gust", "type": "FORCE", "body": "arm", "load": _vector(rng),
             "point": _vector(rng), "local_load": False},
            {"name": "wheel", "type": "TORQUE", "body": "arm", "load": _vector(rng)},
            {"name": "moment", "type": "TORQUE", "body": "tower", "load": _vector(rng),
             "local_load": False},
        ],
    }  # fmt: skip
    if not turned:
        about = Rotation.from_rotvec(0.7 * np.array(hinge["axis"]))
        model["bodies"][2]["orientation"] = about.as_quat(scalar_first=True).tolist()
    joint = {"name": "tip", **tip, "axis": _vector(rng)}
    motor = {"actuation_type": "FORCE", "actuation_function": SINE}
    match kind:
        case "SPINDLE" | "CYLINDRICAL":
            spindle = "REVOLUTE" if kind == "SPINDLE" else kind
            model["motors"].append(joint | motor | {"type": "ROTATION", "spindle": spindle})
        case "GUIDE":
            model["motors"].append(joint | motor | {"type": "LINEAR"})
        case "UNIVERSAL":
            axes = {"axis1": joint.pop("axis"), "axis2": _vector(rng)}
            model["joints"].append(joint | axes | {"type": kind})
        case "FREE":
            pass
        case _:
            model["joints"].append(joint | {"type": kind})
    return {"model": model, "simulation": {"gravity": [1.0, -2.0, -9.0]}}
