"""Checks of a model beyond the form of its file; all problems are found at once."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from numbers import Real

from m4e_fmi.files.document import Location
from m4e_fmi.joints import JOINT_TYPES
from m4e_fmi.model.dimensions import dimension_findings
from m4e_fmi.model.elements import (
    GROUND,
    NEUTRAL,
    Body,
    Quantity,
    neutral_mass,
    neutral_symbol,
    parameter_values,
)
from m4e_fmi.model.expression import CONSTANTS, FUNCTIONS, Expression, Values
from m4e_fmi.model.findings import (
    TIME,
    Known,
    ModelFinding,
    Names,
    numbers,
    quantities,
    reference,
    vectors,
)
from m4e_fmi.model.groups import Groups
from m4e_fmi.model.joint_checks import AXES_OF_JOINTS, PARALLEL, axis_findings, joint_findings
from m4e_fmi.model.load_checks import LoadChecks
from m4e_fmi.model.quantity import as_expression, quantities_of
from m4e_fmi.model.shapes import Cylinder, Shape
from m4e_fmi.model.table import TableError
from m4e_fmi.program.program import TIME as PROGRAM_TIME
from m4e_fmi.units import parse_unit

SMALLEST, LARGEST = 1e-100, 1e100
"""Sizes of the numbers of a model; products of three stay within what a float can hold."""
EQUATION_SYMBOL = re.compile(
    r"(Theta|Phi|Psi|S|R|X|Y|Z|OmegaX|OmegaY|OmegaZ)(D|DD)?_\d+|E[0-3]_\d+|A_\d+_\d+"
)
NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
TREE = ("child", "parent")
"""Keys of a joint that make the tree of bodies."""
EFFECTS = {
    "gravity": "lifts all bodies",
    "damping": "drives the motion",
    "stiffness": "pushes away from where it rests",
}
"""Effects of negative values."""
UNITS = "write it like N.s/m or kg.m2"


def findings(model: Groups) -> list[ModelFinding]:
    """Everything wrong with `model`."""
    found = list(element_findings(model, Names.of(model)))
    return found or list(_further_findings(model, ()))


def group_findings(groups: Groups, names: Names) -> list[ModelFinding]:
    """Everything wrong with the groups of a Model, of which some elements may be missing.

    The tree is looked at if the names of bodies and joints are right.
    """
    found = list(element_findings(groups, names))
    return [*found, *_further_findings(groups, found)]


def findings_with(
    model: Groups, names: Collection[str]
) -> Callable[[Mapping[str, float]], Iterator[ModelFinding]]:
    """A check of other values of the parameters `names` [SI]: numbers of a right `model`.

    Start positions and velocities do not follow them. Groups that do not follow them are right.
    """
    known = [(at, quantity) for at, quantity in _all_quantities(model) if "initial" not in at]
    follow = {at[:2] for at, one in known if not as_expression(one).names().isdisjoint(names)}
    quantities = [(at, quantity) for at, quantity in known if at[:2] in follow]
    numbers = parameter_values(model.parameters)

    def check(values: Mapping[str, float]) -> Iterator[ModelFinding]:
        numbers.update(values)
        return _value_findings(model, quantities, numbers)

    return check


def _further_findings(model: Groups, found: Collection[ModelFinding]) -> Iterator[ModelFinding]:
    """Problems of the tree and the numbers that do not follow from those `found` already.

    Numbers that are wrong, and those made from parameters that are wrong, are passed over.
    """
    wrong = {f.location for f in found}
    if not any(at[0] == "joints" and at[-1] in TREE for at in wrong):
        yield from _tree_findings(model)
    names = {at[1] for at in wrong if at[0] in ("parameters", "tables") and len(at) > 1}
    fields = vars(model).copy()
    for group in ("parameters", "tables"):
        fields[group] = {n: one for n, one in fields[group].items() if n not in names}
    model = Groups(**fields)
    quantities = [
        (at, quantity)
        for at, quantity in _all_quantities(model)
        if not any(at[: len(part)] == part for part in wrong)
        and names.isdisjoint(as_expression(quantity).names())
    ]
    yield from _value_findings(model, quantities, parameter_values(model.parameters))
    yield from dimension_findings(model, iter(quantities))


def element_findings(model: Groups, names: Names) -> Iterator[ModelFinding]:
    """Problems of single elements: names, references, expressions.

    `model` needs the groups of a Model only; some of its elements may be missing.
    """
    known = Known(names.parameters, dimensions=model.dimensions)
    yield from _name_findings(model)
    if known.dimensions == 3 and isinstance(model.gravity, (tuple, list)):
        yield from vectors(("gravity",), model.gravity, known)
    else:
        yield from numbers(("gravity",), model.gravity, known, ())
    for name, parameter in model.parameters.items():
        at = ("parameters", name)
        if not isinstance(parameter.value, Real) or not math.isfinite(parameter.value):
            message = f"expected a finite number, got {parameter.value!r}"
            yield ModelFinding((*at, "value"), message)
        yield from _unit_findings((*at, "unit"), parameter.unit)
    for name, body in model.bodies.items():
        leaving_out = ("mass",) if body.is_neutral else ()
        yield from quantities(("bodies", name), body, known, leaving_out=leaving_out)
        yield from _shape_findings(("bodies", name), body, known)
    for name, joint in model.joints.items():
        yield from joint_findings(("joints", name), joint, names, known)
    for name, point in model.points.items():
        at = ("points", name, "body")
        yield from reference(at, point.body, names.bodies | {GROUND}, "bodies")
        yield from quantities(("points", name), point, known)
    for name, table in model.tables.items():
        yield from _unit_findings(("tables", name, "unit"), table.unit)
        try:
            table.check()
        except TableError as error:
            yield ModelFinding(("tables", name), str(error), error.remedy)
    yield from LoadChecks(model, names).findings()


def _unit_findings(at: Location, unit: str) -> Iterator[ModelFinding]:
    try:
        parse_unit(unit)
    except ValueError as error:
        yield ModelFinding(at, str(error), UNITS)


def _name_findings(model: Groups) -> Iterator[ModelFinding]:
    for group in ("parameters", "tables", "bodies", "joints", "points", "loads"):
        for name in getattr(model, group):
            if not NAME.fullmatch(name):
                remedy = "use letters, digits and _, a letter first"
                yield ModelFinding((group, name), f"{name!r} cannot be a name", remedy)
    if GROUND in model.bodies:
        yield ModelFinding(
            ("bodies", GROUND), "'ground' is the name of the world", "rename this body"
        )
    reserved = {TIME, PROGRAM_TIME, *CONSTANTS, *FUNCTIONS}
    neutral = [name for name, body in model.bodies.items() if body.is_neutral]
    if neutral:
        reserved |= {NEUTRAL, *map(neutral_symbol, neutral)}
    for group, noun in (("parameters", "parameter"), ("tables", "table")):
        for name in getattr(model, group):
            if name in reserved or EQUATION_SYMBOL.fullmatch(name):
                message = f"{name!r} already has a meaning in expressions"
                yield ModelFinding((group, name), message, f"rename this {noun}")
    for name in model.tables:
        if name in model.parameters:
            message = f"{name!r} is also a parameter"
            yield ModelFinding(("tables", name), message, "rename one of the two")


def _tree_findings(model: Groups) -> Iterator[ModelFinding]:
    """Each body must hang on the ground through exactly one chain of joints."""
    parents: dict[str, str] = {}
    for name, joint in model.joints.items():
        if joint.child in parents:
            message = f"body {joint.child!r} is the child of {parents[joint.child]!r} already"
            remedy = "closed loops: cut one joint and put a bushing between two points in its place"
            yield ModelFinding(("joints", name, "child"), message, remedy)
        parents.setdefault(joint.child, name)
    reached = _reached(model)
    for name in model.bodies:
        if name not in parents and name != GROUND:
            remedy = "add a joint with this child (type: floating, if it is free)"
            yield ModelFinding(("bodies", name), f"body {name!r} has no joint", remedy)
        elif name not in reached:
            remedy = "one body of this chain must have a joint with parent: ground"
            yield ModelFinding(
                ("bodies", name), f"body {name!r} is not connected to the ground", remedy
            )
    used = {joint.type for joint in model.joints.values()}
    types = JOINT_TYPES[model.dimensions]
    if used and all(name in types and not types[name].velocities for name in used):
        message = "nothing can move: every joint is fixed"
        yield ModelFinding(("joints",), message, "give at least one joint another type")
    if not model.bodies:
        yield ModelFinding(("bodies",), "a model needs at least one body", "add one under 'bodies'")


def _reached(model: Groups) -> set[str]:
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


def _value_findings(
    model: Groups, quantities: Iterable[tuple[Location, Quantity]], values: Values
) -> Iterator[ModelFinding]:
    """Values of `quantities` at the start that are not allowed, with these of parameters (SI)."""
    computed: dict[Location, float] = {}
    for at, quantity in quantities:
        expression = as_expression(quantity)
        if not expression.names() <= values.keys():  # depends on time or motion
            yield from _constant_findings(at, expression)
            continue
        try:
            computed[at] = value = expression.evaluate(values)
        except (ArithmeticError, ValueError) as error:
            yield ModelFinding(at, f"cannot be computed: {error}")
            continue
        if not math.isfinite(value):
            yield ModelFinding(at, f"must be finite, got {value}")
        elif value and not SMALLEST <= abs(value) <= LARGEST:
            message = f"is out of all scale: {value:.3g}"
            yield ModelFinding(
                at, message, f"give a size between {SMALLEST:g} and {LARGEST:g}, or 0"
            )
        elif _bound(model, at) == "positive" and not value > 0:
            remedy = f"give a positive {at[-1]}"
            yield ModelFinding(at, f"must be positive, got {value:.6g}", remedy)
        elif _bound(model, at) == "not negative" and value < 0:
            yield ModelFinding(at, f"must not be negative, got {value:.6g}", "give 0 or more")
    for name in model.loads:
        lower, upper = (computed.get(("loads", name, key)) for key in ("lower", "upper"))
        if lower is not None and upper is not None and lower >= upper:
            message = f"the lower limit {lower:.6g} is not below the upper one, {upper:.6g}"
            yield ModelFinding(("loads", name, "lower"), message, "exchange them")
    for name, joint in model.joints.items():
        yield from axis_findings(("joints", name), joint, computed)
    for name, body in model.bodies.items():
        yield from _cylinder_findings(("bodies", name), body, computed)
        at = ("bodies", name, "inertia")
        count = len(body.inertia) if isinstance(body.inertia, (tuple, list)) else 0
        entries = [computed[*at, k] for k in range(count) if (*at, k) in computed]
        if entries and len(entries) == count:
            yield from _inertia_findings(at, entries)


def _inertia_findings(at: Location, entries: list[float]) -> Iterator[ModelFinding]:
    """Tensors that no body has: moments of inertia are positive, and none exceeds two others."""
    import numpy as np

    xx, yy, zz, xy, yz, zx = [*entries, 0.0, 0.0, 0.0][:6]
    least, middle, most = np.linalg.eigvalsh([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    if not least > 0:
        message = f"principal moments of inertia must be positive, got {least:.6g}"
        remedy = "check the moments, and the signs of the products: Ixy is -∫ x y dm"
        yield ModelFinding(at, message, remedy)
    elif most > (least + middle) * (1 + PARALLEL):
        message = (
            f"no body has these moments of inertia: the principal one {most:.6g} exceeds the sum "
            f"of the others, {least + middle:.6g}"
        )
        yield ModelFinding(at, message, "check units, axes, and that they are about the CG")


def _shape_findings(at: Location, body: Body, known: Known) -> Iterator[ModelFinding]:
    """Problems of the numbers and expressions of a body's shape, which planar bodies have not."""
    if body.shape is None:
        return
    if known.dimensions == 2:
        message = "shape: bodies of a planar model are drawn by their joints and points"
        yield ModelFinding((*at, "shape"), message, "remove it, or add 'dimensions: 3'")
        return
    yield from quantities(_shape_place(at, body.shape), body.shape, known)


def _shape_place(at: Location, shape: Shape) -> Location:
    """Where in a model the quantities of the shape of the body at `at` are."""
    return (*at, "shape", *shape.keys)


def _cylinder_findings(
    at: Location, body: Body, computed: Mapping[Location, float]
) -> Iterator[ModelFinding]:
    """A finding if all parts of the axis of a cylinder are 0."""
    if isinstance(body.shape, Cylinder):
        place = (*_shape_place(at, body.shape), "axis")
        if all(computed.get((*place, k)) == 0.0 for k in range(3)):
            yield ModelFinding(place, "the axis has no length", "give a vector such as [0, 0, 1]")


def _constant_findings(at: Location, expression: Expression) -> Iterator[ModelFinding]:
    """Constants within an expression of time or motion that have no finite value."""
    for part in expression.constants():
        try:
            value = part.evaluate(Values({}))
        except (ArithmeticError, ValueError) as error:
            yield ModelFinding(at, f"{part} cannot be computed: {error}")
            continue
        if not math.isfinite(value):
            yield ModelFinding(at, f"{part} must be finite, got {value}")


def doubts(model: Groups) -> Iterator[ModelFinding]:
    """Values that are allowed and seldom meant: negative gravity, stiffness, damping of loads."""
    values = parameter_values(model.parameters)
    for at, quantity in _all_quantities(model):
        expression = as_expression(quantity)
        if at != ("gravity",) and _bound(model, at) != "seldom negative":
            continue
        if expression.names() <= values.keys() and (value := expression.evaluate(values)) < 0:
            message = f"negative {at[-1]}, {value:.6g}: it {EFFECTS[str(at[-1])]}"
            yield ModelFinding(at, message, "change the sign if that is not meant")


def lacking(model: Groups) -> Iterator[tuple[str, ModelFinding]]:
    """Parameters without a value, each with what to do where the model is used alone."""
    for name, body in model.bodies.items():
        if body.is_neutral:
            parameter = neutral_mass(name)
            yield parameter, ModelFinding(("bodies", name, "mass"), *without_value(parameter))


def without_value(parameter: str) -> tuple[str, str]:
    """Message and remedy on a parameter that has no value where its model is used alone."""
    message = f"{parameter} has no value: 'mass: neutral' is set by a hydrodynamics component"
    return message, f"give a start value (--start-value {parameter} '120 t'), or run the system"


def bounded_parameters(model: Groups) -> frozenset[str]:
    """Parameters that are, by themselves, a quantity that must be positive or not negative."""
    return frozenset(
        expression.arguments[0]
        for at, quantity in _all_quantities(model)
        if _bound(model, at, of_tensor=True) in ("positive", "not negative")
        and (expression := as_expression(quantity)).kind == "name"
        and expression.arguments[0] in model.parameters
    )


def _all_quantities(model: Groups) -> Iterator[tuple[Location, Quantity]]:
    """Every number or expression of the model, and where it stands."""
    if isinstance(model.gravity, (tuple, list)):
        yield from ((("gravity", k), part) for k, part in enumerate(model.gravity))
    else:
        yield ("gravity",), model.gravity
    for group in ("bodies", "joints", "points", "loads"):
        for name, element in getattr(model, group).items():
            yield from _quantities((group, name), element)
            for field in AXES_OF_JOINTS:
                given = getattr(element, field, None) or ()
                yield from (((group, name, field, k), part) for k, part in enumerate(given))
            for key, value in getattr(element, "initial", {}).items():
                yield (group, name, "initial", key), value
            if shape := getattr(element, "shape", None):
                yield from _quantities(_shape_place((group, name), shape), shape)


def _quantities(at: Location, element: object) -> Iterator[tuple[Location, Quantity]]:
    """Every number or expression of an element or shape at `at`, and where it stands."""
    for field, about in quantities_of(element).items():
        value = getattr(element, field)
        if about["is_vector"] or isinstance(value, (tuple, list)):
            yield from (((*at, field, k), part) for k, part in enumerate(value))
        elif value is not None:
            yield (*at, field), value


def _bound(model: Groups, at: Location, *, of_tensor: bool = False) -> str:
    """The bound of the number at `at`; `of_tensor`: that of a moment of inertia in space, too."""
    if at[0] == "gravity":
        return ""
    element = getattr(model, str(at[0]))[at[1]]
    is_moment = of_tensor and at[-2] == "inertia" and at[-1] in (0, 1, 2)
    about = quantities_of(element.shape if "shape" in at[2:3] else element)
    return about.get(str(at[-2] if is_moment else at[-1]), {}).get("bound", "")
