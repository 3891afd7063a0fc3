"""Joints in space, to be drawn: where they are, and the lines about and along which they move."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from m4e_fmi.multibody.topology import TreeLink

GROUND = -1
Triple = tuple[float, float, float]
Numbers = Callable[[object, str], Triple]
"""A vector of an element by its name, in numbers."""


@dataclass(frozen=True)
class Spot:
    """A point of a body, in body axes from its centre of gravity [m]; of the ground if −1."""

    body: int
    at: Triple

    def moved(self, direction: Triple, distance: float) -> Spot:
        """The point at a distance [m] along a direction."""
        x, y, z = (a + distance * d for a, d in zip(self.at, direction, strict=True))
        return Spot(self.body, (x, y, z))


@dataclass(frozen=True)
class Axis:
    """A line through `spot` along `direction`, of length 1: the joint slides along it, or turns."""

    spot: Spot
    direction: Triple
    slides: bool

    def ends(self, reach: float) -> tuple[Spot, Spot]:
        """Two points of the line, `reach` [m] from its middle."""
        return self.spot.moved(self.direction, -reach), self.spot.moved(self.direction, reach)


@dataclass(frozen=True)
class Hinge:
    """A joint: its points of the child and of the parent, its axes, its symbol."""

    spot: Spot
    base: Spot
    axes: tuple[Axis, ...]
    symbol: str


def hinge_of(link: TreeLink, number: int, numbers: Numbers) -> Hinge:
    """The joint of a link, whose child has this number."""
    to_child = numbers(link.joint, "joint_to_child")
    spot = Spot(number, (-to_child[0], -to_child[1], -to_child[2]))
    base = Spot(link.parent, numbers(link.joint, "parent_to_joint"))
    axes = tuple(_axes(link, spot, base, numbers))
    return Hinge(spot, base, axes, link.joint_type.symbol)


def _axes(link: TreeLink, spot: Spot, base: Spot, numbers: Numbers) -> Iterator[Axis]:
    """Directions are fixed in the parent, and so is the first of two axes.

    What turns about one axis only has it in the same place in parent and child.
    """
    kind = link.joint_type
    if kind.has_direction:
        yield Axis(base, _unit(numbers(link.joint, "direction")), slides=True)
    for name in kind.axes:
        here = base if name == "axis" and len(kind.axes) > 1 else spot
        yield Axis(here, _unit(numbers(link.joint, name)), slides=False)


def _unit(vector: Triple) -> Triple:
    x, y, z = (part / math.hypot(*vector) for part in vector)
    return x, y, z
