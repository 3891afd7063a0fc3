"""Motion of a model's bodies, over any scalar: their frames, and what expressions know of a state.

Every body has an origin, which is where its joint holds it, such as the hinge of a revolute body or
the centre of gravity of a floating one. `joints` says how its frame follows from the parent's, so
the cost grows with the number of bodies. Loads are computed from scalars by name: parameters, the
time, tables, and how joints, bodies, points move, by the names of the FMU's variables.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from m4e_fmi.joints import ATTITUDE, GROUND_FRAME, TURNING, Frame, Mount, Place, attitude
from m4e_fmi.model import GROUND, Model, Table
from m4e_fmi.model.elements import vector
from m4e_fmi.model.expression import NOTHING, Expression, Values
from m4e_fmi.multibody.topology import Link, Topology
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import AXES, Vector, Y, minus

Lookup = Callable[[str, Table, AnyScalar], AnyScalar]
"""The value of a table by its name, itself, and the time."""


def frames(
    tree: Topology, q: Sequence[AnyScalar], u: Sequence[AnyScalar], values: Values
) -> list[Frame]:
    """The frame of every link for coordinates `q` (n,), velocities `u` (n,) in m, rad, per s.

    `values` are those of the parameters by name.
    """
    result: list[Frame] = []
    for link in tree.links:
        mount = Mount(
            parent=result[link.parent] if link.parent >= 0 else GROUND_FRAME,
            q=[q[k] for k in link.coordinates],
            u=[u[k] for k in link.speeds],
            vector=partial(evaluated, link, values),
            is_relative=link.is_relative,
        )
        result.append(link.joint_type.frame(mount))
    return result


def evaluated(link: Link, values: Values, field: str) -> Vector:
    """A vector of a link's joint, such as ``joint_to_child`` [m]."""
    return in_space(vector(link.joint, field), values)


def in_space(parts: Sequence[Expression], values: Values) -> Vector:
    """A vector (x, z) or (x, y, z) of the author's; what he wrote as 0 is always zero."""
    found = [0 if part == NOTHING else part.evaluate(values) for part in parts]
    x, y, z = found if len(found) == len(AXES) else (found[0], 0, found[1])
    return x, y, z


@dataclass(frozen=True)
class State:
    """A model's q, u and what follows from them."""

    model: Model
    tree: Topology
    q: Sequence[AnyScalar]
    u: Sequence[AnyScalar]
    frames: Sequence[Frame]
    points: Mapping[str, Place]

    def frame(self, body: str) -> Frame:
        """Frame of a body, or of the ground."""
        return GROUND_FRAME if body == GROUND else self.frames[self.tree.index(body)]

    def link(self, joint: str) -> Link:
        """The link that a joint holds."""
        return self.tree.links[self.tree.index(self.model.joints[joint].child)]

    def joint(self, name: str, number: int = 0) -> tuple[AnyScalar, AnyScalar]:
        """Angle or displacement of a joint's child against its parent, and its rate.

        Of the joint's coordinate of that `number`.
        """
        link = self.link(name)
        k, j = link.coordinates[number], link.speeds[number]
        if link.is_relative or link.parent < 0:
            return self.q[k], self.u[j]
        parent = self.frames[link.parent]
        return minus(self.q[k], parent.angle), minus(self.u[j], parent.omega[Y])

    def variable(self, name: str) -> AnyScalar:
        """A variable of the motion: joint.<name>.q, body.<name>.vx, point.<name>.z, …"""
        kind, element, variable = name.split(".")
        if kind == "joint":
            link = self.link(element)
            own = link.joint_type.positions, link.joint_type.velocities
            states = dict(zip(own[0], link.coordinates, strict=True))
            rates = dict(zip(own[1], link.speeds, strict=True))
            return self.q[states[variable]] if variable in states else self.u[rates[variable]]
        if kind == "body" and variable in ATTITUDE:
            return attitude(self.frame(element).rotation)[ATTITUDE.index(variable)]
        if kind == "body" and variable in TURNING:
            return self.frame(element).omega[TURNING.index(variable)]
        place = self.points[element] if kind == "point" else self.frame(element)
        vector = place.velocity if variable.startswith("v") else place.position
        return vector[AXES.index(variable[-1])]


class Motion(Values):
    """Values for the expressions of loads; variables of the motion are looked up when needed."""

    def __init__(self, values: Values, state: State, lookup: Lookup) -> None:
        super().__init__(values, number=values.number)
        self.state = state
        self.lookup = lookup

    def __missing__(self, name: str) -> AnyScalar:
        tables = self.state.model.tables
        if name in tables:
            value = self.lookup(name, tables[name], self["t"])
        else:
            value = self.state.variable(name)
        self[name] = value
        return value

    def with_(self, **more: AnyScalar) -> Motion:
        """The same with more names."""
        other = copy.copy(self)
        other.update(more)
        return other
