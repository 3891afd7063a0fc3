"""A URDF file as a model in space."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.model.checks import group_findings
from m4e_fmi.model.elements import (
    GROUND,
    Body,
    Joint,
    Parameter,
    Point,
    Quantity,
    Vector,
    identifier,
)
from m4e_fmi.model.findings import ModelFinding, Names
from m4e_fmi.model.groups import Groups
from m4e_fmi.model.loads import JointEffort, JointFriction, Load
from m4e_fmi.model.model import Model
from m4e_fmi.model.urdf.reading import Array, Pose, Reader, Robot, UrdfJoint, UrdfLink

CREEP = 0.01
"""Rate [rad/s or m/s] at which friction has reached 76 %: URDF has none, and sticking is not known
here."""
WITH_DYNAMICS = ("revolute", "continuous", "prismatic")
"""Types of joints along whose coordinate damping and friction act."""
_UNITS = {"damping": ("N.m.s/rad", "N.s/m"), "friction": ("N.m", "N"), "creep": ("rad/s", "m/s")}


def model_of_urdf(path: str | Path) -> Model:
    """The Model of a URDF file; InputError with every problem found, each with its line.

    The root link is the ground, and so is its frame; a robot floats if a `floating` joint holds it
    to a root link. Links that `fixed` joints hold together are one body, and points where their
    frames are. With all joints at zero the bodies' axes are those of the world. Shapes, limits,
    transmissions and extensions of simulators have no meaning here; limits are told as a warning.
    """
    reader = Reader(as_path(path))
    robot = reader.robot()
    InputError.raise_for(reader.problems)
    return _Conversion(robot, reader).model()


class _Conversion:
    """Bodies, joints and loads of one robot."""

    def __init__(self, robot: Robot, reader: Reader) -> None:
        self.robot, self.reader = robot, reader
        self.holders = {joint.child: joint for joint in robot.joints}
        self.poses: dict[str, Pose] = {}
        self.members: dict[str, list[UrdfLink]] = {}  # of each body, by its first link
        for link in robot.links.values():
            self.members.setdefault(self._first(link.name), []).append(link)
        self.parameters: dict[str, Parameter] = {}

    def model(self) -> Model:
        """The model, its warnings placed in the file."""
        joints = [joint for joint in self.robot.joints if joint.type != "fixed"]
        if not joints:
            remedy = "a link 'world' and a joint of the type floating on it let a vehicle move"
            self.reader.say(0, "nothing can move: every joint is fixed", remedy)
        moving = [first for first in self.members if first in self.holders]
        bodies = {identifier(first): self._body(first) for first in moving}
        held = {identifier(joint.name): self._joint(joint) for joint in joints}
        points, loads = dict(self._points()), dict(self._loads())
        InputError.raise_for(self.reader.problems)
        groups = Groups(
            name=identifier(self.robot.name),
            description=f"URDF robot {self.robot.name}",
            bodies=bodies,
            joints=held,
            points=points,
            loads=loads,
            parameters=self.parameters,
            dimensions=3,
        )
        InputError.raise_for(map(self._placed, group_findings(groups, Names.of(groups))))
        return Model(**vars(groups)).place_warnings(self._placed, self._left_out())

    def _first(self, name: str) -> str:
        """The link, of those that fixed joints hold together with this one, nearest to the root."""
        while name in self.holders and self.holders[name].type == "fixed":
            name = self.holders[name].parent
        return name

    def _named(self, first: str) -> str:
        """The body of a first link, or the ground."""
        return identifier(first) if first in self.holders else GROUND

    def _points(self) -> Iterator[tuple[str, Point]]:
        """The frames of links on fixed joints."""
        for first, links in self.members.items():
            for link in (link for link in links if link.name != first):
                at = _vector(self._pose(link.name).place - self._center(first))
                yield identifier(link.name), Point(self._named(first), at, f"Link {link.name}")

    def _pose(self, name: str) -> Pose:
        """A link's frame in the world while all joints are at zero."""
        if name not in self.poses:
            joint = self.holders.get(name)
            self.poses[name] = self._pose(joint.parent).then(joint.pose) if joint else Pose()
        return self.poses[name]

    def _masses(self, first: str) -> list[tuple[float, Pose, Array]]:
        """Mass, central pose in the world and inertia of the links of a body."""
        return [
            (link.mass, self._pose(link.name).then(link.center), link.inertia)
            for link in self.members[first]
        ]

    def _center(self, first: str) -> Array:
        """Centre of gravity of a body in the world [m] (3,); the origin, of the ground."""
        masses = self._masses(first)
        total = sum(mass for mass, _, _ in masses)
        if first not in self.holders or total == 0:
            return np.zeros(3)
        return sum((mass * pose.place for mass, pose, _ in masses), np.zeros(3)) / total

    def _body(self, first: str) -> Body:
        masses, center = self._masses(first), self._center(first)
        tensor = np.zeros((3, 3))
        for mass, pose, inertia in masses:
            arm = pose.place - center
            tensor += pose.axes @ inertia @ pose.axes.T
            tensor += mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        parts = [*np.diag(tensor), tensor[0, 1], tensor[1, 2], tensor[0, 2]]
        names = ", ".join(link.name for link in self.members[first])
        total = sum(mass for mass, _, _ in masses)
        return Body(total, tuple(map(float, parts)), f"Link {names}")

    def _joint(self, joint: UrdfJoint) -> Joint:
        child, pose = identifier(joint.child), self._pose(joint.child)
        text = f"Joint {joint.name}"
        center, parent = self._center(joint.child), self._first(joint.parent)
        if joint.type == "floating":
            if parent in self.holders:
                message = f"joint {joint.name!r} floats against a link that moves"
                self.reader.say(joint.line, message, "let it hang on the root link")
            start: dict[str, Quantity] = dict(zip("xyz", map(float, center), strict=True))
            return Joint("floating", child, initial=start, description=text)
        to = _vector(pose.place - self._center(parent))
        out, holder = _vector(center - pose.place), self._named(parent)
        kind = "revolute" if joint.type == "continuous" else joint.type
        axes = _axes(joint, pose)
        return Joint(
            kind, child, holder, to, out, axes.get("direction"), axis=axes.get("axis"),
            description=text,
        )  # fmt: skip

    def _loads(self) -> Iterator[tuple[str, Load]]:
        """Damping and friction of joints, with parameters of their own."""
        for joint in self.robot.joints:
            if joint.type not in WITH_DYNAMICS:
                continue
            name, slides = identifier(joint.name), joint.type == "prismatic"

            def parameter(key: str, value: float, name: str = name, index: int = slides) -> str:
                self.parameters[f"{name}_{key}"] = Parameter(value, _UNITS[key][index])
                return f"{name}_{key}"

            if joint.damping:
                coefficient = parameter("damping", joint.damping)
                yield f"{name}_damper", JointEffort(name, f"-{coefficient}*joint.{name}.u")
            if joint.friction:
                most, creep = parameter("friction", joint.friction), parameter("creep", CREEP)
                yield f"{name}_friction", JointFriction(name, most, creep)

    def _placed(self, finding: ModelFinding) -> Problem:
        """A problem of the model at the line of the link or joint that it is about."""
        group, name, *_ = (*finding.location, "", "")
        elements: Iterable[UrdfLink | UrdfJoint] = self.robot.joints
        if group in ("bodies", "points"):
            elements = self.robot.links.values()
        lines = [e.line for e in elements if identifier(e.name) == name]
        message = f"{'.'.join(map(str, finding.location))}: {finding.message}"
        return Problem(message, finding.remedy, str(self.reader.path), lines[0] if lines else 0)

    def _left_out(self) -> Iterator[Problem]:
        """Warnings of parts of the file that the model does not have."""
        limited = [joint for joint in self.robot.joints if joint.limited]
        if limited:
            kinds = ", ".join(sorted({kind for joint in limited for kind in joint.limited}))
            count = f"{len(limited)} joint{'s' * (len(limited) > 1)}"
            message = f"the limits of {count} ({kinds}) are not part of the model"
            remedy = "a load of the type joint_stop keeps a joint between limits"
            yield Problem(message, remedy, str(self.reader.path), limited[0].line)
        for joint in self.robot.joints:
            if (joint.damping or joint.friction) and joint.type not in WITH_DYNAMICS:
                what = f"the {joint.type} joint {joint.name!r}"
                message = f"damping and friction of {what} are left out"
                remedy = "URDF does not say along which of its coordinates they act"
                yield Problem(message, remedy, str(self.reader.path), joint.line)
        root = next(link for name, link in self.robot.links.items() if name not in self.holders)
        if root.mass:
            message = f"link {root.name!r} is the root and so the ground: it does not move"
            remedy = "a link 'world' and a joint of the type floating on it let a vehicle move"
            yield Problem(message, remedy, str(self.reader.path), root.line)
        if self.robot.others:
            tags = ", ".join(f"<{tag}>" for tag in self.robot.others)
            yield Problem(f"{tags} is no part of URDF and is left out", "", str(self.reader.path))


def _axes(joint: UrdfJoint, pose: Pose) -> dict[str, Vector]:
    """Axis and direction of a joint, in world axes at the pose of zeros."""
    axis = pose.axes @ (joint.axis / np.linalg.norm(joint.axis))
    match joint.type:
        case "prismatic":
            return {"direction": _vector(axis)}
        case "planar":  # the first axis of the joint's frame that is not along the normal
            rest = [column - axis * (axis @ column) for column in pose.axes.T]
            first = next(side for side in rest if np.linalg.norm(side) > 0.5)
            return {"axis": _vector(axis), "direction": _vector(first / np.linalg.norm(first))}
        case _:
            return {"axis": _vector(axis)}


def _vector(array: Array) -> tuple[float, float, float]:
    """`array` (3,) [1 or m] without what differences of decimal numbers leave behind."""
    x, y, z = (round(float(part), 15) + 0.0 for part in array)
    return x, y, z
