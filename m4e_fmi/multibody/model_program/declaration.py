"""The parameters, inputs and states of a model as variables: names, units, texts, limits."""

from __future__ import annotations

import math
import re
from collections.abc import Container
from typing import Protocol

from m4e_fmi.model import Model
from m4e_fmi.model.checks import bounded_parameters
from m4e_fmi.model.elements import (
    GROUND,
    Parameter,
    neutral_mass,
    parameter_values,
    quantity,
    vector,
)
from m4e_fmi.model.quantity import as_expression
from m4e_fmi.multibody.assembly import Scalars
from m4e_fmi.multibody.topology import Link, Topology
from m4e_fmi.program import AnyScalar, Recorder, Variable
from m4e_fmi.units import parse_unit

DOF_UNITS = ("m", "m", "rad")

NEUTRAL_MASS = re.compile(r"(.+\.)?body\.\w+\.neutral_mass")
"""Parameters whose start value 0 stands for none."""


def is_unset(parameter: Variable) -> bool:
    """True of a neutral mass that nobody has set."""
    return parameter.start == 0.0 and bool(NEUTRAL_MASS.fullmatch(parameter.name))


class Described(Protocol):
    """An element with a description of its author's."""

    @property
    def description(self) -> str:
        """The author's description, empty if there is none."""
        ...


class Inputs(Protocol):
    """Source of scalars for inputs: a recorder, or one with scalars of its own."""

    def input(self, variable: Variable) -> AnyScalar:
        """The scalar that stands for an input."""
        ...


def state_names(link: Link) -> list[tuple[str, str]]:
    """(coordinate, velocity) variable names of the states of a link."""
    joint_type = link.joint.joint_type
    owner = f"body.{link.body}" if joint_type.is_free else f"joint.{link.joint_name}"
    return [(f"{owner}.{c.position}", f"{owner}.{c.velocity}") for c in joint_type.coordinates]


def in_words(element: Described, text: str) -> str:
    """`text` of a variable of an element, after the words that the user has for the element."""
    words = " ".join(element.description.split())
    return f"{words}: {text[0].lower()}{text[1:]}" if words else text


def declared(
    recorder: Recorder, model: Model, tree: Topology, inputs: Container[str] | None = None
) -> Scalars:
    """The parameters, inputs and states of a model, declared."""
    bounded = bounded_parameters(model)
    parameters: dict[str, AnyScalar] = {
        name: recorder.parameter(_parameter(name, parameter, bounded=name in bounded))
        for name, parameter in model.parameters.items()
    }
    for name, body in model.bodies.items():
        if body.is_neutral:
            parameters[neutral_mass(name)] = _declared_neutral_mass(recorder, name)
    added_mass = _declared_added_mass(recorder, model, tree)
    acting = declared_inputs(recorder, model, tree, inputs)
    q, u = _declared_states(recorder, model, tree)
    return Scalars(q, u, recorder.time, parameters, added_mass=added_mass, **acting)


def _parameter(name: str, parameter: Parameter, *, bounded: bool) -> Variable:
    unit = parse_unit(parameter.unit)
    return Variable(
        name,
        unit.text if unit.factor == 1.0 else unit.si_text,
        parameter.description or f"Parameter {name}",
        start=parameter.value * unit.factor,
        display_unit=None if unit.factor == 1.0 else unit.text,
        tunable=parameter.tunable,
        minimum=0.0 if bounded else -math.inf,
    )


def _declared_neutral_mass(recorder: Recorder, body: str) -> AnyScalar:
    """The mass of a body [kg]; not a number while it is 0, so that nothing runs without a value."""
    text = f"Mass of body {body}, to be set to that of the water it displaces"
    mass = recorder.parameter(Variable(neutral_mass(body), "kg", text, minimum=0.0))
    return mass * (mass / mass)


def _declared_added_mass(recorder: Recorder, model: Model, tree: Topology) -> list[list[AnyScalar]]:
    dofs = [
        (link.body, unit)
        for link in tree.links
        if model.bodies[link.body].added_mass
        for unit in DOF_UNITS
    ]
    rows = []
    for i, (body, unit) in enumerate(dofs, start=1):
        row = []
        for j, (other, other_unit) in enumerate(dofs, start=1):
            # force per acceleration: kg, kg.m (force per rad/s² or moment per m/s²), kg.m2
            power = (unit, other_unit).count("rad")
            kind = ("kg", "kg.m", "kg.m2")[power]
            text = f"Added mass at infinite frequency, world axes at the CG, {body} by {other}"
            row.append(recorder.parameter(Variable(f"added_mass[{i},{j}]", kind, text)))
        rows.append(row)
    return rows


def declared_inputs(
    recorder: Inputs, model: Model, tree: Topology, chosen: Container[str] | None = None
) -> dict[str, AnyScalar]:
    """Inputs as fields of `Scalars`; those that are `chosen`, or all if that is None."""

    def force(element: Described, name: str, unit: str, text: str) -> AnyScalar:
        if chosen is not None and name not in chosen:
            return 0
        return recorder.input(Variable(name, unit, in_words(element, text)))

    wrench = {}
    for name, body in ((link.body, model.bodies[link.body]) for link in tree.links):
        wrench[name] = (
            force(body, f"body.{name}.force_x", "N", "Force at the CG, world X"),
            force(body, f"body.{name}.force_z", "N", "Force at the CG, world Z"),
            force(body, f"body.{name}.moment_y", "N.m", "Moment about the CG, about +Y"),
        )
    points = {
        name: (
            force(point, f"point.{name}.force_x", "N", "Force at the point, world X"),
            force(point, f"point.{name}.force_z", "N", "Force at the point, world Z"),
        )
        for name, point in model.points.items()
        if point.body != GROUND
    }
    efforts = {
        link.joint_name: force(
            link.joint,
            f"joint.{link.joint_name}.effort",
            link.joint.joint_type.effort_unit,
            "Generalised force along the joint's coordinate",
        )
        for link in tree.links
        if link.joint.joint_type.has_effort
    }
    groups = {"body_wrench": wrench, "point_force": points, "effort": efforts}
    silent = (0, (0, 0), (0, 0, 0))
    return {
        group: {name: value for name, value in members.items() if value not in silent}
        for group, members in groups.items()
    }


def _declared_states(
    recorder: Recorder, model: Model, tree: Topology
) -> tuple[list[AnyScalar], list[AnyScalar]]:
    values = parameter_values(model.parameters)
    nominal = _nominal(model)
    q: list[AnyScalar] = [None] * len(tree.coordinate_names)
    u: list[AnyScalar] = list(q)
    for link in tree.links:
        joint_type = link.joint.joint_type
        owner = model.bodies[link.body] if joint_type.is_free else link.joint
        pairs = zip(state_names(link), joint_type.coordinates, link.coordinates, strict=True)
        for (position, velocity), coordinate, k in pairs:
            unit = coordinate.unit
            start = {
                name: float(as_expression(link.joint.initial.get(name, 0.0)).evaluate(values))
                for name in (coordinate.position, coordinate.velocity)
            }
            text = f"Coordinate {tree.coordinate_names[k]} of body {link.body}"
            variable = Variable(
                position,
                unit,
                in_words(owner, text),
                start[coordinate.position],
                nominal=nominal[unit],
            )
            q[k] = recorder.state(variable)
            text = f"Velocity {tree.velocity_names[k]} of body {link.body}"
            u[k] = recorder.state(
                Variable(
                    velocity,
                    f"{unit}/s",
                    in_words(owner, text),
                    start[coordinate.velocity],
                    derivative_of=position,
                    nominal=nominal[f"{unit}/s"],
                )
            )
    return q, u


def _nominal(model: Model) -> dict[str, float]:
    """Orders of magnitude of the motion, by unit: of the longest arm l (1 m if there is none), of
    one radian, and of these in the time √(l/g) of a pendulum of that length (1 s without gravity).
    """
    values = parameter_values(model.parameters)
    elements = (*model.joints.values(), *model.points.values())
    arms = (vector(element, field) for element in elements for field in element.vectors)
    length = max((math.hypot(x.evaluate(values), z.evaluate(values)) for x, z in arms), default=0.0)
    length = length or 1.0
    gravity = abs(quantity(model, "gravity").evaluate(values))
    rate = math.sqrt(gravity / length) or 1.0
    exact = {"m": length, "rad": 1.0, "m/s": length * rate, "rad/s": rate}
    return {unit: float(f"1e{round(math.log10(value))}") for unit, value in exact.items()}
