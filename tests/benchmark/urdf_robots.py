"""Robots from URDF files beside Pinocchio, which reads them with a parser of its own.

`python -m benchmark.urdf_robots FILE …` prints, for each robot, the largest difference of
accelerations in random states, relative to the largest acceleration.
"""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi import InputError
from m4e_fmi.model import Model, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.runtime.engine import Engine

STATES = 5
GRAVITY = 9.80665


def difference(path: Path) -> tuple[int, float]:
    """Degrees of freedom, and the largest relative difference of accelerations."""
    pin: Any = importlib.import_module("pinocchio")
    theirs = pin.buildModelFromUrdf(str(path))
    theirs.gravity.linear = np.array([0, 0, -GRAVITY])
    data = theirs.createData()
    ours = replace(load_model(path), loads={}, parameters={})
    engine = Engine(model_program(ours, inputs=()), outputs=())
    names = [v.name for v in engine.program.states]
    worst, r = 0.0, np.random.default_rng(1)
    for _ in range(STATES):
        x = r.uniform(-1, 1, len(names))
        found = dict(zip(names, engine.rates(0.0, x), strict=True))
        values = dict(zip(names, x, strict=True))
        q, v, expected, own = pin.neutral(theirs), np.zeros(theirs.nv), [], []
        places = _places(theirs, ours)
        for name, joint in places.items():
            angle, v[joint.idx_v] = values[f"{name}.q"], values[f"{name}.u"]
            around = joint.nq == 2
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                (np.cos(angle), np.sin(angle)) if around else angle
            )
        a = pin.aba(theirs, data, q, v, np.zeros(theirs.nv))
        for name, joint in places.items():
            expected.append(a[joint.idx_v])
            own.append(found[f"{name}.u"])
        worst = max(worst, np.abs(np.subtract(expected, own)).max() / np.abs(expected).max())
    return theirs.nv, worst


def _places(theirs: Any, ours: Model) -> dict[str, Any]:
    """Pinocchio's joints by the names of ours."""
    from m4e_fmi.model.chrono.names import identifier

    found = {f"joint.{identifier(name)}": theirs.joints[k] for k, name in enumerate(theirs.names)}
    moving = [f"joint.{name}" for name in ours.joints]
    others = set(moving) ^ (set(found) - {"joint.universe"})
    assert not others, others
    return {name: found[name] for name in moving}


def main() -> None:
    """Print a line for each file."""
    for text in sys.argv[1:]:
        path = Path(text)
        try:
            size, worst = difference(path)
        except InputError as error:
            print(f"{path.name:40} {error}")
            continue
        print(f"{path.name:40} {size:3} degrees of freedom  {worst:.1e}")


if __name__ == "__main__":
    main()
