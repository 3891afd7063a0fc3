"""Bodies, joints and start values from Chrono's.

Which body hangs on which: Chrono's joints join two bodies, ours a child to its parent. While all
joints are at zero, every body's axes are those of the world. A joint is at zero at the start, but
for a hinge whose child is turned about its axis in the file, and for attitudes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import cycle
from typing import Literal

import numpy as np

from m4e_fmi.joints import JOINT_TYPES, JointType, attitude
from m4e_fmi.model.chrono.names import Places, fresh
from m4e_fmi.model.chrono.rotation import (
    DIGITS,
    Array,
    Quaternion,
    Vector3,
    angle_about,
    matrix,
    product,
    quaternion,
    rounded,
    turned_about,
)
from m4e_fmi.model.chrono.sections import (
    BodySection,
    InertiaSection,
    JointSection,
    ModelSection,
    MotorSection,
)
from m4e_fmi.model.elements import GROUND, Body, Joint, Quantity, Vector, identifier
from m4e_fmi.space import Rotation

SMALL = 1e-6
"""Size that counts as zero beside 1: of directions, of positions in metres, of rates."""
Joining = JointSection | MotorSection
_OURS = {"LOCK": "fixed"}


@dataclass(frozen=True)
class Edge:
    """Something that joins two bodies; the ground stands for all fixed ones."""

    joining: Joining
    bodies: tuple[str, str]


@dataclass(frozen=True)
class Branch:
    """`child` hangs on `parent` by `joining`; None where it floats."""

    child: str
    parent: str
    joining: Joining | None


def branches(bodies: Iterable[str], edges: Sequence[Edge]) -> tuple[list[Branch], list[Edge]]:
    """A branch for every body, parents first, and the edges that would close a loop.

    Of bodies that are joined to the ground by nothing, the first in the list floats.
    """
    at: dict[str, list[Edge]] = {}
    for edge in edges:
        for body in edge.bodies:
            at.setdefault(body, []).append(edge)
    grown: list[Branch] = []
    used: set[int] = set()
    reached = {GROUND}
    grown += _grow(GROUND, at, reached, used)
    for body in bodies:
        if body not in reached:
            reached.add(body)
            grown.append(Branch(body, GROUND, None))
            grown += _grow(body, at, reached, used)
    return grown, [edge for edge in edges if id(edge) not in used and set(edge.bodies) != {GROUND}]


def _grow(
    root: str, at: Mapping[str, list[Edge]], reached: set[str], used: set[int]
) -> Iterator[Branch]:
    """Branches from `root`, by distance from it; marks bodies and edges."""
    waiting = [root]
    for parent in waiting:  # grows while it is walked through
        for edge in at.get(parent, ()):
            first, second = edge.bodies
            child = second if first == parent else first
            if child not in reached:
                reached.add(child)
                used.add(id(edge))
                waiting.append(child)
                yield Branch(child, parent, edge.joining)


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
    """Bodies and joints of a Chrono model in space; findings go to `places`.

    A vector of the file is (x, y, z) in world axes at the start; those of a Model have its
    `dimensions`.
    """

    dimensions: Literal[2, 3] = 3

    def __init__(self, model: ModelSection, places: Places) -> None:
        self.model, self.places = model, places
        self.moving = {body.name: body for body in model.bodies if not body.fixed}
        self.joint_of: dict[str, str] = {}
        self.poses: dict[str, Pose] = {GROUND: Pose()}
        self.angles: dict[str, float] = {}  # [rad] of hinges at the start, by their children
        self.branches, self.loops = branches(self.moving, self._edges())

    def holder(self, body: str) -> str:
        """The moving body of this name, or the ground."""
        return body if body in self.moving else GROUND

    def kind(self, joining: Joining | None) -> JointType:
        """The type of our joint in space."""
        return JOINT_TYPES[3][kind_name(joining)]

    def _edges(self) -> list[Edge]:
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
            axes = self._axes(self.moving[branch.child])
            joint = None
            if axes is None:
                self.poses[branch.child] = Pose()
            else:
                joint = self._joint(branch, axes)
            if joint is not None:
                self.joint_of[branch.child] = name
                result[name] = joint
        return result

    def _report_loop(self, edge: Edge) -> None:
        joining = edge.joining
        if isinstance(joining, MotorSection) and self.branch_of(joining):
            return
        message = f"{joining.name!r} closes a loop of bodies, which cannot be represented"
        remedy = "cut the loop: remove it, or put a stiff spring and damper in its place"
        self.places.say(joining, message, (), remedy)

    def branch_of(self, motor: MotorSection) -> Branch | None:
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

    def _moves_along(self, branch: Branch, motor: MotorSection) -> bool:
        """True of a branch of the motor's bodies with the motor's freedom."""
        slides = motor.type == "LINEAR"
        name = kind_name(branch.joining)
        fits = name == "cylindrical" or name == ("prismatic" if slides else "revolute")
        ends = {self.holder(motor.body1), self.holder(motor.body2)}
        return fits and self.is_along(branch, ends, motor.axis)

    def is_along(self, branch: Branch, ends: set[str], axis: Vector3) -> bool:
        """True of a branch that joins two bodies along or about this one axis."""
        own = (branch.joining and branch.joining.axis) or (0.0, 0.0, 0.0)
        return {branch.child, branch.parent} == ends and parallel(own, axis)

    def at(self, body: str, place: Sequence[float]) -> Vector:
        """A place in the world as a point of a body (or the ground), from its CG [m]."""
        pose = self.poses[self.holder(body)]
        return pose.local(np.array(place) - pose.place)

    def in_world(self, vector: Sequence[float]) -> tuple[float, ...]:
        """A force or moment in world axes."""
        x, y, z = vector
        return x, y, z

    def in_body(self, body: str, vector: Sequence[float]) -> tuple[float, ...]:
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
    ) -> float | tuple[float, ...]:
        """Moments, and products if there are any; of what `joints` has given a pose."""
        given = tensor_of(inertia)
        ours = self.poses[body.name].turn.T @ matrix(axes)
        tensor = ours @ given @ ours.T
        products = np.array([tensor[0, 1], tensor[1, 2], tensor[0, 2]])
        products[np.abs(products) < 10.0**-DIGITS * np.abs(given).max()] = 0.0
        parts = [*np.diag(tensor), *(products if products.any() else ())]
        return tuple(map(float, parts))

    def _turn(self, orientation: Quaternion) -> Array:
        """The rotation (3, 3) of a body that counts of its orientation in the file."""
        return matrix(orientation)

    def _joint(self, branch: Branch, axes: Quaternion) -> Joint | None:
        body, parent = self.moving[branch.child], self.poses[branch.parent]
        orientation = quaternion(body.orientation, degrees=self.model.angle_degrees)
        place = np.array(body.location) + matrix(orientation) @ body.com.location
        file_axes = self._turn(orientation)
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
        initial = starts(kind, [*_coordinates(kind, pose, angle), *rates])
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

    def _lines(self, branch: Branch, kind: JointType) -> list[Array] | None:
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

    def _cross(self, joint: JointSection, branch: Branch) -> list[Array] | None:
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
        self, branch: Branch, kind: JointType, pose: Pose, lines: list[Array]
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


def starts(kind: JointType, values: Sequence[float]) -> dict[str, Quantity]:
    """Start values of a joint: its coordinates, then its velocities."""
    return dict(zip(kind.start_keys, map(float, values), strict=True))


def tensor_of(inertia: InertiaSection) -> Array:
    """The inertia tensor (3, 3) [kg·m²] in the axes of the file."""
    xx, yy, zz = inertia.moments
    xy, xz, yz = inertia.products
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


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
    parts = np.asarray(np.linalg.lstsq(columns, vector, rcond=None)[0], float) + 0.0  # no −0
    return parts, columns @ parts


def _differ(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(a - b) > SMALL * (1 + np.linalg.norm(a)))


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
