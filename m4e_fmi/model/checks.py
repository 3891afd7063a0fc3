"""What can be wrong with a model beyond the form of its file; all of it is found at once."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any, get_args

from m4e_fmi.document import Location
from m4e_fmi.errors import suggestion
from m4e_fmi.model.elements import (
    GROUND,
    AngleReference,
    BodyForce,
    Joint,
    Parameter,
    PointForce,
    parameter_values,
)
from m4e_fmi.model.expression import CONSTANTS, FUNCTIONS, ExpressionError, as_expression
from m4e_fmi.program.program import TIME as PROGRAM_TIME
from m4e_fmi.units import parse_unit

if TYPE_CHECKING:
    from m4e_fmi.model.model import Model

TIME = "t"
EQUATION_SYMBOL = re.compile(r"(Theta|Phi|S|X|Z)(D|DD)?_\d+|A_\d+_\d+")
NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
INITIAL = {
    "revolute": ("q", "u"),
    "prismatic": ("q", "u"),
    "floating": ("x", "z", "theta", "vx", "vz", "omega"),
    "fixed": (),
}


@dataclass(frozen=True)
class Finding:
    """One thing wrong, and where in the model: keys from the top, as in the file."""

    location: Location
    message: str
    remedy: str = ""


@dataclass(frozen=True)
class Names:
    """What has been declared. A name can be declared although its element is not usable."""

    bodies: frozenset[str]
    points: frozenset[str]
    parameters: frozenset[str]

    @classmethod
    def of(cls, model: Model | Mapping[str, Any]) -> Names:
        """The names of a model, or of a model file's plain data."""
        groups = []
        for group in ("bodies", "points", "parameters"):
            members = model.get(group) if isinstance(model, Mapping) else getattr(model, group)
            known = map(str, members) if isinstance(members, Mapping) else ()
            groups.append(frozenset(known))
        return cls(*groups)


def findings(model: Model) -> list[Finding]:
    """Everything wrong with `model`."""
    return list(element_findings(model, Names.of(model))) or list(whole_findings(model))


def whole_findings(model: Any) -> Iterator[Finding]:
    """What is wrong with the tree and with the numbers, given that every element is right."""
    yield from _tree_findings(model)
    yield from _value_findings(model)


def element_findings(model: Any, names: Names) -> Iterator[Finding]:
    """What is wrong with single elements: names, references, expressions.

    `model` needs the groups of a Model only; some of its elements may be missing.
    """
    yield from _name_findings(model)
    yield from _expressions(("gravity",), model.gravity, names.parameters)
    for name, parameter in model.parameters.items():
        yield from _parameter_findings(("parameters", name), parameter)
    for name, body in model.bodies.items():
        yield from _quantities(("bodies", name), body, names.parameters)
    for name, joint in model.joints.items():
        yield from _joint_findings(("joints", name), joint, names)
    for name, point in model.points.items():
        yield from _reference(
            ("points", name, "body"), point.body, names.bodies | {GROUND}, "bodies"
        )
        yield from _quantities(("points", name), point, names.parameters)
    for name, load in model.loads.items():
        yield from _load_findings(("loads", name), load, names)


def _parameter_findings(at: Location, parameter: Parameter) -> Iterator[Finding]:
    if not isinstance(parameter.value, Real) or not math.isfinite(parameter.value):
        message = f"expected a finite number, got {parameter.value!r}"
        yield Finding((*at, "value"), message)
    try:
        parse_unit(parameter.unit)
    except ValueError as error:
        yield Finding((*at, "unit"), str(error), "write it like N.s/m or kg.m2")


def _name_findings(model: Any) -> Iterator[Finding]:
    for group in ("parameters", "bodies", "joints", "points", "loads"):
        for name in getattr(model, group):
            if not NAME.fullmatch(name):
                remedy = "use letters, digits and _, a letter first"
                yield Finding((group, name), f"{name!r} cannot be a name", remedy)
    if GROUND in model.bodies:
        yield Finding(("bodies", GROUND), "'ground' is the name of the world", "rename this body")
    reserved = {TIME, PROGRAM_TIME, *CONSTANTS, *FUNCTIONS}
    for name in model.parameters:
        if name in reserved or EQUATION_SYMBOL.fullmatch(name):
            message = f"{name!r} already has a meaning in expressions"
            yield Finding(("parameters", name), message, "rename this parameter")


def _joint_findings(at: Location, joint: Joint, names: Names) -> Iterator[Finding]:
    yield from _reference((*at, "child"), joint.child, names.bodies, "bodies")
    yield from _reference((*at, "parent"), joint.parent, names.bodies | {GROUND}, "bodies")
    yield from _quantities(at, joint, names.parameters)
    if joint.type not in INITIAL:
        yield Finding(
            (*at, "type"), f"unknown type {joint.type!r}", suggestion(joint.type, INITIAL)
        )
        return
    if joint.type == "floating":
        if joint.parent != GROUND:
            message = "a floating joint is always to the ground"
            yield Finding((*at, "parent"), message, "leave 'parent' out")
        for field in ("parent_to_joint", "joint_to_child"):
            if getattr(joint, field) not in ((0.0, 0.0), [0.0, 0.0]):
                message = f"a floating joint has no {field}"
                yield Finding(
                    (*at, field), message, "give the start position under 'initial': x, z"
                )
    if (joint.type == "prismatic") != (joint.direction is not None):
        message = "a prismatic joint, and no other, has a direction"
        remedy = "add 'direction: [x, z]'" if joint.type == "prismatic" else "leave it out"
        yield Finding((*at, "direction"), message, remedy)
    if joint.coordinate not in get_args(AngleReference):
        remedy = suggestion(joint.coordinate, get_args(AngleReference))
        yield Finding((*at, "coordinate"), f"unknown coordinate {joint.coordinate!r}", remedy)
    elif joint.coordinate == "relative" and joint.type != "revolute":
        message = "only a revolute joint has a coordinate to choose"
        yield Finding((*at, "coordinate"), message, "leave it out")
    if joint.direction is not None:
        yield from _vector((*at, "direction"), joint.direction, names.parameters)
    for key, value in joint.initial.items():
        if key not in INITIAL[joint.type]:
            message = f"a {joint.type} joint has no initial {key!r}"
            remedy = suggestion(key, INITIAL[joint.type]) or "leave it out"
            yield Finding((*at, "initial", key), message, remedy)
        yield from _expressions((*at, "initial", key), value, names.parameters)


def _load_findings(at: Location, load: Any, names: Names) -> Iterator[Finding]:
    known = names.parameters | {TIME}
    if isinstance(load, BodyForce):
        yield from _reference((*at, "body"), load.body, names.bodies, "bodies")
    elif isinstance(load, PointForce):
        yield from _reference((*at, "point"), load.point, names.points, "points")
    else:
        field = "points" if hasattr(load, "points") else "bodies"
        known_ends = names.points if field == "points" else names.bodies | {GROUND}
        ends = getattr(load, field)
        if len(ends) != 2:
            yield Finding((*at, field), f"expected two {field}, got {len(ends)}")
            return
        for index, end in enumerate(ends):
            yield from _reference((*at, field, index), end, known_ends, field)
        if ends[0] == ends[1]:
            yield Finding((*at, field), f"both ends are {ends[0]!r}", f"name two {field}")
    yield from _quantities(at, load, known)


def _quantities(at: Location, element: Any, known: Iterable[str]) -> Iterator[Finding]:
    for field in getattr(element, "scalars", ()):
        yield from _expressions((*at, field), getattr(element, field), known)
    for field in getattr(element, "vectors", ()):
        yield from _vector((*at, field), getattr(element, field), known)


def _vector(at: Location, value: Any, known: Iterable[str]) -> Iterator[Finding]:
    if not isinstance(value, tuple | list) or len(value) != 2:
        yield Finding(at, f"expected two entries, got {value!r}", "write it like (x, z)")
        return
    for index, entry in enumerate(value):
        yield from _expressions((*at, index), entry, known)


def _expressions(at: Location, value: Any, known: Iterable[str]) -> Iterator[Finding]:
    try:
        expression = as_expression(value)
    except ExpressionError as error:
        where = f" (column {error.column} of {value!r})" if error.column else ""
        yield Finding(at, f"{error}{where}", "allowed: numbers, names, + - * / **, functions")
        return
    for name in sorted(expression.names() - set(known)):
        remedy = suggestion(name, [*known, *CONSTANTS], "names")
        yield Finding(at, f"{name!r} is not declared", remedy)


def _reference(at: Location, name: str, known: Iterable[str], noun: str) -> Iterator[Finding]:
    if name not in known:
        singular = {"bodies": "body", "points": "point"}[noun]
        yield Finding(at, f"unknown {singular} {name!r}", suggestion(name, known, noun))


def _tree_findings(model: Any) -> Iterator[Finding]:
    """Each body must hang on the ground through exactly one chain of joints."""
    parents: dict[str, str] = {}
    for name, joint in model.joints.items():
        if joint.child in parents:
            message = f"body {joint.child!r} is the child of {parents[joint.child]!r} already"
            remedy = "closed loops: cut one joint and put a stiff spring and damper in its place"
            yield Finding(("joints", name, "child"), message, remedy)
        parents.setdefault(joint.child, name)
    reached = _reached(model)
    for name in model.bodies:
        if name not in parents:
            remedy = "add a joint with this child (type: floating, if it is free)"
            yield Finding(("bodies", name), f"body {name!r} has no joint", remedy)
        elif name not in reached:
            remedy = "one body of this chain must have a joint with parent: ground"
            yield Finding(("bodies", name), f"body {name!r} is not connected to the ground", remedy)
    if model.joints and all(joint.type == "fixed" for joint in model.joints.values()):
        message = "nothing can move: every joint is fixed"
        yield Finding(("joints",), message, "give at least one joint another type")
    if not model.bodies:
        yield Finding(("bodies",), "a model needs at least one body", "add one under 'bodies'")


def _reached(model: Any) -> set[str]:
    """The ground, and all that hangs on it through joints."""
    children: dict[str, list[str]] = {}
    for joint in model.joints.values():
        children.setdefault(joint.parent, []).append(joint.child)
    reached = {GROUND}
    waiting = [GROUND]
    while waiting:
        new = set(children.get(waiting.pop(), ())) - reached
        reached |= new
        waiting += new
    return reached


def _value_findings(model: Any) -> Iterator[Finding]:
    """What the start values of the parameters do not allow."""
    values = parameter_values(model.parameters)
    computed: dict[Location, float] = {}
    for at, quantity in _all_quantities(model):
        expression = as_expression(quantity)
        if TIME in expression.names():
            continue
        try:
            computed[at] = value = expression.evaluate(values)
        except (ArithmeticError, ValueError) as error:
            yield Finding(at, f"cannot be computed: {error}")
            continue
        if not math.isfinite(value):
            yield Finding(at, f"must be finite, got {value}")
        elif at[0] == "bodies" and not value > 0:
            remedy = f"give a positive {at[-1]}"
            yield Finding(at, f"must be positive, got {value:.6g}", remedy)
    for name, joint in model.joints.items():
        at = ("joints", name, "direction")
        if joint.direction is not None and computed.get((*at, 0)) == computed.get((*at, 1)) == 0:
            yield Finding(at, "the direction has no length", "give a vector such as [1, 0]")


def _all_quantities(model: Any) -> Iterator[tuple[Location, Any]]:
    """Every number or expression of the model, and where it stands."""
    yield ("gravity",), model.gravity
    for group in ("bodies", "joints", "points", "loads"):
        for name, element in getattr(model, group).items():
            for field in getattr(element, "scalars", ()):
                yield (group, name, field), getattr(element, field)
            vectors = getattr(element, "vectors", ())
            if getattr(element, "direction", None) is not None:
                vectors = (*vectors, "direction")
            for field in vectors:
                for index, value in enumerate(getattr(element, field)):
                    yield (group, name, field, index), value
            for key, value in getattr(element, "initial", {}).items():
                yield (group, name, "initial", key), value
