"""Accelerations of a Chrono model in space by another formulation: all bodies free.

Newton's and Euler's equations of every body about its centre of gravity, and the second derivative
of the constraints as Chrono writes them (ChLinkLock, ChLinkUniversal), are solved together. Forces
are those of ChLinkTSDA, ChLinkRSDA, ChLinkMotor… and ChLoadBody…. Reads the data of a file by
itself and uses nothing of m4e_fmi.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

Array = np.ndarray
cross = np.cross


@dataclass
class State:
    """A body: CG (3,) [m], centroidal axes (3, 3), velocities (3,) [m/s, rad/s] in world axes."""

    place: Array
    axes: Array
    velocity: Array
    omega: Array


FIXED = State(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))


class ChronoInSpace:
    """Bodies, joints and forces of one file."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.model = data["model"]
        self.gravity = np.array(data["simulation"]["gravity"], float)
        self.degrees = self.model.get("angle_degrees", True)
        self.bodies = {b["name"]: b for b in self.model["bodies"] if not b.get("fixed")}
        self.start = {name: self._start(body) for name, body in self.bodies.items()}

    def _start(self, body: Mapping[str, Any]) -> State:
        frame, com = self._rotation(body.get("orientation")), body.get("com", {})
        place = np.array(body["location"]) + frame @ np.array(com.get("location", (0, 0, 0)))
        axes = frame @ self._rotation(com.get("orientation"))
        velocity = np.array(body.get("initial_linear_velocity", (0, 0, 0)), float)
        omega = axes @ np.array(body.get("initial_angular_velocity", (0, 0, 0)), float)
        return State(place, axes, velocity, omega)

    def _rotation(self, given: Any) -> Array:
        if given is None:
            return np.eye(3)
        if len(given) == 4:
            return Rotation.from_quat(given, scalar_first=True).as_matrix()
        return Rotation.from_euler("ZYX", given, degrees=self.degrees).as_matrix()

    def residuals(self, now: Mapping[str, State], rates: Array | None = None) -> Array:
        """Constraints at a state; with `rates` (6N,) their second derivative for accelerations."""
        found: list[float] = []
        for joint in self._joints():
            ends = [self._end(joint[key], now, rates) for key in ("body1", "body2")]
            starts = [self.start.get(joint[key], FIXED) for key in ("body1", "body2")]
            first, second = (
                _Marker(end, start, np.array(joint["location"]), _frame(joint))
                for end, start in zip(ends, starts, strict=True)
            )
            found += _constraints(joint["type"], first, second, rates is None)
        return np.array(found)

    def _joints(self) -> list[dict[str, Any]]:
        motors = [
            m | {"type": {"CYLINDRICAL": "CYLINDRICAL"}.get(m.get("spindle", ""), "REVOLUTE")}
            if m["type"] == "ROTATION"
            else m | {"type": "PRISMATIC"}
            for m in self.model.get("motors", [])
            if "FREE" not in (m.get("guide"), m.get("spindle"))
        ]
        return [*self.model.get("joints", []), *motors]

    def _end(
        self, name: str, now: Mapping[str, State], rates: Array | None
    ) -> tuple[State, Array, Array]:
        if name not in now:
            return FIXED, np.zeros(3), np.zeros(3)
        k = 6 * list(self.bodies).index(name)
        own = np.zeros(6) if rates is None else rates[k : k + 6]
        return now[name], own[:3], own[3:]

    def accelerations(self, now: Mapping[str, State], t: float) -> dict[str, Array]:
        """Acceleration of the CG and angular acceleration (6,) of each body, in world axes."""
        size = 6 * len(self.bodies)
        mass, force = np.zeros((size, size)), np.zeros(size)
        for k, (name, body) in enumerate(self.bodies.items()):
            axes, omega = now[name].axes, now[name].omega
            (xx, yy, zz), (xy, xz, yz) = (
                body["inertia"]["moments"],
                body["inertia"].get("products", (0, 0, 0)),
            )
            tensor = axes @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ axes.T
            i = 6 * k
            mass[i : i + 3, i : i + 3] = body["mass"] * np.eye(3)
            mass[i + 3 : i + 6, i + 3 : i + 6] = tensor
            force[i : i + 3] = body["mass"] * self.gravity
            force[i + 3 : i + 6] = -cross(omega, tensor @ omega)
        self._add_forces(now, force, t)
        bias = self.residuals(now, np.zeros(size))
        jacobian = np.array([self.residuals(now, e) - bias for e in np.eye(size)]).reshape(size, -1)
        count = len(bias)
        whole = np.block([[mass, jacobian], [jacobian.T, np.zeros((count, count))]])
        solved = np.linalg.lstsq(whole, np.concatenate([force, -bias]), rcond=None)[0]
        return {name: solved[6 * k : 6 * k + 6] for k, name in enumerate(self.bodies)}

    def _add_forces(self, now: Mapping[str, State], total: Array, t: float) -> None:
        def push(name: str, force: Array, moment: Array, at: Array | None = None) -> None:
            if name in now:
                k = 6 * list(self.bodies).index(name)
                arm = np.zeros(3) if at is None else at - now[name].place
                total[k : k + 3] += force
                total[k + 3 : k + 6] += moment + cross(arm, force)

        none = np.zeros(3)
        for spring in self.model.get("tsdas", []):
            ends = [self._carried(spring[f"body{k}"], spring[f"point{k}"], now) for k in (1, 2)]
            (p1, v1), (p2, v2) = ends
            length = float(np.linalg.norm(p1 - p2))
            along = (p1 - p2) / length
            size = _resistance(
                spring, length, spring.get("free_length", 0), float(along @ (v1 - v2))
            )
            push(spring["body1"], size * along, none, p1)
            push(spring["body2"], -size * along, none, p2)
        for spring in self.model.get("rsdas", []):
            one, two = (self._turned(spring[f"body{k}"], now) for k in (1, 2))
            frame = _perpendicular(spring["axis"])
            (f1, g1, axis), (f2, _, _) = (one @ frame).T, (two @ frame).T
            angle = np.arctan2(g1 @ f2, f1 @ f2)
            free = spring.get("free_angle", 0)
            free = np.radians(free) if self.degrees else free
            w1, w2 = (now.get(spring[f"body{k}"], FIXED).omega for k in (1, 2))
            torque = _resistance(spring, angle, free, axis @ (w2 - w1)) * axis
            push(spring["body1"], none, -torque)
            push(spring["body2"], none, torque)
        for motor in self.model.get("motors", []):
            axis = np.array(motor["axis"]) / np.linalg.norm(motor["axis"])
            size = _value(motor["actuation_function"], t, self.degrees)
            vector = size * (self._turned(motor["body2"], now) @ axis)
            if motor["type"] == "ROTATION":
                push(motor["body1"], none, vector)
                push(motor["body2"], none, -vector)
            else:
                at, _ = self._carried(motor["body1"], motor["location"], now)
                push(motor["body1"], vector, none, at)
                push(motor["body2"], -vector, none, at)
        for load in self.model.get("body_loads", []):
            own = now[load["body"]]
            vector = np.array(load["load"], float)
            vector = own.axes @ vector if load.get("local_load", True) else vector
            vector = vector * _value(load.get("modulation_function"), t, self.degrees)
            if load["type"] == "TORQUE":
                push(load["body"], none, vector)
            else:
                arm = own.axes @ np.array(load.get("point", (0, 0, 0)))
                push(load["body"], vector, none, own.place + arm)

    def _turned(self, name: str, now: Mapping[str, State]) -> Array:
        """The rotation (3, 3) of a body since the start."""
        return now[name].axes @ self.start[name].axes.T if name in now else np.eye(3)

    def _carried(self, name: str, point: Any, now: Mapping[str, State]) -> tuple[Array, Array]:
        """Place and velocity of what was at a point of a body at the start."""
        start, own = self.start.get(name, FIXED), now.get(name, FIXED)
        arm = self._turned(name, now) @ (np.array(point) - start.place)
        return own.place + arm, own.velocity + cross(own.omega, arm)


class _Marker:
    """A frame fixed in a body: where it is, how it moves, and its axes and their rates."""

    def __init__(
        self, end: tuple[State, Array, Array], start: State, at: Array, frame: Array
    ) -> None:
        state, acceleration, self.alpha = end
        turn = state.axes @ start.axes.T
        arm, self.omega = turn @ (at - start.place), state.omega
        self.axes = (turn @ frame).T
        self.place = state.place + arm
        self.velocity = state.velocity + cross(self.omega, arm)
        self.acceleration = self._second(arm) + acceleration

    def _second(self, arm: Array) -> Array:
        return cross(self.alpha, arm) + cross(self.omega, cross(self.omega, arm))

    def rates(self, k: int) -> tuple[Array, Array, Array]:
        """An axis with its first and second derivative."""
        axis = self.axes[k]
        return axis, cross(self.omega, axis), self._second(axis)


def _constraints(kind: str, first: _Marker, second: _Marker, position: bool) -> list[float]:
    """The constraints of a joint, or their second derivatives."""
    apart = (
        second.place - first.place,
        second.velocity - first.velocity,
        second.acceleration - first.acceleration,
    )
    normals = [first.rates(0), first.rates(1)]
    if kind in ("PRISMATIC", "CYLINDRICAL"):
        found = [_product(normal, apart, position) for normal in normals]
    else:
        found = list(apart[0] if position else apart[2])
    z2 = second.rates(2)
    if kind in ("REVOLUTE", "CYLINDRICAL"):
        found += [_product(normal, z2, position) for normal in normals]
    elif kind in ("LOCK", "PRISMATIC"):
        found += [_product(first.rates(k), second.rates((k + 1) % 3), position) for k in range(3)]
    elif kind == "UNIVERSAL":
        found.append(_product(first.rates(0), second.rates(1), position))
    return found


def _product(a: tuple[Array, ...], b: tuple[Array, ...], position: bool) -> float:
    """a · b, or its second derivative."""
    return float(a[0] @ b[0] if position else a[2] @ b[0] + 2 * a[1] @ b[1] + a[0] @ b[2])


def _frame(joint: Mapping[str, Any]) -> Array:
    """Axes of a joint's frame in its columns: Z along the axis, X and Y of a universal joint."""
    if joint["type"] != "UNIVERSAL":
        return _perpendicular(joint.get("axis", (0, 0, 1)))
    x = np.array(joint["axis1"], float)
    z = cross(x, joint["axis2"])
    columns = [x, cross(z, x), z]
    return np.array([column / np.linalg.norm(column) for column in columns]).T


def _perpendicular(axis: Any) -> Array:
    """A frame with this Z axis, in columns."""
    z = np.array(axis, float) / np.linalg.norm(axis)
    x = cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return np.array([x, cross(z, x), z]).T


def _resistance(spring: Mapping[str, Any], value: float, rest: float, rate: float) -> float:
    stiffness, damping = (spring.get(f"{k}_coefficient", 0) for k in ("spring", "damping"))
    return spring.get("preload", 0) - stiffness * (value - rest) - damping * rate


def _value(function: Any, t: float, degrees: bool) -> float:
    if function is None:
        return 1.0
    if function["type"] == "CONSTANT":
        return function["value"]
    phase = function.get("phase", 0)
    phase = np.radians(phase) if degrees else phase
    return function["amplitude"] * np.sin(2 * np.pi * function["frequency"] * t + phase)
