"""Springs, dampers, motors and loads from Chrono's.

Signs (Chrono's ChLinkTSDA, ChLinkRSDA, ChLinkMotorLinearForce, ChLinkMotorRotationTorque): a motor
acts with +F(t) along its axis on body1 and with −F(t) on body2, the axis being fixed in body2; the
angle of a rotational spring is that of body2 against body1, zero at the start; a preload pushes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from m4e_fmi.joints import Coordinate
from m4e_fmi.model.chrono.mechanism import Branch, Mechanism, unit
from m4e_fmi.model.chrono.names import Named, fresh
from m4e_fmi.model.chrono.rotation import Vector3
from m4e_fmi.model.chrono.sections import (
    BodyLoadSection,
    FunctionSection,
    MotorSection,
    RsdaSection,
    TsdaSection,
)
from m4e_fmi.model.elements import GROUND, Point, Quantity, identifier
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
HINGES = ("revolute", "cylindrical")
NOTHING = (0.0, 0.0, 0.0)


class Loads:
    """Points, loads and tables of a Chrono model whose mechanism is known.

    In space a moment between two moving bodies acts about the hinge that joins them.
    """

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

    def _name(self, body: str) -> str:
        holder = self.mechanism.holder(body)
        return holder if holder == GROUND else identifier(holder)

    def _point(self, name: str, body: str, place: Sequence[float]) -> str:
        """A new point of a body, at a place in the world at the start."""
        name = fresh(name, self.points)
        self.points[name] = Point(self._name(body), self.mechanism.at(body, place))
        return name

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
        if math.hypot(*rsda.axis) == 0:
            self.places.say(rsda, "the axis has no length", ("axis",), "give a vector")
        elif self._has_coefficients(rsda, "free_angle"):
            free = rsda.free_angle or 0.0
            free = math.radians(free) if self.model.angle_degrees else free
            self._twisted(rsda, identifier(rsda.name), free + self._shift(rsda))

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
        if math.hypot(*motor.axis) == 0:
            self.places.say(motor, "the axis has no length", ("axis",), "give a vector")
            return
        effort = self._function(motor, motor.actuation_function, ("actuation_function",))
        branch = self.mechanism.branch_of(motor)
        if effort is None and branch is None:
            message = "a controller's motor without a guide has no input in the FMU"
            remedy = "let it guide (PRISMATIC, REVOLUTE), or remove it and use the body's inputs"
            self.places.say(motor, message, ("actuation_function",), remedy)
        elif effort is None:
            return  # the FMU's input joint.<name>.effort is what the controller sets
        elif motor.type == "ROTATION":
            self._torque(motor, effort)
        elif branch is None:
            self._thrust(motor, effort)
        else:
            sense = self._sense(branch, motor.body1, motor.axis)
            self._effort(identifier(motor.name), branch, "m", times(sense, effort))

    def _sense(self, branch: Branch, body: str, axis: Vector3) -> float:
        """1 if an effort along `axis` on a body is one on the child along the joint's, or −1."""
        own = unit(branch.joining.axis if branch.joining else None)
        along = sum(a * b for a, b in zip(own, axis, strict=True))
        return math.copysign(1.0, along if branch.child == self.mechanism.holder(body) else -along)

    def _coordinate(self, branch: Branch, unit: str) -> Coordinate:
        """The coordinate of a branch's joint that has this unit."""
        coordinates = self.mechanism.kind(branch.joining).coordinates
        return next(c for c in coordinates if c.unit == unit)

    def _effort(self, name: str, branch: Branch, unit: str, effort: Quantity) -> None:
        """An effort on the child, along the coordinate of a joint that has this unit."""
        own, count = self._coordinate(branch, unit), self.mechanism.kind(branch.joining).coordinates
        joint = self.mechanism.joint_of[branch.child]
        self._add(name, JointEffort(joint, effort, own.position if len(count) > 1 else ""))

    def _thrust(self, motor: MotorSection, effort: Quantity) -> None:
        """A force without a guide, from the ground."""
        if self.mechanism.holder(motor.body2) != GROUND:
            message = "a force without a guide between two moving bodies cannot be represented"
            remedy = "let body2 be fixed, or use 'guide: PRISMATIC'"
            self.places.say(motor, message, ("body2",), remedy)
            return
        name = identifier(motor.name)
        force = scaled(self.mechanism.in_world(unit(motor.axis)), effort)
        self._add(name, PointForce(self._point(name, motor.body1, motor.location), force))

    def _body_load(self, load: BodyLoadSection) -> None:
        if self.mechanism.holder(load.body) == GROUND:
            return
        vector = load.load
        if load.local_load:
            vector = self.mechanism.centroidal(load.body, load.load)
        scale: Quantity | None = 1.0
        if load.modulation_function is not None:
            scale = self._function(load, load.modulation_function, ("modulation_function",))
        if scale is None:
            message = "a controller cannot modulate a load"
            remedy = "remove the load, and connect the controller to the body's inputs of the FMU"
            self.places.say(load, message, ("modulation_function",), remedy)
            return
        if load.type == "TORQUE":
            self._body_torque(load, vector, scale)
        else:
            self._body_force(load, vector, scale)

    def _body_force(self, load: BodyLoadSection, vector: Vector3, scale: Quantity) -> None:
        if not load.local_point:
            message = "a force at a point that is fixed in space, on a body that moves"
            self.places.say(
                load, message, ("local_point",), "give the point in body axes, and true"
            )
            return
        arm = self.mechanism.centroidal(load.body, load.point)
        place = [a + b for a, b in zip(self.mechanism.center(load.body), arm, strict=True)]
        own = self.mechanism.in_world(vector)
        if load.local_load:
            own = self.mechanism.in_body(load.body, vector)
        name = identifier(load.name)
        point = self._point(name, load.body, place)
        axes = "body" if load.local_load else "world"
        self._add(name, PointForce(point, scaled(own, scale), axes))

    def _function(
        self, owner: Named, function: FunctionSection, at: tuple[str, ...]
    ) -> Quantity | None:
        """A function of the time as an expression or a table's name; None for a controller's."""
        needed = NEEDED.get(function.type, "type")
        if getattr(function, needed) is None:
            message = f"a function of type {function.type} needs {needed!r}"
            self.places.say(owner, message, at, f"add '{needed}: …'")
            return 0.0
        if function.repeat is not None:
            message = "repeated functions are not read"
            remedy = "write the periods out, as a table (type: DATA)"
            self.places.say(owner, message, (*at, "repeat"), remedy)
        if function.type == "DATA":
            times_, values = zip(*(function.data or []), strict=True)
            name = fresh(identifier(owner.name), self.tables)
            self.tables[name] = Table(times_, values)
            return name
        return function_text(function, degrees=self.model.angle_degrees)

    def _twisted(self, rsda: RsdaSection, name: str, free: float) -> None:
        """An effort about the hinge: Chrono's angle, that of body2 against body1, is its own."""
        branch = self._hinge(rsda.body1, rsda.body2, rsda.axis)
        if branch is None:
            message = "a rotational spring or damper needs a hinge about its axis"
            remedy = "join its two bodies by a REVOLUTE joint with this axis, or use tsdas"
            self.places.say(rsda, message, ("axis",), remedy)
            return
        joint = f"joint.{self.mechanism.joint_of[branch.child]}"
        own = self._coordinate(branch, "rad")
        rest = self.mechanism.angles[branch.child]
        rest += self._sense(branch, rsda.body2, rsda.axis) * free
        twist = f"{joint}.{own.position}" if rest == 0 else f"({joint}.{own.position} {-rest:+})"
        coefficients = (rsda.spring_coefficient, twist), (
            rsda.damping_coefficient, f"{joint}.{own.velocity}"
        )  # fmt: skip
        terms = [f"{value!r}*{motion}" for value, motion in coefficients if value]
        self._effort(name, branch, "rad", f"-({' + '.join(terms)})" if terms else 0.0)

    def _torque(self, motor: MotorSection, effort: Quantity) -> None:
        name = identifier(motor.name)
        branch = self.mechanism.branch_of(motor) or self._hinge(
            motor.body1, motor.body2, motor.axis
        )
        if branch is not None:
            sense = self._sense(branch, motor.body1, motor.axis)
            self._effort(name, branch, "rad", times(sense, effort))
        elif self.mechanism.holder(motor.body2) == GROUND:
            self._moment(name, motor.body1, scaled(unit(motor.axis), effort))
        elif self.mechanism.holder(motor.body1) == GROUND:
            axis = self.mechanism.in_body(motor.body2, unit(motor.axis))
            self._moment(name, motor.body2, scaled(axis, times(-1.0, effort)), local=True)
        else:
            message = "a torque without a spindle between two moving bodies cannot be represented"
            remedy = "let body2 be fixed, or use 'spindle: REVOLUTE'"
            self.places.say(motor, message, ("spindle",), remedy)

    def _body_torque(self, load: BodyLoadSection, vector: Vector3, scale: Quantity) -> None:
        name = identifier(load.name)
        own = self.mechanism.in_body(load.body, vector) if load.local_load else vector
        self._moment(name, load.body, scaled(own, scale), local=load.local_load)

    def _moment(
        self, name: str, body: str, moment: tuple[Quantity, ...], *, local: bool = False
    ) -> None:
        axes = "body" if local else "world"
        self._add(name, BodyForce(self._name(body), NOTHING, moment, axes))

    def _hinge(self, body1: str, body2: str, axis: Vector3) -> Branch | None:
        """The joint that lets two bodies turn about an axis against each other, and no other."""
        ends = {self.mechanism.holder(body1), self.mechanism.holder(body2)}
        for branch in self.mechanism.branches:
            turns = self.mechanism.kind(branch.joining).name in HINGES
            if turns and self.mechanism.is_along(branch, ends, axis):
                return branch
        return None


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


def scaled(vector: Sequence[float], quantity: Quantity) -> tuple[Quantity, ...]:
    """quantity · vector."""
    return tuple(times(part, quantity) for part in vector)
