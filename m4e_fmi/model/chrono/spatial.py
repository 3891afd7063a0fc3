"""Bodies, joints and start values from Chrono's, of what moves in space.

While all joints are at zero, every body's axes are those of the world. A joint is at zero at the
start, but for a hinge whose child is turned about its axis in the file, and for attitudes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import cycle

import numpy as np

from m4e_fmi.joints import JOINT_TYPES, JointType, attitude
from m4e_fmi.model.chrono.mechanism import SMALL, Joining, Mechanism, crossed, parallel, unit
from m4e_fmi.model.chrono.names import Places
from m4e_fmi.model.chrono.rotation import (
    DIGITS,
    Array,
    Quaternion,
    Vector3,
    angle_about,
    matrix,
    quaternion,
    rounded,
    turned_about,
)
from m4e_fmi.model.chrono.sections import BodySection, InertiaSection, JointSection, ModelSection
from m4e_fmi.model.chrono.tree import Branch
from m4e_fmi.model.elements import GROUND, Joint
from m4e_fmi.model.names import identifier
from m4e_fmi.space import Rotation


@dataclass(frozen=True)
class Pose:
    """A body at the start: CG, velocity and angular velocity (3,) in world axes.

    `turn` (3, 3) leads from our model's body axes to the world's, `axes` (3, 3) from those of
    Chrono's centroidal frame, in which it gives inertias and local loads.
    """

    place: Array = field(default_factory=lambda: np.zeros(3))
    turn: Array = field(default_factory=lambda: np.eye(3))
    axes: Array = field(default_factory=lambda: np.eye(3))
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    omega: Array = field(default_factory=lambda: np.zeros(3))

    def local(self, vector: Array) -> Vector3:
        """`vector` (3,) [1 or m], given in world axes, in body axes."""
        return rounded(self.turn.T @ vector)

    def velocity_at(self, point: Array) -> Array:
        """Velocity (3,) [m/s] of the body's point that is at `point` (3,) [m] of the world."""
        return self.velocity + np.cross(self.omega, point - self.place)


class SpatialMechanism(Mechanism):
    """Bodies and joints in space."""

    dimensions = 3
    kinds = JOINT_TYPES[3]

    def __init__(self, model: ModelSection, places: Places) -> None:
        super().__init__(model, places)
        self.poses: dict[str, Pose] = {GROUND: Pose()}
        self.angles: dict[str, float] = {}  # [rad] of hinges at the start, by their children

    def at(self, body: str, place: Sequence[float]) -> Vector3:
        """A place in the world as a point of a body (or the ground), from its CG [m]."""
        pose = self.poses[self.holder(body)]
        return pose.local(np.array(place) - pose.place)

    def in_world(self, vector: Sequence[float]) -> Vector3:
        """A force or moment in world axes."""
        x, y, z = vector
        return x, y, z

    def in_body(self, body: str, vector: Sequence[float]) -> Vector3:
        """A force or moment in world axes at the start as one in axes of a body."""
        return self.poses[body].local(np.array(vector))

    def centroidal(self, body: str, vector: Sequence[float]) -> Vector3:
        """A vector in axes of Chrono's centroidal frame of a body as one in world axes."""
        return rounded(self.poses[body].axes @ vector)

    def center(self, body: str) -> Vector3:
        """The centre of gravity of a body at the start [m]."""
        return rounded(self.poses[body].place)

    def _inertia(
        self, body: BodySection, inertia: InertiaSection, axes: Quaternion
    ) -> tuple[float, ...]:
        """Moments, and products if there are any; of what `joints` has given a pose."""
        xx, yy, zz = inertia.moments
        xy, xz, yz = inertia.products
        given = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        ours = self.poses[body.name].turn.T @ matrix(axes)
        tensor = ours @ given @ ours.T
        products = np.array([tensor[0, 1], tensor[1, 2], tensor[0, 2]])
        products[np.abs(products) < 10.0**-DIGITS * np.abs(given).max()] = 0.0
        parts = [*np.diag(tensor), *(products if products.any() else ())]
        return tuple(map(float, parts))

    def _place_unknown(self, body: str) -> None:
        self.poses[body] = Pose()

    def _joint(self, branch: Branch[Joining], axes: Quaternion) -> Joint | None:
        body, parent = self.moving[branch.child], self.poses[branch.parent]
        file_axes = matrix(quaternion(body.orientation, degrees=self.model.angle_degrees))
        place = np.array(body.location) + file_axes @ body.com.location
        joining, kind = branch.joining, self.kind(branch.joining)
        lines = self._lines(branch, kind)
        if lines is None:
            self.poses[body.name] = Pose(place, file_axes, matrix(axes))
            return None
        angle, turn = 0.0, file_axes
        if not kind.has_quaternion:
            if kind.axes == ("axis",):  # a hinge
                angle = angle_about(lines[0], file_axes @ parent.turn.T)
            turn = matrix(turned_about(lines[0], angle)) @ parent.turn if angle else parent.turn
        pose, rates = self._started(branch, kind, Pose(place, turn, matrix(axes)), lines)
        self.poses[body.name], self.angles[body.name] = pose, angle
        initial = self._starts(kind, [*_coordinates(kind, pose, angle), *rates])
        if joining is None:
            return Joint(kind.name, identifier(body.name), initial=initial)
        where = np.array(joining.location)
        return Joint(
            kind.name,
            identifier(body.name),
            identifier(branch.parent) if branch.parent != GROUND else GROUND,
            parent.local(where - parent.place),
            pose.local(place - where),
            initial=initial,
            **dict(zip(kind.vectors, map(parent.local, lines), strict=True)),  # pyrefly: ignore[bad-argument-type]
        )

    def _lines(self, branch: Branch[Joining], kind: JointType) -> list[Array] | None:
        """The axes and directions of a joint, of length 1 in the world; None, with a finding."""
        joining = branch.joining
        if joining is None or not kind.vectors:
            return []
        if isinstance(joining, JointSection) and joining.type == "UNIVERSAL":
            return self._cross(joining, branch)
        if joining.axis is None or math.hypot(*joining.axis) == 0:
            message = f"{joining.name!r} has no axis"
            self.places.say(joining, message, ("axis",), "add 'axis: [x, y, z]'")
            return None
        return [np.array(unit(joining.axis))]

    def _cross(self, joint: JointSection, branch: Branch[Joining]) -> list[Array] | None:
        """The axes of a universal joint: that in the parent, and that in the child.

        As Chrono does it, axis1 is fixed in body1 and the part of axis2 at right angles to it in
        body2.
        """
        first, second = joint.axis1 or (0.0, 0.0, 0.0), joint.axis2 or (0.0, 0.0, 0.0)
        for key, axis in (("axis1", first), ("axis2", second)):
            if math.hypot(*axis) == 0:
                message = f"{joint.name!r} has no {key}"
                self.places.say(joint, message, (key,), f"add '{key}: [x, y, z]'")
                return None
        if parallel(first, second):
            message = f"both axes of {joint.name!r} are the same"
            self.places.say(joint, message, ("axis2",), "give one at right angles to axis1")
            return None
        normal = crossed(first, second)
        lines = [np.array(unit(first)), np.array(unit(crossed(normal, first)))]
        return lines if self.holder(joint.body1) == branch.parent else lines[::-1]

    def _started(
        self, branch: Branch[Joining], kind: JointType, pose: Pose, lines: list[Array]
    ) -> tuple[Pose, list[float]]:
        """The pose with its velocities, and the joint's; reports those that it does not allow."""
        body, parent, joining = self.moving[branch.child], self.poses[branch.parent], branch.joining
        slides, turns = _freedoms(kind, lines)
        given, linear = body.initial_angular_velocity, body.initial_linear_velocity
        wanted = pose.axes @ (given or (0.0, 0.0, 0.0)) - parent.omega
        turning, own = _along(turns, wanted)
        if given is not None and _differ(own, wanted):
            x, y, z = pose.axes.T @ (parent.omega + own)
            message = f"the joint makes its angular velocity [{x:.6g}, {y:.6g}, {z:.6g}] rad/s"
            self.places.say(body, message, ("initial_angular_velocity",), "leave it out")
        omega = parent.omega + own
        if joining is None:
            velocity = np.array(linear or (0.0, 0.0, 0.0))
            return replace(pose, velocity=velocity, omega=omega), [*velocity, *omega]
        where = np.array(joining.location)
        carried = parent.velocity_at(where) + np.cross(omega, pose.place - where)
        apart = np.array(linear) - carried if linear is not None else np.zeros(3)
        sliding, own = _along(slides, apart)
        if _differ(own, apart):
            x, y, z = carried + own
            message = f"the joint makes its velocity [{x:.6g}, {y:.6g}, {z:.6g}] m/s"
            self.places.say(body, message, ("initial_linear_velocity",), "leave it out")
        moved = replace(pose, velocity=carried + own, omega=omega)
        return moved, [*omega] if kind.has_quaternion else [*sliding, *turning]


def _freedoms(kind: JointType, lines: list[Array]) -> tuple[list[Array], list[Array]]:
    """Directions in which a joint slides, and axes about which it turns, at the start."""
    if kind.has_quaternion:
        return [], list(np.eye(3))
    pairs = list(zip(kind.coordinates, cycle(lines), strict=False))
    slides = [line for coordinate, line in pairs if not coordinate.is_angle]
    return slides, [line for coordinate, line in pairs if coordinate.is_angle]


def _coordinates(kind: JointType, pose: Pose, angle: float) -> list[float]:
    """Start values of a joint's coordinates and attitude; `angle` [rad] is that of a hinge."""
    if kind.has_quaternion:
        return [*(pose.place if kind.is_free else ()), *attitude(Rotation(pose.turn.tolist()))]
    return [angle if kind.axes == ("axis",) and c.is_angle else 0.0 for c in kind.coordinates]


def _along(lines: list[Array], vector: Array) -> tuple[Array, Array]:
    """The parts of a vector along some directions, and their sum (3,)."""
    if not lines:
        return np.zeros(0), np.zeros(3)
    columns = np.array(lines).T
    parts = np.asarray(np.linalg.lstsq(columns, vector, rcond=None)[0], float)
    return parts, columns @ parts


def _differ(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(a - b) > SMALL * (1 + np.linalg.norm(a)))
