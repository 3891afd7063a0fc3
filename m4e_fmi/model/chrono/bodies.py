"""Bodies, joints and start values from Chrono's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from m4e_fmi.joints import FIXED, FLOATING, PRISMATIC, REVOLUTE, JointType
from m4e_fmi.model.chrono.names import Places, fresh, identifier
from m4e_fmi.model.chrono.rotation import (
    Pair,
    Quaternion,
    Vector3,
    angle_about_y,
    inertia_about_y,
    product,
    quaternion,
    rotated,
    turned_back,
)
from m4e_fmi.model.chrono.sections import BodySection, JointSection, ModelSection, MotorSection
from m4e_fmi.model.chrono.tree import Branch, Edge, branches
from m4e_fmi.model.elements import GROUND, Body, Joint, Quantity

SMALL = 1e-6
"""Size that counts as zero beside 1: of directions, of positions in metres, of rates."""
TYPES = {"REVOLUTE": REVOLUTE, "PRISMATIC": PRISMATIC, "LOCK": FIXED}
Joining = JointSection | MotorSection


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


class Mechanism:
    """Bodies and joints of a Chrono model; findings go to `places`."""

    def __init__(self, model: ModelSection, places: Places) -> None:
        self.model, self.places = model, places
        self.moving = {body.name: body for body in model.bodies if not body.fixed}
        self.poses: dict[str, Pose] = {GROUND: Pose()}
        self.plane: float | None = None
        self.joint_of: dict[str, str] = {}
        self.branches, self.loops = branches(self.moving, self._edges())

    def holder(self, body: str) -> str:
        """The moving body of this name, or the ground."""
        return body if body in self.moving else GROUND

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
            if axes is None:
                continue
            xy, inertia, yz = inertia_about_y(axes, body.inertia.moments, body.inertia.products)
            floats = any(b.child == body.name and b.joining is None for b in self.branches)
            if floats and max(abs(xy), abs(yz)) > SMALL * inertia:
                self.places.say(
                    body, "free, with these products of inertia, it would leave the X–Z plane",
                    ("inertia",), "give products [0, I_xz, 0] in axes along X and Z",
                )  # fmt: skip
            result[identifier(body.name)] = Body(body.mass, inertia, f"Body {body.name}")
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
            joint = self._joint(branch)
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
                and joint_kind(joining) == joint_kind(motor)
                and {branch.child, branch.parent}
                == set(map(self.holder, (motor.body1, motor.body2)))
                and parallel(joining.axis or (0, 0, 0), motor.axis)
                and (motor.type == "LINEAR" or math.dist(joining.location, motor.location) < SMALL)
            ):
                return branch
        return None

    def _joint(self, branch: Branch[Joining]) -> Joint | None:
        body, parent = self.moving[branch.child], self.poses[branch.parent]
        axes = self._axes(body)
        if axes is None:
            self.poses[branch.child] = Pose()
            return None
        turn = quaternion(body.orientation, degrees=self.model.angle_degrees)
        offset = rotated(turn, body.com.location)
        place = tuple(a + b for a, b in zip(body.location, offset, strict=True))
        self._report_plane(body, place[1])
        joining = branch.joining
        kind = joint_kind(joining)
        angle = angle_about_y(turn) if kind.rotates else parent.angle
        pose = Pose(place, angle, axes)  # type: ignore[arg-type]
        moved = self._started(body, pose, branch, kind)
        self.poses[branch.child] = moved
        if joining is None:
            start = (place[0], place[2], angle, *moved.velocity, moved.omega)
            initial: dict[str, Quantity] = dict(zip(kind.start_keys, start, strict=True))
            return Joint(kind.name, identifier(body.name), initial=initial)
        if not self._axis_fits(joining, kind):
            return None
        direction, start = None, (angle, moved.omega)
        if kind.has_direction:
            direction = turned_back(unit(joining.axis), parent.angle)
            start = (0.0, self._sliding(body, moved, branch, joining))
        return Joint(
            kind.name,
            identifier(body.name),
            identifier(branch.parent) if branch.parent != GROUND else GROUND,
            parent.local(joining.location),
            tuple(0.0 - c for c in pose.local(joining.location)),  # type: ignore[arg-type]
            direction,
            initial=dict(zip(kind.start_keys, start, strict=False)),  # a weld has none
        )

    def _report_plane(self, body: BodySection, y: float) -> None:
        """All centres of gravity lie in one plane; that of the first body."""
        self.plane = y if self.plane is None else self.plane
        if abs(y - self.plane) > SMALL:
            message = f"the centre of gravity of {body.name!r} is at Y = {y:g}, not {self.plane:g}"
            remedy = "let all bodies lie in one plane; a shift along Y changes no planar motion"
            self.places.say(body, message, ("location", 1), remedy)

    def _axis_fits(self, joining: Joining, kind: JointType) -> bool:
        if not kind.coordinates:
            return True
        axis = joining.axis
        if axis is None or math.hypot(*axis) == 0:
            remedy = "add 'axis: [0, 1, 0]'" if kind.rotates else "add 'axis: [x, 0, z]'"
            self.places.say(joining, f"{joining.name!r} has no axis", ("axis",), remedy)
            return False
        if kind.rotates and not parallel(axis, (0, 1, 0)):
            message = f"the axis {list(axis)} is not along Y: bodies would leave the X–Z plane"
            self.places.say(joining, message, ("axis",), "turn the model so that it moves in X–Z")
            return False
        if kind.has_direction and abs(axis[1]) > SMALL * math.hypot(*axis):
            message = f"the axis {list(axis)} leads out of the X–Z plane"
            self.places.say(joining, message, ("axis",), "turn the model so that it moves in X–Z")
            return False
        return True

    def _started(
        self, body: BodySection, pose: Pose, branch: Branch[Joining], kind: JointType
    ) -> Pose:
        """The pose with its velocities; reports those that the joint does not allow."""
        parent = self.poses[branch.parent]
        local = body.initial_angular_velocity or (0.0, 0.0, 0.0)
        wx, omega, wz = rotated(pose.axes, local)
        if max(abs(wx), abs(wz)) > SMALL:
            message = "the body would leave the X–Z plane: it turns about X or Z, too"
            self.places.say(body, message, ("initial_angular_velocity",), "only the part about Y")
        if not kind.rotates:
            given = body.initial_angular_velocity is not None
            if given and abs(omega - parent.omega) > SMALL * (1 + abs(omega)):
                message = f"it turns with its parent, at {parent.omega:g} rad/s, not {omega:g}"
                self.places.say(body, message, ("initial_angular_velocity",), "leave it out")
            omega = parent.omega
        linear = body.initial_linear_velocity
        if linear is not None and abs(linear[1]) > SMALL:
            message = "the body would leave the X–Z plane"
            self.places.say(body, message, ("initial_linear_velocity", 1), "make it 0")
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


def guides(motor: MotorSection) -> bool:
    """True of a motor that is a joint as well."""
    return (motor.guide if motor.type == "LINEAR" else motor.spindle) != "FREE"


def joint_kind(joining: Joining | None) -> JointType:
    """The type of our joint."""
    if joining is None:
        return FLOATING
    if isinstance(joining, MotorSection):
        return PRISMATIC if joining.type == "LINEAR" else REVOLUTE
    return TYPES[joining.type]


def unit(axis: Vector3 | None) -> Vector3:
    """A direction of length 1; of an axis that was checked."""
    assert axis is not None
    length = math.hypot(*axis)
    return axis[0] / length, axis[1] / length, axis[2] / length


def parallel(a: Sequence[float], b: Sequence[float]) -> bool:
    """True if two directions agree but for their sense."""
    cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return math.hypot(*cross) <= SMALL * math.hypot(*a) * math.hypot(*b)
