"""Chrono's files in space: joints and loads beside Newton's and Euler's equations of all bodies.

The other side (support/chrono_space.py) reads the same data by itself, and writes constraints and
forces as Chrono's sources do.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.chrono_mechanisms import KINDS, Data, spatial_mechanism
from support.chrono_space import ChronoInSpace, State
from support.programs import Evaluated

from m4e_fmi.model import Model, load_model
from m4e_fmi.multibody import model_program

TIME = 0.6
"""[s]: no function of the time is zero then."""


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
    tolerance="1e-11",
)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", KINDS)
def test_accelerations(tmp_path: Path, kind: str, seed: int) -> None:
    """At the start and away from it, where axes that are fixed in bodies have turned with them.

    Two ill-conditioned systems (6 equations for a body, and multipliers) are solved in doubles.
    """
    data = spatial_mechanism(kind, seed)
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
            assert parts(found, name, *ACCELERATION) == pytest.approx(expected, abs=1e-11 * largest)
