"""Chrono's files in space: joints and loads beside Newton's and Euler's equations of all bodies.

The other side (support/chrono_space.py) reads the same data by itself, and writes constraints and
forces as Chrono's sources do.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.chrono_space import ChronoInSpace, State
from support.programs import Evaluated

from m4e_fmi.model import Model, load_model
from m4e_fmi.multibody import model_program

Data = dict[str, Any]
KINDS = ("REVOLUTE", "PRISMATIC", "SPHERICAL", "UNIVERSAL", "LOCK", "CYLINDRICAL", "FREE")
SINE = {"type": "SINE", "amplitude": 3.0, "frequency": 0.7, "phase": 0.4}
TIME = 0.6
"""[s]: no function of the time is zero then."""


def body(rng: np.random.Generator, name: str, degrees: bool) -> Data:
    """A body somewhere, in frames of any orientation, with a tensor that a body can have."""
    turn = Rotation.from_rotvec(rng.uniform(-2, 2, 3))
    places = rng.uniform(-1, 1, (6, 3))
    tensor = np.sum([p @ p * np.eye(3) - np.outer(p, p) for p in places], axis=0)
    return {
        "name": name,
        "location": vector(rng),
        "orientation": turn.as_quat(scalar_first=True).tolist(),
        "mass": float(rng.uniform(1, 3)),
        "com": {
            "location": vector(rng),
            "orientation": turn.inv().as_euler("ZYX", degrees=degrees).tolist(),
        },
        "inertia": {
            "moments": np.diag(tensor).tolist(),
            "products": [tensor[0, 1], tensor[0, 2], tensor[1, 2]],
        },
    }


def vector(rng: np.random.Generator) -> list[float]:
    return rng.uniform(-1, 1, 3).tolist()


def ends(first: str, second: str, turned: bool) -> Data:
    first, second = (second, first) if turned else (first, second)
    return {"body1": first, "body2": second}


def mechanism(kind: str, seed: int) -> Data:
    """A tower on a hinge, and an arm on it by the joint in question; with loads of all kinds."""
    rng, turned, degrees = np.random.default_rng(seed), bool(seed % 2), seed % 3 > 0
    hinge = {**ends("base", "tower", turned), "location": vector(rng), "axis": vector(rng)}
    tip = {**ends("tower", "arm", turned), "location": vector(rng)}
    model: Data = {
        "name": "chain",
        "angle_degrees": degrees,
        "bodies": [
            {"name": "base", "location": vector(rng), "fixed": True},
            body(rng, "arm", degrees),
            body(rng, "tower", degrees),
        ],
        "joints": [{"name": "hinge", "type": "REVOLUTE", **hinge}],
        "tsdas": [
            {"name": "leg", **ends("base", "arm", turned), "point1": vector(rng),
             "point2": vector(rng), "spring_coefficient": 7.0, "damping_coefficient": 2.0,
             "free_length": 0.5, "preload": 3.0},
        ],
        "rsdas": [
            {"name": "coil", **ends("base", "tower", not turned), "axis": hinge["axis"],
             "spring_coefficient": 5.0, "damping_coefficient": 1.5, "free_angle": 0.2,
             "preload": 0.4},
        ],
        "motors": [
            {"name": "drive", "type": "ROTATION", "spindle": "FREE", "actuation_type": "FORCE",
             "actuation_function": SINE, **hinge, "axis": [-2 * c for c in hinge["axis"]]},
            {"name": "wind", "type": "LINEAR", "guide": "FREE", "actuation_type": "FORCE",
             "actuation_function": {"type": "CONSTANT", "value": 2.0}, "body1": "arm",
             "body2": "base", "location": vector(rng), "axis": vector(rng)},
            {"name": "stir", "type": "ROTATION", "spindle": "FREE", "actuation_type": "FORCE",
             "actuation_function": SINE, **ends("arm", "base", turned), "location": vector(rng),
             "axis": vector(rng)},
        ],
        "body_loads": [
            {"name": "jet", "type": "FORCE", "body": "arm", "load": vector(rng),
             "point": vector(rng), "modulation_function": SINE},
            {"name": "gust", "type": "FORCE", "body": "arm", "load": vector(rng),
             "point": vector(rng), "local_load": False},
            {"name": "wheel", "type": "TORQUE", "body": "arm", "load": vector(rng)},
            {"name": "moment", "type": "TORQUE", "body": "tower", "load": vector(rng),
             "local_load": False},
        ],
    }  # fmt: skip
    joint = {"name": "tip", "type": kind, **tip, "axis": vector(rng)}
    if kind == "CYLINDRICAL":
        motor = joint | {"type": "ROTATION", "spindle": kind, "actuation_type": "FORCE"}
        model["motors"].append(motor | {"actuation_function": SINE})
    elif kind == "UNIVERSAL":
        del joint["axis"]
        model["joints"].append(joint | {"axis1": vector(rng), "axis2": vector(rng)})
    elif kind != "FREE":
        model["joints"].append(joint)
    return {"model": model, "simulation": {"gravity": [1.0, -2.0, -9.0]}}


def loaded(folder: Path, data: Data) -> Model:
    path = folder / "copy.yaml"
    path.write_text(json.dumps(data), encoding="utf-8")
    return load_model(path)


def attitude(outputs: dict[str, float], name: str) -> np.ndarray:
    angles = [outputs[f"body.{name}.{key}"] for key in ("psi", "theta", "phi")]
    return Rotation.from_euler("ZYX", angles).as_matrix()


def parts(outputs: dict[str, float], name: str, *keys: str) -> np.ndarray:
    return np.array([outputs[f"body.{name}.{key}"] for key in keys])


PLACE, VELOCITY, OMEGA = ("x", "y", "z"), ("vx", "vy", "vz"), ("omega_x", "omega", "omega_z")
ACCELERATION = ("ax", "ay", "az", "alpha_x", "alpha", "alpha_z")


def states(
    found: dict[str, float], start: dict[str, float], reference: ChronoInSpace
) -> dict[str, State]:
    """Chrono's centroidal frames where the bodies are now."""
    return {
        name: State(
            parts(found, name, *PLACE),
            attitude(found, name) @ attitude(start, name).T @ own.axes,
            parts(found, name, *VELOCITY),
            parts(found, name, *OMEGA),
        )
        for name, own in reference.start.items()
    }


@pytest.mark.verifies(
    "Chrono's files in space: joints, springs, motors and loads, in frames of any orientation",
    independent="Newton's and Euler's equations of all bodies with Chrono's constraints",
    tolerance="1e-10",
)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", KINDS)
def test_accelerations(tmp_path: Path, kind: str, seed: int) -> None:
    """At the start and away from it, where axes that are fixed in bodies have turned with them.

    Two ill-conditioned systems (6 equations for a body, and multipliers) are solved in doubles.
    """
    data = mechanism(kind, seed)
    model, reference = loaded(tmp_path, data), ChronoInSpace(data)
    assert model.dimensions == 3
    program = Evaluated(model_program(model))
    rest, rng = {s.name: s.start for s in program.program.states}, np.random.default_rng(seed)
    start = rest | program.outputs({})
    for reach in (0.0, 0.4):
        values = {name: value + reach * rng.uniform(-1, 1) for name, value in rest.items()}
        found = values | program.outputs(values, t=TIME)
        now = states(found, start, reference)
        assert np.abs(reference.residuals(now)).max() < 1e-11
        wanted = reference.accelerations(now, TIME)
        largest = max(np.abs(a).max() for a in wanted.values())
        for name, expected in wanted.items():
            assert parts(found, name, *ACCELERATION) == pytest.approx(expected, abs=1e-10 * largest)
