"""Links and joints of a URDF file, in its own terms, and what is wrong with them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_XML
from m4e_fmi.files.xml_text import Element, xml_root
from m4e_fmi.model.elements import identifier

Array = NDArray[np.float64]
JOINTS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "iyz", "ixz")
_IN_ROBOT = ("link", "joint", "material", "transmission", "gazebo", "sensor")
_ROUNDING = 1e-15  # entries of a rotation below this are zeros of a turn by a right angle


@dataclass(frozen=True)
class Pose:
    """A frame in another: its origin [m] (3,) and its axes (3, 3), own → other."""

    place: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))

    def then(self, inner: Pose) -> Pose:
        """The pose of a frame that is at `inner` in this one."""
        return Pose(self.place + self.axes @ inner.place, _rounded(self.axes @ inner.axes))


@dataclass(frozen=True)
class UrdfLink:
    """A link: mass [kg], inertia about its centre of gravity in the axes of `center` [kg·m²]."""

    name: str
    line: int
    mass: float = 0.0
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    center: Pose = field(default_factory=Pose)


@dataclass(frozen=True)
class UrdfJoint:
    """A joint at `pose` in the parent link, `axis` in its own axes.

    `damping` [N·m·s/rad or N·s/m] and `friction` [N·m or N] are 0 if the file has none; `limited`
    names the limits that it has.
    """

    name: str
    line: int
    type: str
    parent: str
    child: str
    pose: Pose
    axis: Array
    damping: float
    friction: float
    limited: tuple[str, ...]


@dataclass(frozen=True)
class Robot:
    """The parts of a file with a meaning here; `others` are elements that URDF does not have."""

    name: str
    links: dict[str, UrdfLink]
    joints: list[UrdfJoint]
    others: list[str]


class Reader:
    """Reads one file; `problems` are gathered, each with its line."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.problems: list[Problem] = []

    def say(self, line: int, message: str, remedy: str = "") -> None:
        """Note a problem."""
        self.problems.append(Problem(message, remedy, str(self.path), line))

    def robot(self) -> Robot:
        """The robot; InputError if the file cannot be read or is none."""
        try:
            content = read_bytes(self.path, largest=LARGEST_XML)
        except FileNotFoundError:
            raise InputError.single("no such file", "", str(self.path)) from None
        except (OSError, TooLongError) as error:
            raise InputError.single(f"cannot be read: {error}", "", str(self.path)) from None
        if b"<xacro:" in content or b"${" in content:
            message, remedy = (
                "is a xacro file: its macros are not expanded",
                "run `xacro FILE > robot.urdf` first",
            )
            raise InputError.single(message, remedy, str(self.path))
        root = xml_root(content, str(self.path))
        if root.tag != "robot":
            remedy = "URDF begins with <robot name='…'>"
            self.say(root.sourceline, f"the XML begins with <{root.tag}>, not with <robot>", remedy)
            raise InputError(self.problems)
        links = [self._link(element) for element in root.findall("link")]
        joints = [self._joint(element) for element in root.findall("joint")]
        others = sorted({str(e.tag) for e in root} - {*_IN_ROBOT})
        named = {link.name: link for link in links}
        robot = Robot(root.get("name", self.path.stem), named, joints, others)
        self._check(robot, links)
        return robot

    def _name(self, element: Element, key: str = "name") -> str:
        name = element.get(key, "").strip()
        if not name:
            self.say(element.sourceline, f"<{element.tag}> has no {key}", f"add {key}='…'")
        return name

    def _numbers(
        self, element: Element | None, key: str, default: Sequence[float] | None
    ) -> list[float]:
        """The numbers of an attribute; `default` if there is none, an error if that is None."""
        count = 1 if default is None else len(default)
        text = None if element is None else element.get(key)
        if element is None or text is None:
            if element is not None and default is None:
                message = f"<{element.tag}> has no {key}"
                self.say(element.sourceline, message, f"add {key}='…'")
            return list(default or [math.nan])
        try:
            found = [float(word) for word in text.split()]
        except ValueError:
            found = []
        if len(found) != count or not all(map(math.isfinite, found)):
            wanted = "a finite number" if count == 1 else f"{count} finite numbers"
            self.say(element.sourceline, f"{key} of <{element.tag}> is {text!r}, not {wanted}")
            return [0.0] * count
        return found

    def _pose(self, owner: Element) -> Pose:
        origin = owner.find("origin")
        place = self._numbers(origin, "xyz", (0.0, 0.0, 0.0))
        angles = self._numbers(origin, "rpy", (0.0, 0.0, 0.0))
        return Pose(np.array(place), _rounded(Rotation.from_euler("xyz", angles).as_matrix()))

    def _link(self, element: Element) -> UrdfLink:
        name, line = self._name(element), element.sourceline
        inertial = element.find("inertial")
        if inertial is None:
            return UrdfLink(name, line)
        parts = {tag: inertial.find(tag) for tag in ("mass", "inertia")}
        for tag, part in parts.items():
            if part is None:
                self.say(inertial.sourceline, f"<inertial> has no <{tag}>", f"add <{tag} …/>")
        if None in parts.values():
            return UrdfLink(name, line)
        (mass,) = self._numbers(parts["mass"], "value", None)
        if mass < 0:
            self.say(parts["mass"].sourceline, f"the mass of link {name!r} is negative")
        xx, yy, zz, xy, yz, xz = (self._numbers(parts["inertia"], k, None)[0] for k in _MOMENTS)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return UrdfLink(name, line, mass, tensor, self._pose(inertial))

    def _joint(self, element: Element) -> UrdfJoint:
        name, line, kind = self._name(element), element.sourceline, self._name(element, "type")
        if kind and kind not in JOINTS:
            self.say(line, f"unknown type {kind!r} of joint {name!r}", suggestion(kind, JOINTS))
        if element.find("mimic") is not None:
            message = f"joint {name!r} follows another one (mimic), which cannot be represented"
            remedy = "remove <mimic>: the joint then moves by itself; or make it fixed"
            self.say(element.find("mimic").sourceline, message, remedy)
        ends = []
        for tag in ("parent", "child"):
            end = element.find(tag)
            if end is None:
                self.say(line, f"joint {name!r} has no <{tag}>", f"add <{tag} link='…'/>")
            ends.append("" if end is None else self._name(end, "link"))
        axis = np.array(self._numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0)))
        if not axis.any() and kind not in ("fixed", "floating"):
            self.say(element.find("axis").sourceline, f"the axis of joint {name!r} has no length")
            axis = np.array([1.0, 0.0, 0.0])
        dynamics, limit = element.find("dynamics"), element.find("limit")
        lost = {key: self._numbers(dynamics, key, (0.0,))[0] for key in ("damping", "friction")}
        for key in (key for key, number in lost.items() if number < 0):
            self.say(dynamics.sourceline, f"{key} of joint {name!r} is negative")
        limited = () if limit is None else tuple(sorted(map(str, limit.keys())))
        if kind == "continuous":
            limited = tuple(key for key in limited if key in ("effort", "velocity"))
        parent, child = ends
        pose = self._pose(element)
        return UrdfJoint(name, line, kind, parent, child, pose, axis, limited=limited, **lost)

    def _check(self, robot: Robot, links: Sequence[UrdfLink]) -> None:
        """Names given twice, or the same here, links that are not there, and a tree."""
        for kind, elements in (("link", links), ("joint", robot.joints)):
            first: dict[str, str] = {}
            for element in (one for one in elements if one.name):
                other = first.get(identifier(element.name))
                if other is not None:
                    message = f"two {kind}s are called {element.name!r}"
                    if other != element.name:
                        message = f"{element.name!r} and {other!r} would get the same name"
                    self.say(element.line, message, "rename one of the two")
                first.setdefault(identifier(element.name), element.name)
        holders: dict[str, UrdfJoint] = {}
        for joint in robot.joints:
            for end in filter(None, (joint.parent, joint.child)):
                if end not in robot.links:
                    remedy = suggestion(end, robot.links, "links")
                    self.say(joint.line, f"joint {joint.name!r} names no link: {end!r}", remedy)
            if joint.child in holders:
                message = f"link {joint.child!r} is the child of two joints, {joint.name!r} and "
                self.say(joint.line, f"{message}{holders[joint.child].name!r}", "cut the loop")
            holders[joint.child] = joint
        if self.problems:
            return
        roots = [link for link in links if link.name not in holders]
        if not links:
            remedy = "a file that only defines macros is expanded by `xacro FILE > robot.urdf`"
            self.say(0, "the robot has no links", remedy)
        elif not roots:
            self.say(0, "every link is the child of a joint: there is no root", "cut the loop")
        for extra in roots[1:]:
            message = f"link {extra.name!r} hangs on no joint; the root is {roots[0].name!r}"
            self.say(extra.line, message, "join it, or leave it out")
        for link in links:
            name, way = link.name, set[str]()
            while name in holders and name not in way:
                way.add(name)
                name = holders[name].parent
            if name in way and link.name == name:
                self.say(link.line, f"link {name!r} is a child of itself", "cut the loop")


def _rounded(axes: Array) -> Array:
    """Axes without the rounding of right angles."""
    return np.where(np.abs(axes) < _ROUNDING, 0.0, axes)
