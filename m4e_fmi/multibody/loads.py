"""Loads as forces on points, over any scalar, and their potentials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from m4e_fmi.model import BodyForce, Model, PointForce, TensionDamper, TensionSpring
from m4e_fmi.model.elements import Load, quantity, vector
from m4e_fmi.model.expression import Values
from m4e_fmi.multibody.kinematics import Arm
from m4e_fmi.multibody.planar import Pair, added, dot, scaled
from m4e_fmi.program import sqrt


@dataclass(frozen=True)
class Action:
    """A force [N] in world axes at a named point, or at a body's CG with a moment [N·m]."""

    force: Pair
    point: str = ""
    body: str = ""
    moment: Any = 0


def actions(load: Load, points: Mapping[str, Arm], values: Values) -> list[Action]:
    """The forces that `load` exerts, for points in motion and named `values` (parameters, t)."""
    if isinstance(load, BodyForce):
        x, z = (part.evaluate(values) for part in vector(load, "force"))
        return [Action((x, z), body=load.body, moment=quantity(load, "moment").evaluate(values))]
    if isinstance(load, PointForce):
        x, z = (part.evaluate(values) for part in vector(load, "force"))
        return [Action((x, z), point=load.point)]
    first, second = (points[name] for name in load.points)
    line = added(second.position, scaled(-1, first.position))
    length = sqrt(dot(line, line))
    direction = (line[0] / length, line[1] / length)
    if isinstance(load, TensionSpring):
        stretch = length - quantity(load, "length").evaluate(values)
        tension = quantity(load, "stiffness").evaluate(values) * stretch
    else:
        assert isinstance(load, TensionDamper)
        relative = added(second.velocity, scaled(-1, first.velocity))
        tension = quantity(load, "damping").evaluate(values) * dot(relative, direction)
    pull = scaled(tension, direction)
    return [Action(pull, point=load.points[0]), Action(scaled(-1, pull), point=load.points[1])]


def potential(load: Load, points: Mapping[str, Arm], values: Values) -> Any:
    """Potential energy [J] of a load: ½ k (l − l₀)² of a spring, 0 of all others."""
    if not isinstance(load, TensionSpring):
        return 0
    first, second = (points[name] for name in load.points)
    line = added(second.position, scaled(-1, first.position))
    stretch = sqrt(dot(line, line)) - quantity(load, "length").evaluate(values)
    return quantity(load, "stiffness").evaluate(values) * stretch * stretch / 2


def load_points(model: Model) -> set[str]:
    """Names of the points that loads refer to."""
    names: set[str] = set()
    for load in model.loads.values():
        if isinstance(load, PointForce):
            names.add(load.point)
        elif isinstance(load, TensionSpring | TensionDamper):
            names.update(load.points)
    return names
