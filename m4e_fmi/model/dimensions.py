"""Dimensions of expressions, as far as units are given.

Parameters and tables have units; a unit of ``1`` says nothing. Numbers, functions, the time and the
motion have the unit that makes sense where they stand: they match anything, and so does a product
with one of them. Angles are plain numbers: rad and deg are no dimension.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from m4e_fmi.files.document import Location
from m4e_fmi.joints import JOINT_TYPES
from m4e_fmi.model.elements import Quantity
from m4e_fmi.model.expression import CONSTANTS, Expression
from m4e_fmi.model.findings import ModelFinding
from m4e_fmi.model.groups import Groups
from m4e_fmi.model.quantity import as_expression, quantities_of
from m4e_fmi.units import BASE_UNITS, parse_unit

Dimension = tuple[Fraction, ...]
"""Exponents of the base units but rad."""
Maybe = Dimension | None
"""None where any would do."""

PLAIN: Dimension = (Fraction(0),) * (len(BASE_UNITS) - 1)
OF_NUMBERS = ("sin", "cos", "tan", "asin", "acos", "atan", "exp", "log", "tanh")
ALIKE = {"add": "+", "sub": "-", "min": "and", "max": "and", "atan2": "and"}
NAMED = ["N", "N.m", "W", "N/m", "N.s/m", "N.m.s", "Pa", "m/s", "m/s2", "kg.m2", "kg/m", "1/s"]
"""Units that a dimension is told in where it has one of them."""


class DimensionError(ValueError):
    """Parts of an expression have dimensions that do not belong together."""


def dimension_of(unit: str) -> Maybe:
    """The dimension of a unit; None of ``1``, which is any, and of what is no unit."""
    try:
        exponents = parse_unit(unit).exponents
    except ValueError:
        return None
    pairs = zip(BASE_UNITS, exponents, strict=True)
    return None if unit == "1" else tuple(Fraction(e) for base, e in pairs if base != "rad")


def dimension(e: Expression, known: Mapping[str, Maybe]) -> Maybe:
    """The dimension of `e`; DimensionError names the part that has none."""
    if e.kind == "number":
        return None
    if e.kind == "name":
        (name,) = e.arguments
        return PLAIN if name in CONSTANTS else known.get(name)
    if e.kind == "pow":
        return _power(e, known)
    parts = [dimension(a, known) for a in e.arguments]
    if e.kind in OF_NUMBERS:
        if parts[0] not in (None, PLAIN):
            where = f"{e.kind}({e.arguments[0]})"
            raise DimensionError(
                f"the argument of {where} is in {unit_text(parts[0])}, not a number"
            )
        return None
    if e.kind in ALIKE:
        if None not in parts and parts[0] != parts[1]:
            a, b = (f"{a} [{unit_text(p)}]" for a, p in zip(e.arguments, parts, strict=True))
            raise DimensionError(f"{a} {ALIKE[e.kind]} {b} have different dimensions")
        return None if e.kind == "atan2" else next((p for p in parts if p is not None), None)
    match e.kind:
        case "mul" | "div":
            first, second = parts
            sign = 1 if e.kind == "mul" else -1
            return None if first is None or second is None else _sum(first, second, sign)
        case "sqrt":
            return None if parts[0] is None else tuple(x / 2 for x in parts[0])
        case "sign":
            return None
        case _:  # neg, abs
            return parts[0]


def _sum(a: Dimension, b: Dimension, sign: int) -> Dimension:
    return tuple(x + sign * y for x, y in zip(a, b, strict=True))


def _power(e: Expression, known: Mapping[str, Maybe]) -> Maybe:
    base, exponent = e.arguments
    times = dimension(exponent, known)
    if times not in (None, PLAIN):
        raise DimensionError(f"the exponent {exponent} is in {unit_text(times)}, not a number")
    of = dimension(base, known)
    sign, number = (-1, exponent.arguments[0]) if exponent.kind == "neg" else (1, exponent)
    if of is None or number.kind != "number":
        return of if of == PLAIN else None
    return tuple(x * sign * Fraction(number.arguments[0]) for x in of)


def unit_text(of: Maybe) -> str:
    """A dimension as a unit."""
    for unit in NAMED:
        if dimension_of(unit) == of:
            return unit
    bases = [base for base in BASE_UNITS if base != "rad"]
    pairs = [(base, x) for base, x in zip(bases, of or PLAIN, strict=True) if x]
    return ".".join(base if x == 1 else f"{base}{x}" for base, x in pairs) or "1"


def dimension_findings(
    model: Groups, quantities: Iterator[tuple[Location, Quantity]]
) -> Iterator[ModelFinding]:
    """Findings on `quantities` of a model with a dimension that their place does not take."""
    units = {name: p.unit for name, p in (*model.parameters.items(), *model.tables.items())}
    known = {name: of for name, unit in units.items() if (of := dimension_of(unit)) is not None}
    for at, value in quantities:
        expression = as_expression(value)
        if known.keys().isdisjoint(expression.names()):
            continue
        place = at[-1] if isinstance(at[-1], str) else at[-2]
        try:
            found = dimension(expression, known)
        except DimensionError as error:
            yield ModelFinding(at, f"{place}: {error}", "check the units of its names")
            continue
        unit = expected_unit(model, at)
        expected = PLAIN if unit == "rad" else dimension_of(unit)
        if found is None or expected is None or found == expected:
            continue
        got = units[expression.arguments[0]] if expression.kind == "name" else unit_text(found)
        message = f"{place}: {value} is in {got}, expected {unit}"
        yield ModelFinding(at, message, f"write an expression that is in {unit}")


def expected_unit(model: Groups, at: Location) -> str:
    """The unit of the quantity at a place of a model; "" where any will do."""
    if at[0] == "gravity":
        return "m/s2"
    group, name, field = at[:3]
    element = getattr(model, str(group))[name]
    if field == "shape":
        element = element.shape
        field = str(at[-1] if isinstance(at[-1], str) else at[-2])
    if field == "initial":
        joint_type = JOINT_TYPES[model.dimensions].get(element.type)
        return joint_type.start_units.get(str(at[3]), "") if joint_type else ""
    about = quantities_of(element).get(str(field))
    unit = about["unit"] if about else ""
    of_angle, _, of_distance = unit.partition(" or ")
    if not of_distance:
        return unit
    joint = model.joints.get(element.joint)  # it, its type and the coordinate may be wrong
    joint_type = JOINT_TYPES[model.dimensions].get(joint.type) if joint else None
    coordinates = joint_type.coordinates if joint_type else ()
    meant = [c for c in coordinates if element.along in ("", c.position)]
    if len(meant) != 1:
        return ""
    return of_angle if meant[0].is_angle else of_distance
