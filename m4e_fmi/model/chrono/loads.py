"""Springs, dampers, motors and loads from Chrono's.

Signs (Chrono's ChLinkTSDA, ChLinkRSDA, ChLinkMotorLinearForce, ChLinkMotorRotationTorque): a motor
acts with +F(t) along its axis on body1 and with −F(t) on body2, the axis being fixed in body2; the
angle of a rotational spring is that of body2 against body1, zero at the start; a preload pushes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from m4e_fmi.joints import Coordinate
from m4e_fmi.model.chrono.mechanism import Array, Branch, Mechanism, Vector3, unit
from m4e_fmi.model.chrono.names import fresh
from m4e_fmi.model.chrono.sections import (
    BodyLoadSection,
    FunctionSection,
    MotorSection,
    RsdaSection,
    TsdaSection,
)
from m4e_fmi.model.elements import GROUND, Axes, Point, Quantity, identifier
from m4e_fmi.model.loads import (
    BodyForce,
    JointEffort,
    Load,
    PointForce,
    TensionDamper,
    TensionSpring,
)
from m4e_fmi.model.table import Table

NEEDED = {
    "CONSTANT": "value",
    "POLYNOMIAL": "coefficients",
    "POLY": "coefficients",
    "SINE": "amplitude",
    "RAMP": "slope",
    "DATA": "data",
}
"""The key that a function of a type must have."""


class Loads:
    """Points, loads and tables of a Chrono model whose mechanism is known."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.model, self.places = mechanism.model, mechanism.places
        self.points: dict[str, Point] = {}
        self.loads: dict[str, Load] = {}
        self.tables: dict[str, Table] = {}

    def convert(self) -> None:
        """Fill `loads`, `points` and `tables` from all springs, dampers, motors and body loads."""
        for tsda in self.model.tsdas:
            self._tsda(tsda)
        for rsda in self.model.rsdas:
            self._rsda(rsda)
        for motor in self.model.motors:
            self._motor(motor)
        for load in self.model.body_loads:
            self._body_load(load)

    def _point(self, name: str, body: str, place: Sequence[float] | Array) -> str:
        """A new point of a body, at a place in the world at the start."""
        name = fresh(name, self.points)
        self.points[name] = Point(self._body(body), self.mechanism.at(body, place))
        return name

    def _body(self, body: str) -> str:
        holder = self.mechanism.holder(body)
        return holder if holder == GROUND else identifier(holder)

    def _add(self, name: str, load: Load) -> None:
        self.loads[fresh(name, self.loads)] = load

    def _tsda(self, tsda: TsdaSection) -> None:
        if not self._has_coefficients(tsda, "free_length"):
            return
        name = identifier(tsda.name)
        ends = (
            self._point(f"{name}_1", tsda.body1, tsda.point1),
            self._point(f"{name}_2", tsda.body2, tsda.point2),
        )
        stiffness, damping = tsda.spring_coefficient, tsda.damping_coefficient
        length = (tsda.free_length or 0.0) + self._shift(tsda)
        if stiffness or not damping:
            self._add(name, TensionSpring(ends, stiffness or 0.0, length))
        if damping:
            self._add(f"{name}_damper" if stiffness else name, TensionDamper(ends, damping))

    def _rsda(self, rsda: RsdaSection) -> None:
        """An effort about the hinge: Chrono's angle, that of body2 against body1, is its own."""
        if not self._has_coefficients(rsda, "free_angle"):
            return
        found = self.mechanism.freedom(rsda, "rad")
        if found is None:
            message = "a rotational spring or damper needs a hinge about its axis"
            remedy = "join its two bodies by a REVOLUTE joint with this axis, or use tsdas"
            self.places.say(rsda, message, ("axis",), remedy)
            return
        branch, own = found
        free = rsda.free_angle or 0.0
        free = (math.radians(free) if self.model.angle_degrees else free) + self._shift(rsda)
        joint = f"joint.{self.mechanism.joint_of[branch.child]}"
        rest = self.mechanism.angles[branch.child]
        rest += self._sense(branch, rsda.body2, rsda.axis) * free
        twist = f"{joint}.{own.position}" if rest == 0 else f"({joint}.{own.position} {-rest:+})"
        coefficients = (rsda.spring_coefficient, twist), (
            rsda.damping_coefficient, f"{joint}.{own.velocity}"
        )  # fmt: skip
        terms = [f"{value!r}*{motion}" for value, motion in coefficients if value]
        effort = f"-({' + '.join(terms)})" if terms else 0.0
        self._effort(identifier(rsda.name), branch, own, effort)

    def _has_coefficients(self, element: TsdaSection | RsdaSection, rest: str) -> bool:
        if element.spring_coefficient is None and element.damping_coefficient is None:
            message = f"{element.name!r} is neither spring nor damper"
            self.places.say(element, message, (), "add 'spring_coefficient: …'")
            return False
        if element.spring_coefficient and getattr(element, rest) is None:
            message = f"the spring {element.name!r} has no {rest}"
            self.places.say(element, message, (), f"add '{rest}: …'")
            return False
        return True

    def _shift(self, element: TsdaSection | RsdaSection) -> float:
        """By how much a preload lengthens a linear spring at rest."""
        if element.preload == 0:
            return 0.0
        if not element.spring_coefficient:
            remedy = "add a spring_coefficient, or write it as a body load"
            self.places.say(element, "a preload needs a spring", ("preload",), remedy)
            return 0.0
        return element.preload / element.spring_coefficient

    def _motor(self, motor: MotorSection) -> None:
        """An effort along or about a joint that is there; without one, against the ground."""
        effort = self._function(motor, motor.actuation_function, ("actuation_function",))
        linear, name = motor.type == "LINEAR", identifier(motor.name)
        found = self.mechanism.freedom(motor, "m" if linear else "rad")
        first, second = self.mechanism.ends(motor)
        if effort is None and found is None:
            message = "a controller's motor without a guide has no input in the FMU"
            remedy = "let it guide (PRISMATIC, REVOLUTE), or remove it and use the body's inputs"
            self.places.say(motor, message, ("actuation_function",), remedy)
        elif effort is None:
            return  # the FMU's input joint.<name>.effort is what the controller sets
        elif found is not None:
            branch, own = found
            sense = self._sense(branch, motor.body1, motor.axis)
            self._effort(name, branch, own, times(sense, effort))
        elif linear and second == GROUND:
            point = self._point(name, motor.body1, motor.location)
            self._add(name, PointForce(point, scaled(unit(motor.axis), effort)))
        elif not linear and second == GROUND:
            self._moment(name, first, scaled(unit(motor.axis), effort))
        elif not linear and first == GROUND:
            axis = self.mechanism.poses[second].local(unit(motor.axis))
            self._moment(name, second, scaled(axis, times(-1.0, effort)), "body")
        else:
            guide = "'guide: PRISMATIC'" if linear else "'spindle: REVOLUTE'"
            message = "a motor needs a joint along or about its axis, or the ground as body2"
            self.places.say(motor, message, ("axis",), f"let body2 be fixed, or use {guide}")

    def _sense(self, branch: Branch, body: str, axis: Vector3) -> float:
        """1 if an effort along `axis` on a body is one on the child along the joint's, or −1."""
        own = branch.joining.axis if branch.joining else None
        along = float(np.dot(own or axis, axis))
        return math.copysign(1.0, along if branch.child == self.mechanism.holder(body) else -along)

    def _effort(self, name: str, branch: Branch, own: Coordinate, effort: Quantity) -> None:
        """An effort on the child, along a coordinate of its joint."""
        along = own.position if len(branch.kind.coordinates) > 1 else ""
        self._add(name, JointEffort(self.mechanism.joint_of[branch.child], effort, along))

    def _body_load(self, load: BodyLoadSection) -> None:
        if self.mechanism.holder(load.body) == GROUND:
            return
        scale: Quantity | None = 1.0
        if load.modulation_function is not None:
            scale = self._function(load, load.modulation_function, ("modulation_function",))
        if scale is None:
            message = "a controller cannot modulate a load"
            remedy = "remove the load, and connect the controller to the body's inputs of the FMU"
            self.places.say(load, message, ("modulation_function",), remedy)
            return
        pose, name = self.mechanism.poses[load.body], identifier(load.name)
        own: Sequence[float] = load.load
        if load.local_load:
            own = pose.local(pose.axes @ load.load)
        axes: Axes = "body" if load.local_load else "world"
        if load.type == "TORQUE":
            self._moment(name, load.body, scaled(own, scale), axes)
        elif load.local_point:
            point = self._point(name, load.body, pose.place + pose.axes @ load.point)
            self._add(name, PointForce(point, scaled(own, scale), axes))
        else:
            message = "a force at a point that is fixed in space, on a body that moves"
            remedy = "give the point in body axes, and true"
            self.places.say(load, message, ("local_point",), remedy)

    def _moment(
        self, name: str, body: str, moment: tuple[Quantity, ...], axes: Axes = "world"
    ) -> None:
        self._add(name, BodyForce(self._body(body), (0.0, 0.0, 0.0), moment, axes))

    def _function(
        self, owner: MotorSection | BodyLoadSection, function: FunctionSection, at: tuple[str, ...]
    ) -> Quantity | None:
        """A function of the time as an expression or a table's name; None for a controller's."""
        needed = NEEDED.get(function.type, "type")
        if getattr(function, needed) is None:
            message = f"a function of type {function.type} needs {needed!r}"
            self.places.say(owner, message, at, f"add '{needed}: …'")
            return 0.0
        if function.type == "DATA":
            times_, values = zip(*(function.data or []), strict=True)
            name = fresh(identifier(owner.name), self.tables)
            self.tables[name] = Table(times_, values)
            return name
        return function_text(function, degrees=self.model.angle_degrees)


def function_text(function: FunctionSection, *, degrees: bool) -> Quantity | None:
    """An expression in t; None for a function of type CONTROLLER."""
    match function.type:
        case "CONSTANT":
            return function.value
        case "POLYNOMIAL" | "POLY":
            powers = ["", "*t", *(f"*t**{k}" for k in range(2, len(function.coefficients or [])))]
            pairs = zip(function.coefficients or [], powers, strict=False)
            terms = [f"{c!r}{power}" for c, power in pairs if c and power]
            constant = (function.coefficients or [0.0])[0]
            return " + ".join([repr(constant), *terms]) if terms else constant
        case "SINE":
            phase = math.radians(function.phase) if degrees else function.phase
            angle = f"{2 * math.pi * (function.frequency or 0.0)!r}*t"
            angle += f" + {phase!r}" if phase else ""
            return f"{function.amplitude or 0.0!r}*sin({angle})"
        case "RAMP":
            return f"{function.intercept!r} + {function.slope!r}*t"
        case "DATA" | "CONTROLLER":
            return None


def times(factor: float, quantity: Quantity) -> Quantity:
    """factor · quantity, as a number where it is one."""
    if isinstance(quantity, int | float):
        return factor * quantity
    if factor == 1 or factor == 0:
        return quantity if factor else 0.0
    return f"{factor!r}*({quantity})"


def scaled(vector: Sequence[float] | Array, quantity: Quantity) -> tuple[Quantity, ...]:
    """quantity · `vector` (3,) [N or N·m]."""
    return tuple(times(float(part), quantity) for part in vector)
