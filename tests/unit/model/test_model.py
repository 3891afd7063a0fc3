"""Models in Python: their programs, mistakes; files beside them: test_loads.py."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.model import (
    Body,
    BodyForce,
    Joint,
    Model,
    Parameter,
    Point,
    TensionSpring,
)
from m4e_fmi.multibody import model_program


def crane() -> Model:
    """A trolley with a beam."""
    return Model(
        name="crane",
        parameters={"m": Parameter(2.0, "t"), "L": Parameter(3.5, "m")},
        bodies={"trolley": Body("0.5*m", 1.0), "beam": Body("m", "m*L**2/12")},
        joints={
            "rail": Joint("prismatic", "trolley", direction=(1.0, 0.0)),
            "hinge": Joint("revolute", "beam", "trolley", joint_to_child=(0.0, "-L/2")),
        },
        points={"tip": Point("beam", (0.0, "-L/2")), "wall": Point("ground", (10.0, 0.0))},
        loads={"rope": TensionSpring(("wall", "tip"), "100*m", "L"), "lift": BodyForce("beam")},
    )


WRONG: Any = "3"
MISTAKES: dict[str, dict[str, Any]] = {
    "crane: bodies.beam.mass: 'mm' is not declared": {"bodies": {"beam": Body("mm", 1.0)}},
    "loads.lift.body: unknown body 'bem'\n      did you mean 'beam'?": {
        "loads": {"lift": BodyForce("bem")}
    },
    "joints.hinge.type: unknown type 'weld'": {
        "joints": {"hinge": Joint(cast(Any, "weld"), "beam")}
    },
    "joint_to_child: expected [x, z], got 1 entry": {
        "joints": {"hinge": Joint("revolute", "beam", joint_to_child=cast(Any, (1.0,)))}
    },
    "parent_to_joint: expected [x, z], got 3.0": {
        "joints": {"hinge": Joint("floating", "beam", parent_to_joint=cast(Any, 3.0))}
    },
    "loads.rope.points: expected two points, got 1": {
        "loads": {"rope": TensionSpring(cast(Any, ("tip",)), 1.0, 1.0)}
    },
    "parameters.L.value: expected a finite number, got '3'": {
        "parameters": {"L": Parameter(WRONG, "m")}
    },
}


@pytest.mark.parametrize("message", MISTAKES)
def test_mistakes_in_python(message: str) -> None:
    """Checks that in a file are made by its form; all are told at once."""
    model = crane()
    changed: dict[str, Any] = {
        name: {**getattr(model, name), **one} for name, one in MISTAKES[message].items()
    }
    points = {**model.points, "far": Point("nobody", (0.0, 0.0))}
    with pytest.raises(InputError) as caught:
        replace(model, points=points, **changed)
    assert message in str(caught.value)
    assert "points.far.body: unknown body 'nobody'" in str(caught.value)


def test_numbers_of_numpy_are_numbers() -> None:
    three: Any = np.int64(3)
    body, origin = Body(three, np.float64(2.0)), cast(Any, [0, 0])
    joint = Joint("floating", "a", joint_to_child=origin)
    model = Model(name="a", bodies={"a": body}, joints={"j": joint})
    assert len(model_program(model).states) == 6
