"""Bodies, joints and start values from Chrono's, of what moves in the X–Z plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.joints import JOINT_TYPES, REVOLUTE, JointType
from m4e_fmi.model.chrono.mechanism import (
    SMALL,
    Joining,
    LeavesPlaneError,
    Mechanism,
    parallel,
    unit,
)
from m4e_fmi.model.chrono.names import Places
from m4e_fmi.model.chrono.rotation import (
    Pair,
    Quaternion,
    Vector3,
    angle_about_y,
    inertia_about_y,
    quaternion,
    rotated,
    turned_back,
)
from m4e_fmi.model.chrono.sections import BodySection, InertiaSection, ModelSection
from m4e_fmi.model.chrono.tree import Branch
from m4e_fmi.model.elements import GROUND, Joint
from m4e_fmi.model.names import identifier


@dataclass(frozen=True)
class Pose:
    """A body at the start: CG and velocity in the world, and `angle` of our model's body frame.

    `axes` are those of Chrono's centroidal frame, in which it gives inertias and local loads.
    """

    place: Vector3 = (0.0, 0.0, 0.0)
    angle: float = 0.0
    axes: Quaternion = (1.0, 0.0, 0.0, 0.0)
    velocity: Pair = (0.0, 0.0)
    omega: float = 0.0

    def local(self, point: Sequence[float]) -> Pair:
        """A world point as (x, z) from the CG in body axes [m]."""
        return turned_back([a - b for a, b in zip(point, self.place, strict=True)], self.angle)

    def velocity_at(self, point: Sequence[float]) -> Pair:
        """Velocity of the body's point that is at a world point [m/s]."""
        x, z = point[0] - self.place[0], point[2] - self.place[2]
        return self.velocity[0] + self.omega * z, self.velocity[1] - self.omega * x


class PlanarMechanism(Mechanism):
    """Bodies and joints in the plane; LeavesPlaneError where something leaves it."""

    dimensions = 2
    kinds = JOINT_TYPES[2] | {"cylindrical": REVOLUTE}

    def __init__(self, model: ModelSection, places: Places) -> None:
        super().__init__(model, places)
        self.poses: dict[str, Pose] = {GROUND: Pose()}
        self.plane: float | None = None

    def at(self, body: str, place: Sequence[float]) -> Pair:
        """A place in the plane of the bodies as a point of a body (or the ground) [m]."""
        self._check_plane(place[1])
        return self.poses[self.holder(body)].local(place)

    def in_world(self, vector: Sequence[float]) -> Pair:
        """A force in world axes, (x, z)."""
        if abs(vector[1]) > SMALL * math.hypot(*vector):
            raise LeavesPlaneError
        return vector[0], vector[2]

    def in_body(self, body: str, vector: Sequence[float]) -> Pair:
        """A force in world axes at the start as one in axes of a body, (x, z)."""
        self.in_world(vector)
        return turned_back(vector, self.poses[body].angle)

    def centroidal(self, body: str, vector: Sequence[float]) -> Vector3:
        """A vector in axes of Chrono's centroidal frame of a body as one in world axes."""
        return rotated(self.poses[body].axes, vector)

    def center(self, body: str) -> Vector3:
        """The centre of gravity of a body at the start [m]."""
        return self.poses[body].place

    def _inertia(self, body: BodySection, inertia: InertiaSection, axes: Quaternion) -> float:
        xy, about_y, yz = inertia_about_y(axes, inertia.moments, inertia.products)
        floats = any(b.child == body.name and b.joining is None for b in self.branches)
        if floats and max(abs(xy), abs(yz)) > SMALL * about_y:
            raise LeavesPlaneError
        return about_y

    def _place_unknown(self, body: str) -> None:
        self.poses[body] = Pose()

    def _joint(self, branch: Branch[Joining], axes: Quaternion) -> Joint | None:
        body, parent = self.moving[branch.child], self.poses[branch.parent]
        turn = quaternion(body.orientation, degrees=self.model.angle_degrees)
        offset = rotated(turn, body.com.location)
        place = tuple(a + b for a, b in zip(body.location, offset, strict=True))
        self._check_plane(place[1])
        joining = branch.joining
        kind = self.kind(joining)
        angle = angle_about_y(turn) if kind.rotates else parent.angle
        pose = Pose(place, angle, axes)  # pyrefly: ignore[bad-argument-type]
        moved = self._started(body, pose, branch, kind)
        self.poses[branch.child] = moved
        if joining is None:
            start = (place[0], place[2], angle, *moved.velocity, moved.omega)
            return Joint(kind.name, identifier(body.name), initial=self._starts(kind, start))
        if not self._has_axis(joining, kind):
            return None
        direction, start = None, (angle, moved.omega) if kind.rotates else ()
        if kind.has_direction:
            direction = turned_back(unit(joining.axis), parent.angle)
            start = (0.0, self._sliding(body, moved, branch, joining))
        return Joint(
            kind.name,
            identifier(body.name),
            identifier(branch.parent) if branch.parent != GROUND else GROUND,
            parent.local(joining.location),
            tuple(0.0 - c for c in pose.local(joining.location)),
            direction,
            initial=self._starts(kind, start),
        )

    def _check_plane(self, y: float) -> None:
        """Centres of gravity and points lie in one plane; that of the first body."""
        self.plane = y if self.plane is None else self.plane
        if abs(y - self.plane) > SMALL:
            raise LeavesPlaneError

    def _has_axis(self, joining: Joining, kind: JointType) -> bool:
        if not kind.coordinates:
            return True
        axis = joining.axis
        if axis is None or math.hypot(*axis) == 0:
            remedy = "add 'axis: [0, 1, 0]'" if kind.rotates else "add 'axis: [x, 0, z]'"
            self.places.say(joining, f"{joining.name!r} has no axis", ("axis",), remedy)
            return False
        if kind.rotates and not parallel(axis, (0, 1, 0)):
            raise LeavesPlaneError
        if kind.has_direction:
            self.in_world(axis)
        return True

    def _started(
        self, body: BodySection, pose: Pose, branch: Branch[Joining], kind: JointType
    ) -> Pose:
        """The pose with its velocities; reports those that the joint does not allow."""
        parent = self.poses[branch.parent]
        local = body.initial_angular_velocity or (0.0, 0.0, 0.0)
        wx, omega, wz = rotated(pose.axes, local)
        if max(abs(wx), abs(wz)) > SMALL:
            raise LeavesPlaneError
        if not kind.rotates:
            given = body.initial_angular_velocity is not None
            if given and abs(omega - parent.omega) > SMALL * (1 + abs(omega)):
                message = f"it turns with its parent, at {parent.omega:g} rad/s, not {omega:g}"
                self.places.say(body, message, ("initial_angular_velocity",), "leave it out")
            omega = parent.omega
        linear = body.initial_linear_velocity
        if linear is not None and abs(linear[1]) > SMALL:
            raise LeavesPlaneError
        free = Pose(pose.place, pose.angle, pose.axes, omega=omega)
        if branch.joining is None or kind.has_direction:
            x, z = (linear[0], linear[2]) if linear else self._carried(free, parent, pose.place)
            return Pose(pose.place, pose.angle, pose.axes, (x, z), omega)
        x, z = self._carried(free, parent, branch.joining.location)
        if linear is not None and math.hypot(linear[0] - x, linear[2] - z) > SMALL * (
            1 + math.hypot(x, z)
        ):
            message = f"the joint makes its velocity [{x:.6g}, 0, {z:.6g}] m/s"
            self.places.say(body, message, ("initial_linear_velocity",), "leave it out")
        return Pose(pose.place, pose.angle, pose.axes, (x, z), omega)

    @staticmethod
    def _carried(body: Pose, parent: Pose, point: Sequence[float]) -> Pair:
        """Velocity of the body's CG if the body's point at `point` moves as the parent's there."""
        (px, pz), (bx, bz) = parent.velocity_at(point), body.velocity_at(point)
        return px - bx, pz - bz

    def _sliding(
        self, body: BodySection, pose: Pose, branch: Branch[Joining], joining: Joining
    ) -> float:
        """Start velocity along a prismatic joint; reports a velocity across it."""
        x, _, z = unit(joining.axis)
        px, pz = self.poses[branch.parent].velocity_at(pose.place)
        dx, dz = pose.velocity[0] - px, pose.velocity[1] - pz
        along, across = dx * x + dz * z, dx * z - dz * x
        if abs(across) > SMALL * (1 + abs(along)):
            message = f"its velocity across the joint's axis is {across:.6g} m/s"
            self.places.say(body, message, ("initial_linear_velocity",), "leave it out")
        return along
