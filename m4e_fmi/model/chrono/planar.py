"""Bodies, joints and loads of Chrono in the X–Z plane, projected from those in space."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from m4e_fmi.joints import JOINT_TYPES, REVOLUTE, JointType
from m4e_fmi.model.chrono.loads import Loads, times
from m4e_fmi.model.chrono.mechanism import (
    SMALL,
    Branch,
    Joining,
    Mechanism,
    Pose,
    kind_name,
    parallel,
    starts,
    tensor_of,
)
from m4e_fmi.model.chrono.rotation import Array, Quaternion, Vector3, matrix, turned_about
from m4e_fmi.model.chrono.sections import (
    BodyLoadSection,
    BodySection,
    InertiaSection,
    MotorSection,
    RsdaSection,
)
from m4e_fmi.model.elements import GROUND, Joint, Quantity, Vector, identifier
from m4e_fmi.model.loads import BodyForce, TorsionDamper, TorsionSpring

Y = (0.0, 1.0, 0.0)
KINDS = {"cylindrical": REVOLUTE} | JOINT_TYPES[2]
"""Joints of the plane by the names of those in space."""


class LeavesPlaneError(Exception):
    """A model of which something does not stay in the X–Z plane."""


class PlanarMechanism(Mechanism):
    """Bodies and joints in the plane; LeavesPlaneError where something leaves it."""

    dimensions = 2
    plane: float | None = None
    """y of the centre of gravity of the first body [m], and of all points."""

    def kind(self, joining: Joining | None) -> JointType:
        """The type of our joint in space, of those that the plane has as well."""
        found = KINDS.get(kind_name(joining))
        if found is None:
            raise LeavesPlaneError
        return JOINT_TYPES[3][found.name]

    def at(self, body: str, place: Sequence[float]) -> Vector:
        """A place in the plane of the bodies as a point of a body (or the ground) [m]."""
        self._check_plane(place[1])
        return _projected(super().at(body, place))

    def in_world(self, vector: Sequence[float]) -> tuple[float, ...]:
        """A force in world axes, (x, z)."""
        if abs(vector[1]) > SMALL * math.hypot(*vector):
            raise LeavesPlaneError
        return _projected(vector)

    def in_body(self, body: str, vector: Sequence[float]) -> tuple[float, ...]:
        """A force in world axes at the start as one in axes of a body, (x, z)."""
        self.in_world(vector)
        return _projected(super().in_body(body, vector))

    def _inertia(self, body: BodySection, inertia: InertiaSection, axes: Quaternion) -> float:
        turn = matrix(axes)
        xy, about_y, yz = (turn @ tensor_of(inertia) @ turn.T)[1].tolist()
        floats = any(b.child == body.name and b.joining is None for b in self.branches)
        if floats and max(abs(xy), abs(yz)) > SMALL * about_y:
            raise LeavesPlaneError
        return about_y

    def _turn(self, orientation: Quaternion) -> Array:
        """The part (3, 3) that turns about Y."""
        return matrix(turned_about(Y, 2 * math.atan2(orientation[2], orientation[0])))

    def _lines(self, branch: Branch, kind: JointType) -> list[Array] | None:
        """The direction of a joint, or +Y or −Y."""
        lines = super()._lines(branch, kind)
        if not lines:
            return lines
        if kind.has_direction:
            self.in_world(lines[0].tolist())
            return lines
        return [np.array([0.0, _about_y(lines[0].tolist()), 0.0])]

    def _joint(self, branch: Branch, axes: Quaternion) -> Joint | None:
        made, pose = super()._joint(branch, axes), self.poses[branch.child]
        self._check_plane(pose.place[1])
        if max(abs(pose.velocity[1]), abs(pose.omega[0]), abs(pose.omega[2])) > SMALL:
            raise LeavesPlaneError
        if made is None:
            return None
        kind = KINDS[made.type]
        angle, omega = angle_of(pose), float(pose.omega[1])
        initial = made.initial
        if branch.joining is None:
            values = (*_projected(pose.place), angle, *_projected(pose.velocity), omega)
            initial = starts(kind, values)
        elif kind.rotates:
            initial = starts(kind, (angle, omega))
        return Joint(
            kind.name,
            made.child,
            made.parent,
            _projected(made.parent_to_joint),
            _projected(made.joint_to_child),
            _projected(made.direction) if made.direction else None,
            initial=initial,
        )

    def _check_plane(self, y: float) -> None:
        """Centres of gravity and points lie in one plane; that of the first body."""
        self.plane = y if self.plane is None else self.plane
        if abs(y - self.plane) > SMALL:
            raise LeavesPlaneError


class PlanarLoads(Loads):
    """Loads in the plane; LeavesPlaneError where one leads out of it."""

    def _twisted(self, rsda: RsdaSection, name: str, free: float) -> None:
        sense, ends = _about_y(rsda.axis), (self._name(rsda.body1), self._name(rsda.body2))
        stiffness, damping = rsda.spring_coefficient, rsda.damping_coefficient
        poses = [self.mechanism.poses[self.mechanism.holder(b)] for b in (rsda.body1, rsda.body2)]
        if stiffness or not damping:
            angle = angle_of(poses[1]) - angle_of(poses[0]) + sense * free
            self._add(name, TorsionSpring(ends, stiffness or 0.0, angle))
        if damping:
            self._add(f"{name}_damper" if stiffness else name, TorsionDamper(ends, damping))

    def _torque(self, motor: MotorSection, effort: Quantity) -> None:
        sense = _about_y(motor.axis)
        ends = [(motor.body1, sense), (motor.body2, -sense)]
        moving = [(b, factor) for b, factor in ends if self.mechanism.holder(b) != GROUND]
        for suffix, (body, factor) in zip(("", "_back"), moving, strict=False):
            name = identifier(motor.name) + suffix
            self._add(name, BodyForce(self._name(body), moment=times(factor, effort)))

    def _body_torque(self, load: BodyLoadSection, vector: Vector3, scale: Quantity) -> None:
        if max(abs(vector[0]), abs(vector[2])) > SMALL * math.hypot(*vector):
            raise LeavesPlaneError
        name = identifier(load.name)
        self._add(name, BodyForce(self._name(load.body), moment=times(vector[1], scale)))


def _about_y(axis: Sequence[float]) -> float:
    """1 or −1, as an axis leads to +Y or −Y."""
    if not parallel(axis, Y):
        raise LeavesPlaneError
    return math.copysign(1.0, axis[1])


def angle_of(pose: Pose) -> float:
    """The angle [rad] of a body that is turned about Y, in (−π, π]."""
    return math.atan2(pose.turn[0, 2], pose.turn[0, 0])


def _projected(vector: object) -> tuple[float, float]:
    """(x, z) of a vector."""
    x, *_, z = np.array(vector, float).tolist()
    return x, z
