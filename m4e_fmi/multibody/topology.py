"""The tree of bodies, in the numbering that the equations use."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from m4e_fmi.joints import JOINT_TYPES, JointType
from m4e_fmi.model import GROUND, Model
from m4e_fmi.model.elements import Joint
from m4e_fmi.shown import listing
from m4e_fmi.space import PLANE, SPACE

RELATIVE_ANGLE = "Phi"
"""Letter of a coordinate that could be an absolute angle and is a relative one."""


@dataclass(frozen=True)
class Link:
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

    links: tuple[Link, ...]
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
    links: list[Link] = []
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
            Link(
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
