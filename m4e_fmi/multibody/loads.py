"""Loads as forces on points, over any scalar, and their potentials."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from m4e_fmi.model import (
    BodyForce,
    PointForce,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.elements import Load, quantity, vector
from m4e_fmi.model.expression import Values
from m4e_fmi.multibody.kinematics import Frame, Place
from m4e_fmi.multibody.planar import Pair, dot, scaled, subtracted
from m4e_fmi.program import sqrt


@dataclass(frozen=True)
class Action:
    """A force [N] in world axes at a named point, or at a body's CG with a moment [N·m]."""

    force: Pair
    point: str = ""
    body: str = ""
    moment: Any = 0


Bodies = Callable[[str], Frame]
"""The frame of a body by its name, ground included."""


def actions(
    load: Load, bodies: Bodies, points: Mapping[str, Place], values: Values
) -> list[Action]:
    """The forces that `load` exerts; `values` holds the parameters and the time t."""
    if isinstance(load, BodyForce):
        x, z = (part.evaluate(values) for part in vector(load, "force"))
        return [Action((x, z), body=load.body, moment=quantity(load, "moment").evaluate(values))]
    if isinstance(load, PointForce):
        x, z = (part.evaluate(values) for part in vector(load, "force"))
        return [Action((x, z), point=load.point)]
    if isinstance(load, TorsionSpring | TorsionDamper):
        first, second = (bodies(name) for name in load.bodies)
        if isinstance(load, TorsionSpring):
            twist = second.angle - first.angle - quantity(load, "angle").evaluate(values)
            torque = quantity(load, "stiffness").evaluate(values) * twist
        else:
            rate = second.omega - first.omega
            torque = quantity(load, "damping").evaluate(values) * rate
        ends = zip(load.bodies, (torque, -torque), strict=True)
        return [Action((0, 0), body=body, moment=part) for body, part in ends]
    start, end = (points[name] for name in load.points)
    length, direction = _line(start, end)
    if isinstance(load, TensionSpring):
        stretch = length - quantity(load, "length").evaluate(values)
        tension = quantity(load, "stiffness").evaluate(values) * stretch
    else:
        relative = subtracted(end.velocity, start.velocity)
        tension = quantity(load, "damping").evaluate(values) * dot(relative, direction)
    pull = scaled(tension, direction)
    return [Action(pull, point=load.points[0]), Action(scaled(-1, pull), point=load.points[1])]


def potential(load: Load, bodies: Bodies, points: Mapping[str, Place], values: Values) -> Any:
    """Potential energy [J] of a load: ½ k e² of a spring with extension or twist e, else 0."""
    if isinstance(load, TensionSpring):
        length, _ = _line(*(points[name] for name in load.points))
        extension = length - quantity(load, "length").evaluate(values)
    elif isinstance(load, TorsionSpring):
        first, second = (bodies(name) for name in load.bodies)
        extension = second.angle - first.angle - quantity(load, "angle").evaluate(values)
    else:
        return 0
    return quantity(load, "stiffness").evaluate(values) * extension * extension / 2


def _line(start: Place, end: Place) -> tuple[Any, Pair]:
    """Distance of two points, and the unit vector from the first to the second."""
    line = subtracted(end.position, start.position)
    length = sqrt(dot(line, line))
    return length, (line[0] / length, line[1] / length)
