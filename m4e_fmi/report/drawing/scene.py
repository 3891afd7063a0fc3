"""The shape of a planar model: numbers to draw from, in its start pose.

Lengths in metres, angles in radians; points (x, z) of a body are in its axes from its centre of
gravity, those of the ground (index −1) in world axes from the origin.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.joints import JointType
from m4e_fmi.model import JointEffort, Model
from m4e_fmi.model.elements import Quantity, Vector, parameter_values
from m4e_fmi.model.expression import Values
from m4e_fmi.model.groups import gravity_of
from m4e_fmi.model.quantity import as_expression
from m4e_fmi.multibody import Topology, model_program, topology
from m4e_fmi.multibody.declaration import is_unset
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python
from m4e_fmi.report.animation.scene import GROUND
from m4e_fmi.report.drawing import symbols
from m4e_fmi.report.drawing.symbols import Line, Pair

MOST_BODIES_ACROSS = 12  # bodies in a row at which symbols begin to shrink with the bodies


@dataclass(frozen=True)
class Anchor:
    """A point of a body, or of the ground."""

    body: int
    at: Pair


@dataclass(frozen=True)
class JointMark:
    """A joint: its points on parent and child, and its direction in the parent's axes if any."""

    name: str
    type: JointType
    parent: Anchor
    child: Anchor
    direction: Pair | None = None


@dataclass(frozen=True)
class Tie:
    """A load between two points, or at a joint between two bodies; `kind` is its type."""

    name: str
    kind: str
    ends: tuple[Anchor, Anchor]


@dataclass(frozen=True)
class Push:
    """A force on a point along `direction` (world axes, length 1), or a moment (no direction)."""

    name: str
    at: Anchor
    direction: Pair | None


@dataclass(frozen=True)
class PlanarScene:
    """A model to be drawn: bodies in the order of their numbers, joints in that of their children.

    `depths` are the bodies' distances from the ground in joints; `start` their poses, (N, 3).
    """

    title: str
    description: str
    bodies: tuple[str, ...]
    depths: tuple[int, ...]
    joints: tuple[JointMark, ...]
    points: Mapping[str, Anchor]
    ties: tuple[Tie, ...]
    pushes: tuple[Push, ...]
    gravity: float
    start: np.ndarray

    @cached_property
    def attachments(self) -> list[list[Pair]]:
        """For every body, all places where something holds it, its CG first."""
        found: list[list[Pair]] = [[(0.0, 0.0)] for _ in self.bodies]
        ends = [end for joint in self.joints for end in (joint.parent, joint.child)
                if not joint.type.is_free]  # fmt: skip
        for anchor in (*ends, *self.points.values()):
            if anchor.body >= 0 and anchor.at not in found[anchor.body]:
                found[anchor.body].append(anchor.at)
        return found

    def outline(self, body: int, radius: float) -> Line:
        """Outline (n, 2) [m] of a body in its own axes; thinner, the farther from the ground.

        A body that slides is a block along the direction of its joint.
        """
        thickness = radius * max(0.6, 0.88 ** (self.depths[body] - 1))
        joint = self.joints[body]
        if joint.direction and not joint.type.rotates:
            blocks = [symbols.box(at, 3.6 * radius, 2.4 * radius, joint.direction)
                      for at in self.attachments[body]]  # fmt: skip
            return symbols.convex_hull(np.vstack(blocks))
        discs = [symbols.circle(at, thickness) for at in self.attachments[body]]
        return symbols.convex_hull(np.vstack(discs))

    @cached_property
    def fixed(self) -> list[Pair]:
        """Points of the ground that something is fastened to."""
        ends = [joint.parent for joint in self.joints if not joint.type.is_free]
        ends += [end for tie in self.ties for end in tie.ends]
        return list(dict.fromkeys(end.at for end in ends if end.body == GROUND))

    def place(self, anchor: Anchor) -> np.ndarray:
        """A point in the world, (2,) [m]."""
        if anchor.body == GROUND:
            return np.array(anchor.at)
        return placed(anchor.at, self.start[anchor.body])

    @cached_property
    def extent(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner (2,) [m] of everything."""
        places = [np.array(self.fixed).reshape(-1, 2)]
        places += [
            placed(np.array(attached), pose)
            for attached, pose in zip(self.attachments, self.start, strict=True)
        ]
        everything = np.vstack(places)
        return everything.min(axis=0), everything.max(axis=0)

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of everything [m]; 1 m of a single point."""
        low, high = self.extent
        return float(np.hypot(*(high - low))) or 1.0

    @cached_property
    def size(self) -> float:
        """A length to scale symbols by [m]: the diagonal, or less where bodies are small."""
        spans = [float(np.hypot(*np.ptp(np.array(held), axis=0))) for held in self.attachments]
        body = float(np.quantile(spans, 0.75))
        return min(self.diagonal, MOST_BODIES_ACROSS * body) if body > 0 else self.diagonal


def turned(at: ArrayLike, angle: float) -> np.ndarray:
    """Vectors `at` (…, 2) [m] of a body in world axes; `angle` θ > 0 [rad] turns +Z towards +X."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(at) @ np.array([[c, -s], [s, c]])


def placed(outline: ArrayLike, pose: np.ndarray) -> np.ndarray:
    """Points `outline` (…, 2) [m] of a body in the world, at its `pose` (3,) [m, m, rad]."""
    return pose[:2] + turned(outline, pose[2])


def start_values(program: Program) -> dict[str, float]:
    """States and outputs at t = 0, by name, at the start values of a Program.

    Masses that nobody has set are 1 kg: places do not depend on them.
    """
    program = program.with_start({v.name: 1.0 for v in program.parameters if is_unset(v)})
    form = load_python(program)
    x, u, p = ([v.start for v in group] for group in (program.states, program.inputs,
                                                       program.parameters))  # fmt: skip
    outputs = form.outputs(0.0, x, u, p, form.constants(p))
    values = dict(zip([v.name for v in program.states], x, strict=True))
    return values | dict(zip([v.name for v in program.outputs], outputs, strict=True))


def planar_scene(model: Model, program: Program | None = None) -> PlanarScene:
    """Scene of a planar `model` at the start values of `program`, its own if none is given."""
    program = program or model_program(model)
    starts = {parameter.name: parameter.start for parameter in program.parameters}
    made, numbers = _unmoved(model, starts)
    values = start_values(program)
    start = np.array([[values[f"body.{b}.{c}"] for c in ("x", "z", "theta")] for b in made.bodies])
    return replace(made, start=start, pushes=tuple(numbers.pushes(start)))


def unmoved_scene(model: Model, given: Mapping[str, float]) -> PlanarScene:
    """Scene of a planar `model` with all bodies at the origin, without loads on single points.

    Parameters that are not `given` have the values of the model.
    """
    return _unmoved(model, given)[0]


def _unmoved(model: Model, given: Mapping[str, float]) -> tuple[PlanarScene, _Numbers]:
    tree, values = topology(model), parameter_values(model.parameters)
    values.update((name, value) for name, value in given.items() if name in values)
    numbers = _Numbers(model, tree, values)
    depths: list[int] = []
    for link in tree.links:
        depths.append(1 + (depths[link.parent] if link.parent >= 0 else 0))
    made = PlanarScene(
        title=model.name,
        description=" ".join(model.description.split()),
        bodies=tuple(link.body for link in tree.links),
        depths=tuple(depths),
        joints=tuple(numbers.joints()),
        points={name: numbers.point(name) for name in model.points},
        ties=tuple(numbers.ties()),
        pushes=(),
        gravity=numbers.number(gravity_of(model)[2], default=1.0),
        start=np.zeros((len(tree.links), 3)),
    )
    return made, numbers


class _Numbers:
    """Quantities of a model as numbers, at the start."""

    def __init__(self, model: Model, tree: Topology, values: Values) -> None:
        self.model, self.tree, self.values = model, tree, values

    def number(self, quantity: Quantity, *, default: float = 0.0, time: float = 0.0) -> float:
        """The value at a time [s]; `default` where it depends on the motion."""
        known = Values({**self.values, "t": time})
        try:
            return float(as_expression(quantity).evaluate(known))
        except (KeyError, ArithmeticError, ValueError):
            return default

    def pair(self, vector: Vector) -> Pair:
        return self.number(vector[0]), self.number(vector[1])

    def point(self, name: str) -> Anchor:
        point = self.model.points[name]
        return Anchor(self.tree.index(point.body), self.pair(point.at))

    def joints(self) -> list[JointMark]:
        marks = []
        for k, link in enumerate(self.tree.links):
            joint = link.joint
            x, z = self.pair(joint.joint_to_child)
            direction = None
            if joint.direction is not None:
                dx, dz = self.pair(joint.direction)
                length = math.hypot(dx, dz)
                direction = (dx / length, dz / length)
            parent = Anchor(link.parent, self.pair(joint.parent_to_joint))
            child = Anchor(k, (-x, -z))
            marks.append(JointMark(link.joint_name, link.joint_type, parent, child, direction))
        return marks

    def ties(self) -> list[Tie]:
        """Loads between two points, and between two bodies at the joint that joins them."""
        found = []
        for name, load in self.model.loads.items():
            if hasattr(load, "points"):
                first, second = (self.point(end) for end in load.points)
                found.append(Tie(name, load.type, (first, second)))
            elif hasattr(load, "bodies"):
                first, second = (self.tree.index(body) for body in load.bodies)
                found.append(Tie(name, load.type, self._hinge(first, second)))
        return found

    def _hinge(self, first: int, second: int) -> tuple[Anchor, Anchor]:
        """Where two bodies are joined; their centres of gravity if they are not."""
        for mark in self.joints():
            pair = {mark.parent.body, mark.child.body}
            if not mark.type.is_free and pair == {first, second}:
                ends = (mark.parent, mark.child)
                return ends if ends[0].body == first else (ends[1], ends[0])
        return Anchor(first, (0.0, 0.0)), Anchor(second, (0.0, 0.0))

    def pushes(self, start: np.ndarray) -> list[Push]:
        """Forces and moments, in the direction that they have when they are first not zero."""
        found = []
        for name, load in self.model.loads.items():
            if isinstance(load, JointEffort):
                found.append(self._effort(name, load, start))
            if not hasattr(load, "force"):
                continue
            if hasattr(load, "point"):
                at = self.point(load.point)
            else:
                at = Anchor(self.tree.index(load.body), (0.0, 0.0))  # pyrefly: ignore[missing-attribute]
            direction = self._direction(load.force)
            if direction is not None:
                if getattr(load, "axes", "world") == "body" and at.body >= 0:
                    x, z = turned(direction, start[at.body, 2])
                    direction = (float(x), float(z))
                found.append(Push(name, at, direction))
            moment = getattr(load, "moment", 0.0)
            if any(self.number(moment, default=1.0, time=t) for t in (0.0, 0.37, 1.1)):
                found.append(Push(name, at, None))
        return found

    def _effort(self, name: str, load: JointEffort, start: np.ndarray) -> Push:
        """A joint's effort on its child: along the direction of a slide, or a moment."""
        mark = next(mark for mark in self.joints() if mark.name == load.joint)
        if mark.direction is None:
            return Push(name, mark.child, None)
        turn = start[mark.parent.body, 2] if mark.parent.body >= 0 else 0.0
        x, z = turned(mark.direction, turn)
        sign = -1.0 if self.number(load.effort, default=1.0) < 0 else 1.0
        return Push(name, mark.child, (float(sign * x), float(sign * z)))

    def _direction(self, force: Vector) -> Pair | None:
        for time in (0.0, 0.37, 1.1):
            x, z = (self.number(part, default=1.0, time=time) for part in force)
            length = math.hypot(x, z)
            if 0 < length < math.inf:
                return x / length, z / length
        return None
