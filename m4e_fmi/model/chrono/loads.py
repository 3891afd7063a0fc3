"""Springs, dampers, motors and loads from Chrono's.

Signs (Chrono's ChLinkTSDA, ChLinkRSDA, ChLinkMotorLinearForce, ChLinkMotorRotationTorque): a motor
acts with +F(t) along its axis on body1 and with −F(t) on body2, the axis being fixed in body2; the
angle of a rotational spring is that of body2 against body1, zero at the start; a preload pushes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from m4e_fmi.model.chrono.bodies import SMALL, Mechanism, parallel, unit
from m4e_fmi.model.chrono.names import Named, Places, fresh, identifier
from m4e_fmi.model.chrono.rotation import Vector3, rotated, turned_back
from m4e_fmi.model.chrono.sections import (
    BodyLoadSection,
    FunctionSection,
    ModelSection,
    MotorSection,
    RsdaSection,
    TsdaSection,
)
from m4e_fmi.model.elements import GROUND, Point, Quantity
from m4e_fmi.model.loads import (
    BodyForce,
    JointEffort,
    Load,
    PointForce,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
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


class Loads:
    """Points, loads and tables of a Chrono model whose mechanism is known."""

    def __init__(self, model: ModelSection, mechanism: Mechanism, places: Places) -> None:
        self.model, self.mechanism, self.places = model, mechanism, places
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

    def _point(self, owner: Named, name: str, body: str, place: Sequence[float]) -> str:
        """A new point of a body, at a place in the world at the start."""
        pose = self.mechanism.poses[self.mechanism.holder(body)]
        if self._name(body) != GROUND and abs(place[1] - pose.place[1]) > SMALL:
            at = f"at Y = {place[1]:g}, but the centre of gravity at {pose.place[1]:g}"
            message = f"the point on {body!r} is {at}"
            self.places.say(owner, message, (), "let points lie in the plane of the bodies")
        name = fresh(name, self.points)
        self.points[name] = Point(self._name(body), pose.local(place))
        return name

    def _add(self, name: str, load: Load) -> None:
        self.loads[fresh(name, self.loads)] = load

    def _tsda(self, tsda: TsdaSection) -> None:
        if abs(tsda.point1[1] - tsda.point2[1]) > SMALL:
            message = "the two points lie in different planes: the line leaves the X–Z plane"
            self.places.say(tsda, message, ("point2",), "give both the same Y")
        if not self._has_coefficients(tsda, "free_length"):
            return
        name = identifier(tsda.name)
        ends = (
            self._point(tsda, f"{name}_1", tsda.body1, tsda.point1),
            self._point(tsda, f"{name}_2", tsda.body2, tsda.point2),
        )
        stiffness, damping = tsda.spring_coefficient, tsda.damping_coefficient
        length = (tsda.free_length or 0.0) + self._shift(tsda)
        if stiffness or not damping:
            self._add(name, TensionSpring(ends, stiffness or 0.0, length))
        if damping:
            self._add(f"{name}_damper" if stiffness else name, TensionDamper(ends, damping))

    def _rsda(self, rsda: RsdaSection) -> None:
        if not parallel(rsda.axis, (0, 1, 0)) or math.hypot(*rsda.axis) == 0:
            message = f"the axis {list(rsda.axis)} is not along Y"
            self.places.say(rsda, message, ("axis",), "turn the model so that it moves in X–Z")
        if not self._has_coefficients(rsda, "free_angle"):
            return
        name, ends = identifier(rsda.name), (self._name(rsda.body1), self._name(rsda.body2))
        stiffness, damping = rsda.spring_coefficient, rsda.damping_coefficient
        poses = [self.mechanism.poses[self.mechanism.holder(b)] for b in (rsda.body1, rsda.body2)]
        free = rsda.free_angle or 0.0
        free = math.radians(free) if self.model.angle_degrees else free
        rest = math.copysign(1.0, rsda.axis[1]) * (free + self._shift(rsda))
        if stiffness or not damping:
            angle = poses[1].angle - poses[0].angle + rest
            self._add(name, TorsionSpring(ends, stiffness or 0.0, angle))
        if damping:
            self._add(f"{name}_damper" if stiffness else name, TorsionDamper(ends, damping))

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
            axis = unit(branch.joining.axis if branch.joining else None)
            along = sum(a * b for a, b in zip(axis, unit(motor.axis), strict=True))
            sense = 1.0 if branch.child == self.mechanism.holder(motor.body1) else -1.0
            joint = self.mechanism.joint_of[branch.child]
            effort = times(math.copysign(sense, sense * along), effort)
            self._add(identifier(motor.name), JointEffort(joint, effort))

    def _torque(self, motor: MotorSection, effort: Quantity) -> None:
        if not parallel(motor.axis, (0, 1, 0)):
            message = f"the axis {list(motor.axis)} is not along Y"
            self.places.say(motor, message, ("axis",), "turn the model so that it moves in X–Z")
            return
        sense = math.copysign(1.0, motor.axis[1])
        ends = [(motor.body1, sense), (motor.body2, -sense)]
        moving = [(b, factor) for b, factor in ends if self.mechanism.holder(b) != GROUND]
        for suffix, (body, factor) in zip(("", "_back"), moving, strict=False):
            name = identifier(motor.name) + suffix
            self._add(name, BodyForce(self._name(body), moment=times(factor, effort)))

    def _thrust(self, motor: MotorSection, effort: Quantity) -> None:
        """A force without a guide, from the ground."""
        if self.mechanism.holder(motor.body2) != GROUND:
            message = "a force without a guide between two moving bodies cannot be represented"
            remedy = "let body2 be fixed, or use 'guide: PRISMATIC'"
            self.places.say(motor, message, ("body2",), remedy)
            return
        length = math.hypot(*motor.axis)
        if abs(motor.axis[1]) > SMALL * length:
            message = f"the axis {list(motor.axis)} leads out of the X–Z plane"
            self.places.say(motor, message, ("axis",), "turn the model so that it moves in X–Z")
        name = identifier(motor.name)
        force = tuple(times(motor.axis[k] / length, effort) for k in (0, 2))
        point = self._point(motor, name, motor.body1, motor.location)
        self._add(name, PointForce(point, force))  # type: ignore[arg-type]

    def _body_load(self, load: BodyLoadSection) -> None:
        holder = self.mechanism.holder(load.body)
        if holder == GROUND:
            return
        pose = self.mechanism.poses[holder]
        vector = rotated(pose.axes, load.load) if load.local_load else load.load
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

    def _body_torque(self, load: BodyLoadSection, vector: Vector3, scale: Quantity) -> None:
        if max(abs(vector[0]), abs(vector[2])) > SMALL * math.hypot(*vector):
            message = "a torque in the X–Z plane is about Y only"
            self.places.say(load, message, ("load",), "give [0, M, 0]")
        name = identifier(load.name)
        self._add(name, BodyForce(self._name(load.body), moment=times(vector[1], scale)))

    def _body_force(self, load: BodyLoadSection, vector: Vector3, scale: Quantity) -> None:
        pose = self.mechanism.poses[load.body]
        if abs(vector[1]) > SMALL * math.hypot(*vector):
            message = "the force leads out of the X–Z plane"
            self.places.say(load, message, ("load",), "give [F_x, 0, F_z]")
        if not load.local_point:
            message = "a force at a point that is fixed in space, on a body that moves"
            self.places.say(
                load, message, ("local_point",), "give the point in body axes, and true"
            )
            return
        arm = rotated(pose.axes, load.point)
        place = [a + b for a, b in zip(pose.place, arm, strict=True)]
        flat = turned_back(vector, pose.angle) if load.local_load else (vector[0], vector[2])
        name = identifier(load.name)
        force = tuple(times(component, scale) for component in flat)
        point = self._point(load, name, load.body, place)
        axes = "body" if load.local_load else "world"
        self._add(name, PointForce(point, force, axes))  # type: ignore[arg-type]

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
