"""Findings of checks, and the checks that elements share: expressions, vectors, references."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from m4e_fmi.errors import suggestion
from m4e_fmi.files.document import Location
from m4e_fmi.model.elements import NEUTRAL, Quantity, is_origin
from m4e_fmi.model.expression import (
    CONSTANTS,
    ExpressionError,
)
from m4e_fmi.model.groups import Groups
from m4e_fmi.model.quantity import as_expression, quantities_of
from m4e_fmi.units import TOO_LARGE, parse_quantity

TIME = "t"
SINGULAR = {"bodies": "body", "points": "point", "joints": "joint"}


@dataclass(frozen=True)
class ModelFinding:
    """One thing wrong, and where in the model: keys from the top, as in the file."""

    location: Location
    message: str
    remedy: str = ""


@dataclass(frozen=True)
class Names:
    """Names that are declared. One can be declared although its element is not usable."""

    bodies: frozenset[str]
    points: frozenset[str]
    parameters: frozenset[str]
    joints: frozenset[str]
    tables: frozenset[str]

    @classmethod
    def of(cls, model: Groups | Mapping[str, object]) -> Names:
        """The names of a model, or of a model file's plain data."""
        groups = []
        for group in cls.__dataclass_fields__:
            members = model.get(group) if isinstance(model, Mapping) else getattr(model, group)
            known = map(str, members) if isinstance(members, Mapping) else ()
            groups.append(frozenset(known))
        return cls(*groups)


ALONE = (
    "write 'mass: neutral'; where more depends on this mass, declare a parameter and connect "
    "<body>.neutral_mass of the hydrodynamics component with it"
)
Complaint = tuple[str, str]
"""A message and a remedy."""


@dataclass(frozen=True)
class Known:
    """The names that an expression may use; `motion` judges those with dots, if it may use any.

    `dimensions` are those of the model.
    """

    names: frozenset[str]
    motion: Callable[[str], Complaint | None] | None = None
    dimensions: int = 2

    def complaint(self, name: str) -> Complaint | None:
        """Complaint about `name`; None if it is known."""
        if name in self.names:
            return None
        if name.lower() == NEUTRAL:
            return f"{name!r} is not known in expressions", ALONE
        if name == "t":
            return "'t' is not known here", "only loads may depend on the time"
        if "." not in name:
            return f"{name!r} is not declared", suggestion(name, [*self.names, *CONSTANTS], "names")
        if self.motion is None:
            return f"{name!r} is not known here", "only loads may depend on the motion"
        return self.motion(name)


def quantities(
    at: Location, element: object, known: Known, *, leaving_out: Collection[str] = ()
) -> Iterator[ModelFinding]:
    """Problems of the numbers and expressions of an element; None where None is one."""
    for field, about in quantities_of(element).items():
        value = getattr(element, field)
        if field in leaving_out or (about["is_optional"] and value is None):
            continue
        if about["is_vector"]:
            yield from vectors((*at, field), value, known)
        else:
            yield from numbers((*at, field), value, known, about["counts"])


PLANAR = "the model is planar (there is no 'dimensions: 3')"
SPATIAL = "the model is spatial ('dimensions: 3')"
VECTORS = {2: f"{PLANAR}: write [x, z]", 3: f"{SPATIAL}: write [x, y, z]"}
"""Remedies for what is no vector, by the model's dimensions."""


def vectors(at: Location, value: Sequence[Quantity], known: Known) -> Iterator[ModelFinding]:
    """Problems of a vector of numbers or expressions."""
    if isinstance(value, (tuple, list)):
        count = len(value)
    else:
        count = next(iter(getattr(value, "shape", ())), None)  # of NumPy's arrays
    if is_origin(value):
        return
    if count != known.dimensions:
        expected = VECTORS[known.dimensions].partition("write ")[2]
        got = _entries(count) if isinstance(count, int) else repr(value)
        place = next((key for key in reversed(at) if isinstance(key, str)), "")
        yield ModelFinding(
            at, f"{place}: expected {expected}, got {got}", VECTORS[known.dimensions]
        )
        return
    for index, entry in enumerate(value):
        yield from expressions((*at, index), entry, known)


def numbers(
    at: Location, value: Any, known: Known, counts: Collection[int]
) -> Iterator[ModelFinding]:
    """Problems of a number or expression; in space of as many as one of the `counts`, if any."""
    is_list = isinstance(value, (tuple, list))
    if known.dimensions == 2 or not counts:
        if is_list:
            message = f"{at[-1]}: expected a number or an expression, got {_entries(len(value))}"
            yield ModelFinding(
                at,
                message,
                f"{PLANAR}: give one number" if counts or at == ("gravity",) else "give one number",
            )
        else:
            yield from expressions(at, value, known)
    elif at[-1] == "moment" and not is_list and value == 0:  # as it is where it is not given
        return
    elif not is_list or len(value) not in counts:
        wanted = " or ".join(map(str, counts))
        got = _entries(len(value)) if is_list else "one"
        message = f"{at[-1]}: expected a list of {wanted} numbers, got {got}"
        yield ModelFinding(at, message, f"{SPATIAL}: write {IN_SPACE[str(at[-1])]}")
    else:
        for index, entry in enumerate(value):
            yield from expressions((*at, index), entry, known)


def _entries(count: int) -> str:
    return f"{count} entr{'y' if count == 1 else 'ies'}"


IN_SPACE = {
    "inertia": "[Ixx, Iyy, Izz], or [Ixx, Iyy, Izz, Ixy, Iyz, Izx]",
    "moment": "[Mx, My, Mz]",
}


def expressions(at: Location, value: Quantity, known: Known) -> Iterator[ModelFinding]:
    """Problems of a number or an expression."""
    try:
        expression = as_expression(value)
    except ExpressionError as error:
        where = f" (column {error.column} of {value!r})" if error.column else ""
        yield ModelFinding(at, f"{error}{where}", error.remedy or _instead(value))
        return
    for name in sorted(expression.names()):
        complaint = known.complaint(name)
        if complaint:
            yield ModelFinding(at, *complaint)


def _instead(text: object) -> str:
    """Remedy: what to write in place of `text`, which is no expression."""
    try:
        given = parse_quantity(str(text))
    except ValueError:
        return "allowed: numbers without a unit, names, + - * / **, functions"
    if not (number := given.si_number):
        return TOO_LARGE
    parameter = f"{{value: {given.value:g}, unit: {given.unit.text}}}"
    return f"write {number}, which is SI, or the name of a parameter that is {parameter}"


def reference(at: Location, name: str, known: Iterable[str], noun: str) -> Iterator[ModelFinding]:
    """A finding if `name` is not one of the `known` bodies, points or joints (`noun`)."""
    if name not in known:
        yield ModelFinding(at, f"unknown {SINGULAR[noun]} {name!r}", suggestion(name, known, noun))
