"""The tree of bodies, in the numbering that the equations use, and its motion over any scalar.

Every body has an origin, which is where its joint holds it, such as the hinge of a revolute body or
the centre of gravity of a floating one. `joints` says how its frame follows from the parent's, so
the cost grows with the number of bodies. Loads are computed from scalars by name: parameters, the
time, tables, and how joints, bodies, points move, by the names of the FMU's variables.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

from m4e_fmi.joints import (
    ATTITUDE,
    GROUND_FRAME,
    JOINT_TYPES,
    TURNING,
    Frame,
    JointType,
    Mount,
    PointMotion,
    attitude,
)
from m4e_fmi.model import GROUND, Model, Table
from m4e_fmi.model.elements import Joint, vector
from m4e_fmi.model.expression import NOTHING, Expression, Values
from m4e_fmi.program import AnyScalar
from m4e_fmi.shown import listing
from m4e_fmi.space import AXES, PLANE, SPACE, Vector, Y, minus

RELATIVE_ANGLE = "Phi"
"""Letter of a coordinate that could be an absolute angle and is a relative one."""
Lookup = Callable[[str, Table, AnyScalar], AnyScalar]
"""The value of a table by its name, itself, and the time."""


@dataclass(frozen=True)
class TreeLink:
    """One body with the joint that holds it.

    `number` counts bodies from 1, in the order of their distance from the ground; `parent` is the
    index of the parent's link, −1 for the ground. `coordinates` are the indices in q of the joint's
    coordinates, `speeds` those in u of its velocities; `angles` are those of the coordinates whose
    sum is the body's absolute angle, none if it never rotates. `is_relative`: the coordinates that
    rotate the parent rotate this body.
    """

    number: int
    body: str
    joint_name: str
    joint: Joint
    joint_type: JointType
    parent: int
    coordinates: tuple[int, ...]
    speeds: tuple[int, ...]
    angles: tuple[int, ...]
    is_relative: bool


@dataclass(frozen=True)
class Topology:
    """The links of a model, parents first, and the names of its coordinates and velocities.

    `components` are those that motions (v, ω) of the model's bodies have.
    """

    links: tuple[TreeLink, ...]
    coordinate_names: tuple[str, ...]
    velocity_names: tuple[str, ...]
    components: tuple[int, ...] = PLANE

    @cached_property
    def acceleration_names(self) -> tuple[str, ...]:
        """Names of the accelerations, as ThetaDD_1."""
        return tuple(_rate_name(name) for name in self.velocity_names)

    @property
    def is_planar(self) -> bool:
        """True of a model in the X–Z plane."""
        return self.components == PLANE

    def index(self, body: str) -> int:
        """Index of a body's link; −1 for the ground."""
        return self._indices.get(body, -1)

    @cached_property
    def _indices(self) -> dict[str, int]:
        return {link.body: k for k, link in enumerate(self.links)}

    def __repr__(self) -> str:
        bodies = [f"{link.number} {link.body}" for link in self.links]
        return listing("Topology", bodies=bodies, coordinates=self.coordinate_names)


def topology(model: Model) -> Topology:
    """Number the bodies by distance from the ground, equal ones in the order of the model."""
    holders = {joint.child: name for name, joint in model.joints.items()}
    distance = _distances(model)
    order = sorted(model.bodies, key=distance.__getitem__)  # stable: ties keep their order
    number_of = {body: number for number, body in enumerate(order, start=1)}
    links: list[TreeLink] = []
    names: list[str] = []
    velocities: list[str] = []
    for body, number in number_of.items():
        joint = model.joints[holders[body]]
        parent = number_of.get(joint.parent, 0) - 1
        first, first_speed = len(names), len(velocities)
        joint_type = JOINT_TYPES[model.dimensions][joint.type]
        chosen = joint.coordinate == "relative"
        own = [
            f"{RELATIVE_ANGLE if chosen and c.is_angle else c.letter}_{number}"
            for c in joint_type.coordinates
        ]
        names += own
        velocities += map(_rate_name, own)
        if joint_type.has_quaternion:
            names += [f"E{k}_{number}" for k in range(4)]
            velocities += [f"{letter}_{number}" for letter in ("OmegaX", "OmegaY", "OmegaZ")]
        coordinates = tuple(range(first, len(names)))
        speeds = tuple(range(first_speed, len(velocities)))
        is_relative = chosen or not joint_type.frees_rotation
        angles = links[parent].angles if is_relative and parent >= 0 else ()
        if any(c.is_angle for c in joint_type.coordinates):
            angles = (*angles, coordinates[-1])
        links.append(
            TreeLink(
                number, body, holders[body], joint, joint_type, parent, coordinates, speeds, angles,
                is_relative,
            )
        )  # fmt: skip
    components = PLANE if model.dimensions == 2 else SPACE
    return Topology(tuple(links), tuple(names), tuple(velocities), components)


def _distances(model: Model) -> dict[str, int]:
    """Number of joints between the ground and each body."""
    children: dict[str, list[str]] = {}
    for joint in model.joints.values():
        children.setdefault(joint.parent, []).append(joint.child)
    distance = {GROUND: 0}
    reached = [GROUND]
    for body in reached:  # grows while it is walked through
        for child in children.get(body, ()):
            distance[child] = distance[body] + 1
            reached.append(child)
    return distance


def _rate_name(name: str) -> str:
    letter, number = name.split("_")
    return f"{letter}D_{number}"


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


def evaluated(link: TreeLink, values: Values, field: str) -> Vector:
    """A vector of a link's joint, such as ``joint_to_child`` [m]."""
    return in_space(vector(link.joint, field), values)


def in_space(parts: Sequence[Expression], values: Values) -> Vector:
    """A vector (x, z) or (x, y, z) of the author's; what he wrote as 0 is always zero."""
    found = [0 if part == NOTHING else part.evaluate(values) for part in parts]
    x, y, z = found if len(found) == len(AXES) else (found[0], 0, found[1])
    return x, y, z


@dataclass(frozen=True)
class ModelState:
    """A model's q, u and what follows from them."""

    model: Model
    tree: Topology
    q: Sequence[AnyScalar]
    u: Sequence[AnyScalar]
    frames: Sequence[Frame]
    points: Mapping[str, PointMotion]

    def frame(self, body: str) -> Frame:
        """Frame of a body, or of the ground."""
        return GROUND_FRAME if body == GROUND else self.frames[self.tree.index(body)]

    def link(self, joint: str) -> TreeLink:
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


class MotionValues(Values):
    """Values for the expressions of loads; variables of the motion are looked up when needed."""

    def __init__(self, values: Values, state: ModelState, lookup: Lookup) -> None:
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

    def with_(self, **more: AnyScalar) -> MotionValues:
        """The same with more names."""
        other = copy.copy(self)
        other.update(more)
        return other
