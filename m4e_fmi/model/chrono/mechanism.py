"""Bodies, joints and start values from Chrono's.

Which body hangs on which: Chrono's joints join two bodies, ours a child to its parent. While all
joints are at zero, every body's axes are those of the world. A joint is at zero at the start, but
for a hinge whose child is turned about its axis in the file, and for attitudes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import cycle

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation as Turn

from m4e_fmi.joints import JOINT_TYPES, Coordinate, JointType, attitude
from m4e_fmi.model.chrono.names import Places, fresh
from m4e_fmi.model.chrono.sections import (
    BodySection,
    InertiaSection,
    JointSection,
    ModelSection,
    MotorSection,
    RsdaSection,
    TsdaSection,
)
from m4e_fmi.model.elements import GROUND, Body, Joint, identifier
from m4e_fmi.space import Rotation

Array = NDArray[np.float64]
Vector3 = tuple[float, float, float]
Joining = JointSection | MotorSection
SMALL = 1e-6
"""Size that counts as zero beside 1: of directions, of angles, of rates."""
DIGITS = 13
"""Decimals [m] that are kept: what rounding leaves of a zero is a zero."""


@dataclass(frozen=True)
class Branch:
    """`child` hangs on `parent` by `joining`, in a joint of this `kind`; None where it floats."""

    child: str
    parent: str
    joining: Joining | None
    kind: JointType


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


class Mechanism:
    """Bodies and joints of a Chrono model; findings go to `places`.

    A vector of the file is (x, y, z) in world axes at the start. Of bodies that are joined to the
    ground by nothing, the first in the list floats.
    """

    def __init__(self, model: ModelSection, places: Places) -> None:
        self.model, self.places = model, places
        self.moving = {body.name: body for body in model.bodies if not body.fixed}
        self.joint_of: dict[str, str] = {}
        self.poses: dict[str, Pose] = {GROUND: Pose()}
        self.angles: dict[str, float] = {}  # [rad] of hinges at the start, by their children
        self.branches: dict[str, Branch] = {}  # by their children, parents first
        self._joinings = [*model.joints, *filter(guides, model.motors)]
        self._grow(GROUND)
        for body in self.moving:
            if body not in self.branches:
                self.branches[body] = Branch(body, GROUND, None, JOINT_TYPES[3]["floating"])
                self._grow(body)

    def _grow(self, root: str) -> None:
        """Add the branches from `root`, by their distance from it."""
        waiting = [root]
        for parent in waiting:  # grows while it is walked through
            for joining in self._joinings:
                first, second = self.ends(joining)
                child = second if first == parent else first
                if parent in (first, second) and child not in (GROUND, *self.branches):
                    kind = JOINT_TYPES[3][kind_name(joining)]
                    self.branches[child] = Branch(child, parent, joining, kind)
                    waiting.append(child)

    def ends(self, element: Joining | TsdaSection | RsdaSection) -> tuple[str, str]:
        """The two bodies of an element."""
        return self.holder(element.body1), self.holder(element.body2)

    def holder(self, body: str) -> str:
        """The moving body of this name, or the ground, which stands for all fixed ones."""
        return body if body in self.moving else GROUND

    def bodies(self) -> dict[str, Body]:
        """The bodies that move, by name; incomplete ones are reported and left out."""
        result = {}
        for body in self.moving.values():
            if body.mass is None or body.inertia is None:
                missing = "mass" if body.mass is None else "inertia"
                self.places.say(body, f"body {body.name!r} moves, but has no {missing}", (),
                                f"add '{missing}: …', or 'fixed: true'")  # fmt: skip
                continue
            inertia = self._inertia(body, body.inertia)
            result[identifier(body.name)] = Body(body.mass, inertia, f"Body {body.name}")
        return result

    def joints(self) -> dict[str, Joint]:
        """A joint for every body; also finds the start poses, parents first."""
        used = {id(branch.joining) for branch in self.branches.values()}
        for joining in self._joinings:
            if id(joining) not in used and set(self.ends(joining)) != {GROUND}:
                message = f"{joining.name!r} closes a loop of bodies, which cannot be represented"
                remedy = "cut the loop: remove it, or put a stiff spring and damper in its place"
                if isinstance(joining, MotorSection):
                    remedy = "cut the loop, or let it act on a joint that is there: FREE"
                self.places.say(joining, message, (), remedy)
        result: dict[str, Joint] = {}
        for branch in self.branches.values():
            said = branch.joining.name if branch.joining else f"{branch.child}_free"
            name = fresh(identifier(said), result)
            joint = self._joint(branch)
            if joint is not None:
                self.joint_of[branch.child] = name
                result[name] = joint
        return result

    def freedom(
        self, element: MotorSection | RsdaSection, unit: str
    ) -> tuple[Branch, Coordinate] | None:
        """The joint, and its coordinate in m or rad, along or about the axis of an element."""
        for branch in self.branches.values():
            axis = branch.joining.axis if branch.joining and len(branch.kind.vectors) == 1 else None
            joins = set(self.ends(element)) == {branch.child, branch.parent}
            if axis and joins and parallel(axis, element.axis):
                for coordinate in branch.kind.coordinates:
                    if coordinate.unit == unit:
                        return branch, coordinate
        return None

    def at(self, body: str, place: Sequence[float] | Array) -> Vector3:
        """A `place` (3,) [m] in the world as a point of a body (or the ground), from its CG."""
        pose = self.poses[self.holder(body)]
        return pose.local(np.array(place) - pose.place)

    def _inertia(self, body: BodySection, inertia: InertiaSection) -> tuple[float, ...]:
        """Moments, and products if there are any; of what `joints` has given a pose."""
        xx, yy, zz = inertia.moments
        xy, xz, yz = inertia.products
        given = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        pose = self.poses[body.name]
        ours = pose.turn.T @ pose.axes
        tensor = ours @ given @ ours.T
        products = np.array([tensor[0, 1], tensor[1, 2], tensor[0, 2]])
        products[np.abs(products) < 10.0**-DIGITS * np.abs(given).max()] = 0.0
        parts = [*np.diag(tensor), *(products if products.any() else ())]
        return tuple(map(float, parts))

    def _matrix(self, orientation: Sequence[float]) -> Array:
        """The rotation (3, 3) of a quaternion, or of angles as R_z·R_y·R_x (ReadCardanAngles)."""
        if len(orientation) == 4:
            return Turn.from_quat(orientation, scalar_first=True).as_matrix()
        degrees = self.model.angle_degrees
        return Turn.from_euler("ZYX", orientation, degrees=degrees).as_matrix()

    def _joint(self, branch: Branch) -> Joint | None:
        body, parent = self.moving[branch.child], self.poses[branch.parent]
        file_axes = self._matrix(body.orientation)
        place = np.array(body.location) + file_axes @ body.com.location
        axes = file_axes @ self._matrix(body.com.orientation)
        joining, kind = branch.joining, branch.kind
        lines = self._lines(branch)
        if lines is None:
            self.poses[body.name] = Pose(place, file_axes, axes)
            return None
        angle, turn = 0.0, file_axes
        if not kind.has_quaternion:
            turn = parent.turn
            if kind.axes == ("axis",):  # a hinge
                angle = angle_about(lines[0], file_axes @ parent.turn.T)
                turn = Turn.from_rotvec(angle * lines[0]).as_matrix() @ turn
        pose, rates = self._started(branch, Pose(place, turn, axes), lines)
        self.poses[body.name], self.angles[body.name] = pose, angle
        values = [angle if c.is_angle else 0.0 for c in kind.coordinates]
        if kind.has_quaternion:
            values = [*(pose.place if joining is None else ()), *attitude(Rotation(turn.tolist()))]
        initial = dict(zip(kind.start_keys, map(float, [*values, *rates]), strict=True))
        if joining is None:
            return Joint(kind.name, identifier(body.name), initial=dict(initial))
        where = np.array(joining.location)
        return Joint(
            kind.name,
            identifier(body.name),
            identifier(branch.parent) if branch.parent != GROUND else GROUND,
            parent.local(where - parent.place),
            pose.local(place - where),
            initial=dict(initial),
            **dict(zip(kind.vectors, map(parent.local, lines), strict=True)),  # pyrefly: ignore[bad-argument-type]
        )

    def _lines(self, branch: Branch) -> list[Array] | None:
        """The axes and directions of a joint, of length 1 in the world; None, with a finding.

        Of a universal joint the one in the parent comes first. As Chrono does it, axis1 is fixed in
        body1 and the part of axis2 at right angles to it in body2.
        """
        joining = branch.joining
        if joining is None or not branch.kind.vectors:
            return []
        keys = ("axis",) if len(branch.kind.vectors) == 1 else ("axis1", "axis2")
        for key in keys:
            if getattr(joining, key) is None:
                message = f"{joining.name!r} has no {key}"
                self.places.say(joining, message, (), f"add '{key}: [x, y, z]'")
                return None
        first, *others = (unit(getattr(joining, key)) for key in keys)
        if not others:
            return [first]
        if parallel(first, others[0]):
            message = f"both axes of {joining.name!r} are the same"
            self.places.say(joining, message, ("axis2",), "give one at right angles to axis1")
            return None
        lines = [first, unit(np.cross(np.cross(first, others[0]), first))]
        return lines if self.holder(joining.body1) == branch.parent else lines[::-1]

    def _started(self, branch: Branch, pose: Pose, lines: list[Array]) -> tuple[Pose, list[float]]:
        """The pose with its velocities, and the joint's; reports those that it does not allow."""
        body, parent, joining = self.moving[branch.child], self.poses[branch.parent], branch.joining
        pairs = list(zip(branch.kind.coordinates, cycle(lines), strict=False))
        slides = [line for coordinate, line in pairs if not coordinate.is_angle]
        turns = [line for coordinate, line in pairs if coordinate.is_angle]
        if branch.kind.has_quaternion:
            slides, turns = [], list(np.eye(3))
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
        return moved, [*omega] if branch.kind.has_quaternion else [*sliding, *turning]


def _along(lines: list[Array], vector: Array) -> tuple[Array, Array]:
    """The parts of a vector along some directions, and their sum (3,)."""
    if not lines:
        return np.zeros(0), np.zeros(3)
    columns = np.array(lines).T
    parts = np.asarray(np.linalg.lstsq(columns, vector, rcond=None)[0], float) + 0.0  # no −0
    return parts, columns @ parts


def _differ(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(a - b) > SMALL * (1 + np.linalg.norm(a)))


def guides(motor: MotorSection) -> bool:
    """True of a motor that is a joint as well."""
    return (motor.guide if motor.type == "LINEAR" else motor.spindle) != "FREE"


def kind_name(joining: Joining) -> str:
    """The name of our type of joint."""
    if isinstance(joining, MotorSection):
        return "prismatic" if joining.type == "LINEAR" else joining.spindle.lower()
    return "fixed" if joining.type == "LOCK" else joining.type.lower()


def unit(axis: Sequence[float] | Array) -> Array:
    """The direction (3,) of `axis` (3,) [1], of length 1."""
    return np.array(axis) / math.hypot(*axis)


def parallel(a: Sequence[float] | Array, b: Sequence[float] | Array) -> bool:
    """True if `a` (3,) and `b` (3,) [1], neither of them zero, agree but for their sense."""
    return bool(np.linalg.norm(np.cross(unit(a), unit(b))) <= SMALL)


def angle_about(axis: Array, turn: Array) -> float:
    """The angle (scalar) [rad] of the rotation `turn` (3, 3) [1] about `axis` (3,) [1].

    The axis has length 1; 0 if the rotation is about another.
    """
    vector = Turn.from_matrix(turn).as_rotvec()
    angle = vector @ axis
    return round(float(angle), DIGITS) + 0.0 if not _differ(angle * axis, vector) else 0.0


def rounded(v: Array) -> Vector3:
    """The vector `v` (3,) [1 or m], in which what rounding leaves of a zero is a zero."""
    x, y, z = (round(float(part), DIGITS) + 0.0 for part in v)
    return x, y, z
