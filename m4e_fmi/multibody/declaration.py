"""The parameters, inputs and states of a model as variables: names, units, texts, limits."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container, Iterator
from typing import Protocol

from m4e_fmi.joints import ATTITUDE, QUATERNION, quaternion_of
from m4e_fmi.model import Model
from m4e_fmi.model.checks import bounded_parameters
from m4e_fmi.model.elements import (
    GROUND,
    neutral_mass,
    parameter_values,
    vector,
)
from m4e_fmi.model.expression import Values
from m4e_fmi.model.groups import gravity_of
from m4e_fmi.model.quantity import as_expression, quantities_of
from m4e_fmi.multibody.assembly import Scalars
from m4e_fmi.multibody.topology import Topology, TreeLink
from m4e_fmi.program import AnyScalar, Recorder, Variable
from m4e_fmi.space import AXES, TURN, is_zero
from m4e_fmi.units import parse_unit

NEUTRAL_MASS = re.compile(r"(.+\.)?body\.\w+\.neutral_mass")
"""Parameters whose start value 0 stands for none."""


def is_unset(parameter: Variable) -> bool:
    """True of a neutral mass that nobody has set."""
    return parameter.start == 0.0 and bool(NEUTRAL_MASS.fullmatch(parameter.name))


class Described(Protocol):
    """An element with a description of its author's."""

    @property
    def description(self) -> str:
        """The author's description, or an empty text."""
        ...


def state_names(link: TreeLink) -> tuple[list[str], list[str]]:
    """Variable names of the coordinates and of the velocities of a link."""
    joint_type = link.joint_type
    owner = f"body.{link.body}" if joint_type.is_free else f"joint.{link.joint_name}"
    return (
        [f"{owner}.{name}" for name in joint_type.positions],
        [f"{owner}.{name}" for name in joint_type.velocities],
    )


def in_words(element: Described, text: str) -> str:
    """`text` of a variable of an element, after the words that the user has for the element."""
    words = " ".join(element.description.split())
    return f"{words}: {text[0].lower()}{text[1:]}" if words else text


def declared(
    recorder: Recorder, model: Model, tree: Topology, inputs: Container[str] | None = None
) -> Scalars:
    """The parameters, inputs and states of a model, declared."""
    bounded = bounded_parameters(model)
    parameters: dict[str, AnyScalar] = {}
    for name, parameter in model.parameters.items():
        unit = parse_unit(parameter.unit)
        coherent = unit.factor == 1.0
        variable = Variable(
            name,
            unit.text if coherent else unit.coherent_text,
            parameter.description or f"Parameter {name}",
            start=parameter.value * unit.factor,
            display_unit=None if coherent else unit.text,
            tunable=parameter.tunable,
            minimum=0.0 if name in bounded else -math.inf,
        )
        parameters[name] = recorder.parameter(variable)
    for name, body in model.bodies.items():
        if body.is_neutral:
            text = f"Mass of body {name}, to be set to that of the water it displaces"
            mass = recorder.parameter(Variable(neutral_mass(name), "kg", text, minimum=0.0))
            # not a number while it is 0, so that nothing runs without a value
            parameters[neutral_mass(name)] = mass * (mass / mass)
    added_mass = _declared_added_mass(recorder, model, tree)
    acting = inputs_of(model, tree, recorder.input, chosen=inputs)
    q, u = _declared_states(recorder, model, tree)
    return Scalars(q, u, recorder.time, parameters, added_mass=added_mass, **acting)


def _declared_added_mass(recorder: Recorder, model: Model, tree: Topology) -> list[list[AnyScalar]]:
    dofs = [
        (link.body, unit)
        for link in tree.links
        if model.bodies[link.body].added_mass
        for unit in ("m" if c < TURN else "rad" for c in tree.components)
    ]
    rows = []
    for i, (body, unit) in enumerate(dofs, start=1):
        row = []
        for j, (other, other_unit) in enumerate(dofs, start=1):
            # force per acceleration: kg, kg.m (force per rad/s² or moment per m/s²), kg.m2
            power = (unit, other_unit).count("rad")
            kind = ("kg", "kg.m", "kg.m2")[power]
            # connections read from the text which bodies row and column are for
            text = f"Added mass at infinite frequency, world axes at the CG, {body} by {other}"
            variable = Variable(f"added_mass[{i},{j}]", kind, text, tunable=True)
            row.append(recorder.parameter(variable))
        rows.append(row)
    return rows


def inputs_of(
    model: Model,
    tree: Topology,
    scalar: Callable[[Variable], AnyScalar],
    *,
    chosen: Container[str] | None = None,
) -> dict[str, AnyScalar]:
    """Inputs as fields of `Scalars`; those `chosen`, or all if `chosen` has the value None.

    `scalar` makes the scalar of an input.
    """

    def force(element: Described, name: str, unit: str, text: str) -> AnyScalar:
        if chosen is not None and name not in chosen:
            return 0
        return scalar(Variable(name, unit, in_words(element, text)))

    def parts(element: Described, owner: str, where: str) -> list[AnyScalar]:
        found: list[AnyScalar] = [0] * (2 * TURN)
        for c in tree.components:
            axis = AXES[c % TURN]
            if c < TURN:
                text = f"Force at the {where}, world {axis.upper()}"
                found[c] = force(element, f"{owner}.force_{axis}", "N", text)
            elif where == "CG":
                text = f"Moment about the CG, about +{axis.upper()}"
                found[c] = force(element, f"{owner}.moment_{axis}", "N.m", text)
        return found

    wrench = {
        link.body: tuple(parts(model.bodies[link.body], f"body.{link.body}", "CG"))
        for link in tree.links
    }
    points = {
        name: tuple(parts(point, f"point.{name}", "point")[:TURN])
        for name, point in model.points.items()
        if point.body != GROUND
    }
    efforts = {}
    for link in (link for link in tree.links if link.joint_type.efforts):
        several, found = len(link.joint_type.coordinates) > 1, []
        for effort, coordinate in link.joint_type.efforts.items():
            which = f" {coordinate.position}" if several else ""
            text = f"Generalised force along the joint's coordinate{which}"
            name = f"joint.{link.joint_name}.{effort}"
            found.append(force(link.joint, name, coordinate.effort_unit, text))
        efforts[link.joint_name] = tuple(found)
    groups = {"body_wrench": wrench, "point_force": points, "effort": efforts}
    return {
        group: {name: parts for name, parts in members.items() if not all(map(is_zero, parts))}
        for group, members in groups.items()
    }


def _declared_states(
    recorder: Recorder, model: Model, tree: Topology
) -> tuple[list[AnyScalar], list[AnyScalar]]:
    """q and u. A coordinate and its velocity are neighbours; a quaternion and ω come after them."""
    values, nominal = parameter_values(model.parameters), _nominal(model)
    found: dict[str, AnyScalar] = {}
    for link in tree.links:
        owner = model.bodies[link.body] if link.joint_type.is_free else link.joint
        start = _start_values(link, values)
        for name, unit, text, of in _states(link, tree):
            value, size = start[name.rpartition(".")[2]], nominal.get(unit, 1.0)
            words = in_words(owner, text)
            variable = Variable(name, unit, words, value, derivative_of=of, nominal=size)
            found[name] = recorder.state(variable)
    names = [state_names(link) for link in tree.links]
    return (
        [found[name] for positions, _ in names for name in positions],
        [found[name] for _, velocities in names for name in velocities],
    )


def _states(link: TreeLink, tree: Topology) -> Iterator[tuple[str, str, str, str | None]]:
    """Name, unit and text of each state of a link, and of a velocity the name of its coordinate."""
    positions, velocities = state_names(link)
    count = len(link.joint_type.coordinates)
    for n, coordinate in enumerate(link.joint_type.coordinates):
        text = f"Coordinate {tree.coordinate_names[link.coordinates[n]]} of body {link.body}"
        yield positions[n], coordinate.unit, text, None
        text = f"Velocity {tree.velocity_names[link.speeds[n]]} of body {link.body}"
        yield velocities[n], f"{coordinate.unit}/s", text, positions[n]
    for number, name in enumerate(positions[count:]):
        yield name, "1", f"Attitude of body {link.body}: quaternion, part {number}", None
    for axis, name in zip(AXES, velocities[count:], strict=False):
        yield name, "rad/s", f"Angular velocity of body {link.body}, world {axis.upper()}", None


def _start_values(link: TreeLink, values: Values) -> dict[str, float]:
    """Start value of each state of a link, by the last part of its name."""
    keys = link.joint_type.start_keys
    given = {
        key: float(as_expression(link.joint.initial.get(key, 0.0)).evaluate(values)) for key in keys
    }
    if link.joint_type.has_quaternion:
        turned = quaternion_of(*(given.pop(angle) for angle in ATTITUDE))
        given |= dict(zip(QUATERNION, turned, strict=True))
    return given


def _nominal(model: Model) -> dict[str, float]:
    """Orders of magnitude of the motion, by unit: of the longest arm l (1 m without arms), of
    one radian, and of these in the time √(l/g) of a pendulum of that length (1 s without gravity).
    """
    values = parameter_values(model.parameters)
    elements = (*model.joints.values(), *model.points.values())
    arms = (vector(element, field) for element in elements for field in quantities_of(element))
    sizes = (math.hypot(*(part.evaluate(values) for part in arm)) for arm in arms)
    length = max(sizes, default=0.0) or 1.0
    gravity = math.hypot(*(part.evaluate(values) for part in gravity_of(model)))
    rate = math.sqrt(gravity / length) or 1.0
    exact = {"m": length, "rad": 1.0, "m/s": length * rate, "rad/s": rate}
    return {unit: float(f"1e{round(math.log10(value))}") for unit, value in exact.items()}
