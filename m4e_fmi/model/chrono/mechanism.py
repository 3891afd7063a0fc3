"""Bodies and joints of a Chrono model: what is the same in the plane and in space."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal

from m4e_fmi.joints import JointType
from m4e_fmi.model.chrono.names import Places, fresh
from m4e_fmi.model.chrono.rotation import Quaternion, Vector3, product, quaternion
from m4e_fmi.model.chrono.sections import (
    BodySection,
    InertiaSection,
    JointSection,
    ModelSection,
    MotorSection,
)
from m4e_fmi.model.chrono.tree import Branch, Edge, branches
from m4e_fmi.model.elements import GROUND, Body, Joint, Quantity, Vector
from m4e_fmi.model.names import identifier

SMALL = 1e-6
"""Size that counts as zero beside 1: of directions, of positions in metres, of rates."""
Joining = JointSection | MotorSection
_OURS = {"LOCK": "fixed"}


class LeavesPlaneError(Exception):
    """A model of which something does not stay in the X–Z plane."""


class Mechanism(ABC):
    """Bodies and joints of a Chrono model; findings go to `places`.

    A vector of the file is (x, y, z) in world axes at the start; those of a Model have its
    `dimensions`.
    """

    dimensions: ClassVar[Literal[2, 3]]
    kinds: ClassVar[Mapping[str, JointType]]
    """Our types of joint by the names of `kind_name`."""

    def __init__(self, model: ModelSection, places: Places) -> None:
        self.model, self.places = model, places
        self.moving = {body.name: body for body in model.bodies if not body.fixed}
        self.joint_of: dict[str, str] = {}
        self.branches, self.loops = branches(self.moving, self._edges())

    @abstractmethod
    def _inertia(self, body: BodySection, inertia: InertiaSection, axes: Quaternion) -> object:
        """Inertia of a body whose tensor is given in `axes`, as a `Body` has it."""

    @abstractmethod
    def _joint(self, branch: Branch[Joining], axes: Quaternion) -> Joint | None:
        """The joint of a branch; its child's pose at the start becomes known."""

    @abstractmethod
    def _place_unknown(self, body: str) -> None:
        """Let the pose of a body whose orientation is wrong be any."""

    @abstractmethod
    def at(self, body: str, place: Sequence[float]) -> Vector:
        """A place in the world [m] as a point of a body (or the ground), from its CG."""

    @abstractmethod
    def in_world(self, vector: Sequence[float]) -> tuple[float, ...]:
        """A force in world axes as the model has it."""

    @abstractmethod
    def in_body(self, body: str, vector: Sequence[float]) -> tuple[float, ...]:
        """A force in world axes at the start as one in axes of a body."""

    @abstractmethod
    def centroidal(self, body: str, vector: Sequence[float]) -> Vector3:
        """A vector in axes of Chrono's centroidal frame of a body as one in world axes."""

    @abstractmethod
    def center(self, body: str) -> Vector3:
        """The centre of gravity of a body at the start [m]."""

    def holder(self, body: str) -> str:
        """The moving body of this name, or the ground."""
        return body if body in self.moving else GROUND

    def kind(self, joining: Joining | None) -> JointType:
        """The type of our joint; LeavesPlaneError for one that a plane does not have."""
        found = self.kinds.get(kind_name(joining))
        if found is None:
            raise LeavesPlaneError
        return found

    def _edges(self) -> list[Edge[Joining]]:
        motors = [m for m in self.model.motors if guides(m)]
        return [
            Edge(joining, (self.holder(joining.body1), self.holder(joining.body2)))
            for joining in (*self.model.joints, *motors)
        ]

    def bodies(self) -> dict[str, Body]:
        """The bodies that move, by name; incomplete ones are reported and left out."""
        result = {}
        for body in self.moving.values():
            if body.mass is None or body.inertia is None:
                missing = "mass" if body.mass is None else "inertia"
                self.places.say(body, f"body {body.name!r} moves, but has no {missing}", (),
                                f"add '{missing}: …', or 'fixed: true'")  # fmt: skip
                continue
            axes = self._axes(body)
            if axes is not None:
                inertia = self._inertia(body, body.inertia, axes)
                result[identifier(body.name)] = Body(
                    body.mass,
                    inertia,
                    f"Body {body.name}",
                )
        return result

    def _axes(self, body: BodySection) -> Quaternion | None:
        """Axes of the centroidal frame; None, with a finding, if the file gives none."""
        degrees = self.model.angle_degrees
        try:
            own = quaternion(body.orientation, degrees=degrees)
            return product(own, quaternion(body.com.orientation, degrees=degrees))
        except ValueError as error:
            self.places.say(body, str(error), ("orientation",), "no turn is [1, 0, 0, 0]")
            return None

    def joints(self) -> dict[str, Joint]:
        """A joint for every body; also finds the start poses, parents first."""
        for edge in self.loops:
            self._report_loop(edge)
        result: dict[str, Joint] = {}
        for branch in self.branches:
            said = branch.joining.name if branch.joining else f"{branch.child}_free"
            name = fresh(identifier(said), result)
            axes = self._axes(self.moving[branch.child])
            joint = None
            if axes is None:
                self._place_unknown(branch.child)
            else:
                joint = self._joint(branch, axes)
            if joint is not None:
                self.joint_of[branch.child] = name
                result[name] = joint
        return result

    def _report_loop(self, edge: Edge[Joining]) -> None:
        joining = edge.joining
        if isinstance(joining, MotorSection) and self.branch_of(joining):
            return
        message = f"{joining.name!r} closes a loop of bodies, which cannot be represented"
        remedy = "cut the loop: remove it, or put a stiff spring and damper in its place"
        self.places.say(joining, message, (), remedy)

    def branch_of(self, motor: MotorSection) -> Branch[Joining] | None:
        """The branch along whose coordinate a motor acts: its own, or one with the same freedom."""
        for branch in self.branches:
            joining = branch.joining
            if joining is motor:
                return branch
            if (
                guides(motor)
                and joining is not None
                and self._moves_along(branch, motor)
                and (motor.type == "LINEAR" or on_line(joining, motor.location))
            ):
                return branch
        return None

    def _moves_along(self, branch: Branch[Joining], motor: MotorSection) -> bool:
        """True of a branch of the motor's bodies with the motor's freedom."""
        slides = motor.type == "LINEAR"
        name = kind_name(branch.joining)
        fits = name == "cylindrical" or name == ("prismatic" if slides else "revolute")
        ends = {self.holder(motor.body1), self.holder(motor.body2)}
        return fits and self.is_along(branch, ends, motor.axis)

    def is_along(self, branch: Branch[Joining], ends: set[str], axis: Vector3) -> bool:
        """True of a branch that joins two bodies along or about this one axis."""
        own = (branch.joining and branch.joining.axis) or (0.0, 0.0, 0.0)
        return {branch.child, branch.parent} == ends and parallel(own, axis)

    def _starts(self, kind: JointType, values: Sequence[float]) -> dict[str, Quantity]:
        """Start values of a joint: its coordinates, then its velocities."""
        return dict(zip(kind.start_keys, map(float, values), strict=True))


def guides(motor: MotorSection) -> bool:
    """True of a motor that is a joint as well."""
    return (motor.guide if motor.type == "LINEAR" else motor.spindle) != "FREE"


def kind_name(joining: Joining | None) -> str:
    """The name of our type of joint; floating where nothing joins."""
    if joining is None:
        return "floating"
    if not isinstance(joining, MotorSection):
        return _OURS.get(joining.type, joining.type.lower())
    return "prismatic" if joining.type == "LINEAR" else joining.spindle.lower()


def on_line(joining: Joining, place: Sequence[float]) -> bool:
    """True of a place [m] on the line of a joint's axis."""
    apart = [a - b for a, b in zip(place, joining.location, strict=True)]
    return math.hypot(*crossed(unit(joining.axis), apart)) < SMALL


def unit(axis: Vector3 | None) -> Vector3:
    """A direction of length 1; of an axis that was checked."""
    assert axis is not None
    length = math.hypot(*axis)
    return axis[0] / length, axis[1] / length, axis[2] / length


def crossed(a: Sequence[float], b: Sequence[float]) -> Vector3:
    """a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def parallel(a: Sequence[float], b: Sequence[float]) -> bool:
    """True if two directions, neither of them zero, agree but for their sense."""
    lengths = math.hypot(*a) * math.hypot(*b)
    return lengths > 0 and math.hypot(*crossed(a, b)) <= SMALL * lengths
