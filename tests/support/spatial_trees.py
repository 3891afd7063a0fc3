"""Random trees in space, and their accelerations from positions alone, to any number of digits.

The reference knows how bodies are placed and nothing else. Velocities and accelerations are
difference quotients in mpmath along a path of the coordinates, and Newton's and Euler's equations
of all bodies are projected on the velocities of the joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import mpmath
from support.planar_trees import DIGITS, STEP, Numbers

from m4e_fmi.model import (
    Body,
    BodyDrag,
    BodyForce,
    Bushing,
    Joint,
    JointEffort,
    JointFriction,
    JointStop,
    Model,
    Point,
    PointDrag,
    PointForce,
    TensionDamper,
    TensionSpring,
    TensionStop,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.loads import Load
from m4e_fmi.multibody import Topology, topology

__all__ = ["DIGITS", "SpatialReference", "spatial_tree"]

KINDS = ("revolute", "prismatic", "spherical", "universal", "cylindrical", "planar", "fixed")
COORDINATES = {"revolute": 1, "prismatic": 1, "universal": 2, "cylindrical": 2, "planar": 3}
"""Of the joints on which efforts can act."""
Vector = Any
"""A column (3, 1) of mpmath's."""


def spatial_tree(
    seed: int, *, size: int, loads: bool = True, wet: int = 0, kinds: Sequence[str] = KINDS
) -> Model:
    """A tree of `size` bodies with joints of these `kinds`, axes and inertias of any direction.

    `wet` of the bodies have added mass. If quaternions are among the kinds some bodies float.
    """
    numbers = Numbers(seed)
    r, between = numbers.random, numbers.between

    def vector() -> tuple[str, str, str]:
        return between(-1, 1), between(-1, 1), between(-1, 1)

    bodies: dict[str, Body] = {}
    joints: dict[str, Joint] = {}
    wet_bodies = set(r.sample(range(size), k=wet))
    for k in range(size):
        name, parent = f"b{k}", r.choice(["ground", *bodies, *list(bodies)[-3:]])
        diagonal = between(1, 1.5), between(1, 1.5), between(1, 1.5)
        products = between(-0.1, 0.1), between(-0.1, 0.1), between(-0.1, 0.1)
        inertia = (*diagonal, *products) if r.random() < 0.7 else diagonal
        bodies[name] = Body(between(0.5, 2), inertia, added_mass=k in wet_bodies)
        if "spherical" in kinds and r.random() < 0.15:
            joints[f"j{k}"] = Joint("floating", name)
            continue
        kind = r.choice(kinds if k else [kind for kind in kinds if kind != "fixed"])
        more: dict[str, Any] = {}
        if kind == "prismatic":
            more["direction"] = vector()
        if kind in ("revolute", "universal", "cylindrical"):
            plain = r.choice([(0.0, 1.0, 0.0), (0.0, 0.0, 2.0), (-1.0, 0.0, 0.0)])
            more["axis"] = vector() if r.random() < 0.6 else plain
        if kind == "universal":
            more["second_axis"] = vector()
        if kind == "planar":
            x, y, z = vector()
            more |= {"axis": (x, y, z), "direction": (y, f"-{x}", 0.0)}
        joints[f"j{k}"] = Joint(kind, name, parent, vector(), vector(), **more)
    points = {f"p{k}": Point(r.choice([*bodies, "ground"]), vector()) for k in range(4)}
    points["anchor"] = Point("ground", (30.0, 40.0, -20.0))
    return Model(
        name=f"tree{seed}",
        bodies=bodies,
        joints=joints,
        points=points,
        loads=_loads(numbers, bodies, joints) if loads else {},
        parameters=numbers.parameters,
        gravity=r.choice([between(9, 10), vector()]),
        dimensions=3,
    )


def _loads(
    numbers: Numbers, bodies: Mapping[str, Body], joints: Mapping[str, Joint]
) -> dict[str, Load]:
    r, between = numbers.random, numbers.between

    def vector() -> tuple[str, str, str]:
        return between(-1, 1), between(-1, 1), between(-1, 1)

    first, second = r.choice([*bodies]), r.choice(["ground", *bodies])
    pair = (first, second if second != first else "ground")
    loads: dict[str, Load] = {
        "spring": TensionSpring(("p0", "anchor"), between(1, 2), between(50, 60)),
        "rubber": TensionSpring(("p1", "anchor"), length=between(50, 60), law="0.1*l + 0.01*l**3"),
        "damper": TensionDamper(("p2", "anchor"), between(0.1, 0.5)),
        "rope": TensionStop(("p3", "anchor"), between(1, 2), None, between(40, 50), 0.3),
        "foot": Bushing(("p2", "p3"), between(0.1, 1), between(0.1, 1)),
        "coil": TorsionSpring(pair, between(0.1, 2)),
        "oil": TorsionDamper(pair, between(0.1, 2)),
        "push": PointForce("p0", vector(), r.choice(["world", "body"])),
        "steer": BodyForce(first, vector(), vector(), r.choice(["world", "body"])),
        "keel": BodyDrag(first, between(0.1, 1), between(0.1, 1), vector()),
        "sail": PointDrag("p1", between(0.1, 1), vector()),
    }
    driven = [name for name, joint in joints.items() if joint.type in COORDINATES]
    if driven:
        name = r.choice(driven)
        count = COORDINATES[joints[name].type]
        along = [f"q{r.randint(1, count)}" if count > 1 else "" for _ in range(3)]
        own = f"joint.{name}.{along[0] or 'q'}"
        loads["motor"] = JointEffort(name, f"0.3*{own} + {between(-1, 1)}", along[0])
        loads["rub"] = JointFriction(name, between(0.1, 1), between(0.1, 1), along[1])
        loads["hit"] = JointStop(name, between(1, 2), -0.2, 0.2, between(0.1, 0.5), along[2])
    kept = r.sample(sorted(loads), k=min(len(loads), 8))
    return {name: load for name, load in loads.items() if name in kept}


def column(parts: Sequence[Any]) -> Vector:
    return mpmath.matrix(list(parts))


def crossed(a: Vector, b: Vector) -> Vector:
    return column([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def inner(a: Vector, b: Vector) -> Any:
    return sum(x * y for x, y in zip(a, b, strict=True))


def length(a: Vector) -> Any:
    return mpmath.sqrt(inner(a, a))


def exponential(turn: Vector) -> Any:
    """The rotation matrix of a rotation vector [rad]."""
    angle = length(turn)
    if angle == 0:
        return mpmath.eye(3)
    x, y, z = (part / angle for part in turn)
    K = mpmath.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return mpmath.eye(3) + mpmath.sin(angle) * K + (1 - mpmath.cos(angle)) * (K * K)


def axial(M: Any) -> Vector:
    """The vector of the skew-symmetric part of a matrix."""
    return column([M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]]) / 2


def of_quaternion(e: Sequence[Any]) -> Any:
    """By e v e⁻¹ of the three axes."""
    square = sum(part * part for part in e)
    scalar, v = e[0], column(e[1:])
    columns = []
    for axis in range(3):
        unit = column([mpmath.mpf(axis == c) for c in range(3)])
        t = 2 * crossed(v, unit)
        columns.append(unit + (scalar * t + crossed(v, t)) / square)
    return mpmath.matrix(3, 3) + mpmath.matrix(
        [[columns[j][i] for j in range(3)] for i in range(3)]
    )


class SpatialReference:
    """A model in a state given by a program's variable names; numbers are mpmath's."""

    def __init__(self, model: Model, values: Mapping[str, Any]) -> None:
        self.model, self.given = model, values
        self.tree: Topology = topology(model)
        self.parameters = {
            name: mpmath.mpf(values.get(name, p.value)) for name, p in model.parameters.items()
        }
        self.q: list[Any] = []
        self.u: list[Any] = []
        for link in self.tree.links:
            free = link.joint.type == "floating"
            owner = f"body.{link.body}" if free else f"joint.{link.joint_name}"
            self.q += [self.value(f"{owner}.{n}") for n in link.joint_type.positions]
            self.u += [self.value(f"{owner}.{n}") for n in link.joint_type.velocities]
        self.n = len(self.u)
        links = enumerate(self.tree.links)
        self.wet = [k for k, link in links if model.bodies[link.body].added_mass]
        self.now = self.poses(self.u, None, mpmath.mpf(0))

    def value(self, name: str) -> Any:
        return mpmath.mpf(self.given.get(name, 0.0))

    def number(self, quantity: Any) -> Any:
        if isinstance(quantity, str) and quantity.startswith("-"):
            return -self.number(quantity[1:])
        named = self.parameters.get(quantity) if isinstance(quantity, str) else None
        return mpmath.mpf(quantity) if named is None else named

    def vector(self, parts: Any) -> Vector:
        if len(parts) == 2:
            return column([mpmath.mpf(0)] * 3)
        return column([self.number(part) for part in parts])

    def unit(self, parts: Any) -> Vector:
        found = self.vector(parts)
        return found / length(found)

    def poses(self, u: Sequence[Any], rate: Sequence[Any] | None, h: Any) -> list[tuple[Any, Any]]:
        """Place of the CG and rotation of every link, h s from now at velocities `u`."""
        rates = rate or [mpmath.mpf(0)] * self.n
        moved = [h * v + h * h / 2 * a for v, a in zip(u, rates, strict=True)]
        found: list[tuple[Any, Any]] = []
        for link in self.tree.links:
            q = [self.q[k] for k in link.coordinates]
            d = [moved[k] for k in link.speeds]
            here = (self.vector((0, 0, 0)), mpmath.eye(3))
            found.append(self._pose(link, found[link.parent] if link.parent >= 0 else here, q, d))
        return found

    def _pose(self, link: Any, parent: tuple[Any, Any], q: list[Any], d: list[Any]) -> Any:
        joint, kind = link.joint, link.joint.type
        place, R = parent
        if kind == "floating":
            turned = exponential(column(d[3:])) * of_quaternion(q[3:])
            return column([q[k] + d[k] for k in range(3)]), turned
        hold = place + R * self.vector(joint.parent_to_joint)
        angles: list[tuple[Any, Any]] = []
        if kind == "prismatic":
            hold += (q[0] + d[0]) * (R * self.unit(joint.direction))
        elif kind == "cylindrical":
            hold += (q[0] + d[0]) * (R * self.unit(joint.axis))
            angles = [(joint.axis, q[1] + d[1])]
        elif kind == "planar":
            first = self.unit(joint.direction)
            hold += (q[0] + d[0]) * (R * first)
            hold += (q[1] + d[1]) * (R * crossed(self.unit(joint.axis), first))
            angles = [(joint.axis, q[2] + d[2])]
        elif kind == "revolute":
            angles = [(joint.axis, q[0] + d[0])]
        elif kind == "universal":
            angles = [(joint.axis, q[0] + d[0]), (joint.second_axis, q[1] + d[1])]
        elif kind == "spherical":
            R = exponential(column(d)) * of_quaternion(q)
        for axis, angle in angles:
            R = R * exponential(angle * self.unit(axis))
        return hold + R * self.vector(joint.joint_to_child), R

    def point(self, name: str, poses: list[tuple[Any, Any]]) -> Vector:
        point = self.model.points[name]
        k = self.tree.index(point.body)
        at = self.vector(point.at)
        return at if k < 0 else poses[k][0] + poses[k][1] * at

    def along(self, u: Sequence[Any]) -> tuple[list[tuple[Any, Any]], list[tuple[Any, Any]]]:
        """Poses a step ahead and a step behind at velocities `u`."""
        return self.poses(u, None, STEP), self.poses(u, None, -STEP)

    @cached_property
    def course(self) -> tuple[list[tuple[Any, Any]], list[tuple[Any, Any]]]:
        """Poses a step ahead and a step behind."""
        return self.along(self.u)

    @cached_property
    def motion(self) -> list[Any]:
        """(v, ω) of every CG."""
        return self.velocities(self.u)

    def velocities(self, u: Sequence[Any]) -> list[Any]:
        """(v, ω) of every CG, one after the other."""
        ahead, behind = self.along(u)
        found: list[Any] = []
        for (p, R), (q, S), (_, now) in zip(ahead, behind, self.now, strict=True):
            found += [*((p - q) / (2 * STEP)), *(axial((R - S) * now.T) / (2 * STEP))]
        return found

    def bias(self) -> list[Any]:
        """(a, α) of every CG while no velocity of a joint changes."""
        ahead, behind = self.course
        found: list[Any] = []
        for (p, R), (q, S), (x, now) in zip(ahead, behind, self.now, strict=True):
            found += [*((p - 2 * x + q) / STEP**2), *(axial((R - 2 * now + S) * now.T) / STEP**2)]
        return found

    @cached_property
    def tensors(self) -> list[Any]:
        """Moments of inertia of every link, in world axes."""
        found = []
        for link, (_, R) in zip(self.tree.links, self.now, strict=True):
            inertia: Any = self.model.bodies[link.body].inertia
            xx, yy, zz, xy, yz, zx = [*map(self.number, inertia), 0, 0, 0][:6]
            found.append(R * mpmath.matrix([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) * R.T)
        return found

    def accelerations(self) -> list[Any]:
        """u̇."""
        units = [[mpmath.mpf(i == j) for i in range(self.n)] for j in range(self.n)]
        B = [self.velocities(unit) for unit in units]
        M, right = mpmath.matrix(self.n, self.n), mpmath.matrix(self.n, 1)
        rest = self.needed(self.bias())
        wrenches, efforts = self.wrenches()
        moved = [self.inertial(part) for part in B]
        for i in range(self.n):
            right[i] = efforts[i] + inner(
                B[i], [f - m for f, m in zip(wrenches, rest, strict=True)]
            )
            for j in range(self.n):
                M[i, j] = inner(B[i], moved[j])
        return list(mpmath.lu_solve(M, right))

    def inertial(self, motion: Sequence[Any]) -> list[Any]:
        """𝓜 times a motion of all bodies."""
        found: list[Any] = []
        for k, link in enumerate(self.tree.links):
            mass = self.number(self.model.bodies[link.body].mass)
            a, alpha = motion[6 * k : 6 * k + 3], column(motion[6 * k + 3 : 6 * k + 6])
            found += [*(mass * part for part in a), *(self.tensors[k] * alpha)]
        moved = [motion[6 * k + c] for k in self.wet for c in range(6)]
        for row, (k, c) in enumerate(((k, c) for k in self.wet for c in range(6)), start=1):
            entries = (self.value(f"added_mass[{row},{j}]") for j in range(1, len(moved) + 1))
            found[6 * k + c] += inner(list(entries), moved)
        return found

    def needed(self, motion: Sequence[Any]) -> list[Any]:
        """The wrenches about the CGs that Newton and Euler ask for at accelerations `motion`."""
        found, moving = self.inertial(motion), self.motion
        for k in range(len(self.tree.links)):
            omega = column(moving[6 * k + 3 : 6 * k + 6])
            for axis, part in enumerate(crossed(omega, self.tensors[k] * omega)):
                found[6 * k + 3 + axis] += part
        return found

    def wrenches(self) -> tuple[list[Any], list[Any]]:
        """(F, M) on every CG, and efforts along the velocities of joints."""
        total = [mpmath.mpf(0)] * (6 * len(self.tree.links))
        efforts = [mpmath.mpf(0)] * self.n
        gravity = self.model.gravity
        if isinstance(gravity, tuple):
            g = self.vector(gravity)
        else:
            g = column([0, 0, -self.number(gravity)])
        for link in self.tree.links:
            body = f"body.{link.body}"
            mass = self.number(self.model.bodies[link.body].mass)
            force = [self.value(f"{body}.force_{axis}") for axis in "xyz"]
            moment = [self.value(f"{body}.moment_{axis}") for axis in "xyz"]
            self._push(total, link.body, mass * g + column(force), column(moment))
            count = COORDINATES.get(link.joint.type, 0)
            for k in range(count):
                effort = f"joint.{link.joint_name}.effort{k + 1 if count > 1 else ''}"
                efforts[link.speeds[k]] += self.value(effort)
        for name in self.model.points:
            force = [self.value(f"point.{name}.force_{axis}") for axis in "xyz"]
            self._push_at(total, name, column(force))
        for load in self.model.loads.values():
            self._add(load, total, efforts)
        return total, efforts

    def _push(self, total: list[Any], body: str, force: Vector, moment: Vector) -> None:
        k = self.tree.index(body)
        if k >= 0:
            for axis in range(3):
                total[6 * k + axis] += force[axis]
                total[6 * k + 3 + axis] += moment[axis]

    def _push_at(self, total: list[Any], point: str, force: Vector) -> None:
        body = self.model.points[point].body
        k = self.tree.index(body)
        if k >= 0:
            arm = self.point(point, self.now) - self.now[k][0]
            self._push(total, body, force, crossed(arm, force))

    def _moving(self, point: str) -> tuple[Vector, Vector]:
        ahead, behind = self.course
        rate = (self.point(point, ahead) - self.point(point, behind)) / (2 * STEP)
        return self.point(point, self.now), rate

    def _turning(self, body: str) -> tuple[Any, Vector]:
        k = self.tree.index(body)
        if k < 0:
            return mpmath.eye(3), column([0, 0, 0])
        return self.now[k][1], column(self.motion[6 * k + 3 : 6 * k + 6])

    def _add(self, load: Load, total: list[Any], efforts: list[Any]) -> None:
        n = self.number
        match load:
            case TensionSpring() | TensionDamper() | TensionStop() | Bushing():
                (a, va), (b, vb) = map(self._moving, load.points)
                line, apart = b - a, vb - va
                if isinstance(load, Bushing):
                    force = n(load.stiffness) * line + n(load.damping) * apart
                else:
                    distance = length(line)
                    rate = inner(apart, line) / distance
                    force = self._tension(load, distance, rate) / distance * line
                self._push_at(total, load.points[0], force)
                self._push_at(total, load.points[1], -force)
            case TorsionSpring() | TorsionDamper():
                (R, w), (S, v) = map(self._turning, load.bodies)
                if isinstance(load, TorsionSpring):
                    moment = n(load.stiffness) * self._rotation_vector(S * R.T)
                else:
                    moment = n(load.damping) * (v - w)
                nothing = column([0, 0, 0])
                self._push(total, load.bodies[0], nothing, moment)
                self._push(total, load.bodies[1], nothing, -moment)
            case PointForce():
                R, _ = self._turning(self.model.points[load.point].body)
                force = self.vector(load.force)
                self._push_at(total, load.point, R * force if load.axes == "body" else force)
            case BodyForce():
                R, _ = self._turning(load.body)
                turn = R if load.axes == "body" else mpmath.eye(3)
                force, moment = self.vector(load.force), self.vector(load.moment)
                self._push(total, load.body, turn * force, turn * moment)
            case BodyDrag():
                k = self.tree.index(load.body)
                v = column(self.motion[6 * k : 6 * k + 3]) - self.vector(load.flow)
                w = self._turning(load.body)[1]
                force = -n(load.coefficient) * length(v) * v
                self._push(total, load.body, force, -n(load.moment_coefficient) * length(w) * w)
            case PointDrag():
                v = self._moving(load.point)[1] - self.vector(load.flow)
                self._push_at(total, load.point, -n(load.coefficient) * length(v) * v)
            case JointEffort() | JointFriction() | JointStop():
                link = self.tree.links[self.tree.index(self.model.joints[load.joint].child)]
                k = int(load.along[1:]) - 1 if load.along else 0
                q, u = self.q[link.coordinates[k]], self.u[link.speeds[k]]
                efforts[link.speeds[k]] += self._effort(load, q, u)
            case _:
                raise AssertionError(load)

    def _tension(self, load: Load, distance: Any, rate: Any) -> Any:
        n = self.number
        match load:
            case TensionSpring(law=None):
                return n(load.stiffness) * (distance - n(load.length))
            case TensionSpring():
                extension = distance - n(load.length)
                return mpmath.mpf(0.1) * extension + mpmath.mpf(0.01) * extension**3
            case TensionDamper():
                return n(load.damping) * rate
            case TensionStop():
                depth = max(mpmath.mpf(0), distance - n(load.upper))
                back = n(load.stiffness) * depth
                return back + min(max(n(load.damping) * rate, -back), back)
            case _:
                raise AssertionError(load)

    def _effort(self, load: Load, q: Any, u: Any) -> Any:
        n = self.number
        match load:
            case JointEffort():
                return mpmath.mpf(0.3) * q + n(str(load.effort).split("+ ")[1])
            case JointFriction():
                return -n(load.effort) * mpmath.tanh(u / n(load.velocity))
            case JointStop():
                total = mpmath.mpf(0)
                for limit, side in ((load.upper, 1), (load.lower, -1)):
                    depth = max(mpmath.mpf(0), side * (q - n(limit)))
                    back = n(load.stiffness) * depth
                    total -= side * (back + min(max(n(load.damping) * side * u, -back), back))
                return total
            case _:
                raise AssertionError(load)

    def _rotation_vector(self, M: Any) -> Vector:
        vector = axial(M)
        sine = length(vector)
        cosine = (M[0, 0] + M[1, 1] + M[2, 2] - 1) / 2
        return mpmath.atan2(sine, cosine) / sine * vector if sine else vector

    def input_power(self) -> Any:
        """Power of forces, moments and efforts from outside."""
        whole, efforts = self.wrenches()
        quiet = SpatialReference(self.model, {k: v for k, v in self.given.items() if not _acts(k)})
        own, rest = quiet.wrenches()
        along = self.motion
        pairs = zip(whole, own, along, strict=True)
        return sum((a - b) * v for a, b, v in pairs) + sum(
            (a - b) * v for a, b, v in zip(efforts, rest, self.u, strict=True)
        )


def _acts(name: str) -> bool:
    return ".effort" in name or ".force_" in name or ".moment_" in name
