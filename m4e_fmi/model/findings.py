"""Findings of checks, and the checks that elements share: expressions, vectors, references."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from difflib import SequenceMatcher
from typing import TYPE_CHECKING

from m4e_fmi.errors import CLOSE, suggestion
from m4e_fmi.files.document import Location
from m4e_fmi.model.elements import GROUND, NEUTRAL, Quantity
from m4e_fmi.model.expression import (
    CONSTANTS,
    FUNCTIONS,
    ExpressionError,
    UnknownFunctionError,
)
from m4e_fmi.model.quantity import as_expression
from m4e_fmi.units import TOO_LARGE, parse_quantity

if TYPE_CHECKING:
    from types import SimpleNamespace

    from _typeshed import DataclassInstance

    from m4e_fmi.model.model import Model

    Elements = Model | SimpleNamespace
    """A model, or the groups of one that cannot be made, because some elements are wrong."""

TIME = "t"
SINGULAR = {"bodies": "body", "points": "point", "joints": "joint"}


@dataclass(frozen=True)
class Finding:
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
    def of(cls, model: Model | Mapping[str, object]) -> Names:
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
    """The names that an expression may use; `motion` judges those with dots, if it may use any."""

    names: frozenset[str]
    motion: Callable[[str], Complaint | None] | None = None

    def complaint(self, name: str) -> Complaint | None:
        """Complaint about `name`; None if it is known."""
        if name in self.names:
            return None
        if name.lower() == NEUTRAL:
            return f"{name!r} is not known in expressions", ALONE
        if name == "t":
            return "'t' is not known here", "only loads may depend on the time"
        if name == "time" and "t" in self.names:
            return "'time' is not declared", "the time is called 't'"
        if "." not in name:
            remedy = suggestion(name, [*self.names, *CONSTANTS], "names")
            if SequenceMatcher(None, name.lower(), NEUTRAL).ratio() >= CLOSE:
                remedy = f"did you mean {NEUTRAL!r}, the mass of a floating body?"
            return f"{name!r} is not declared", remedy
        if self.motion is None:
            return f"{name!r} is not known here", "only loads may depend on the motion"
        return self.motion(name)


def quantities(
    at: Location, element: DataclassInstance, known: Known, *, leaving_out: Collection[str] = ()
) -> Iterator[Finding]:
    """Problems of the numbers and expressions of an element; None where None is one."""
    optional = {field.name for field in fields(element) if field.default is None}
    for field in getattr(element, "scalars", ()):
        is_absent = field in optional and getattr(element, field) is None
        if not is_absent and field not in leaving_out:
            yield from expressions((*at, field), getattr(element, field), known)
    for field in getattr(element, "vectors", ()):
        yield from vectors((*at, field), getattr(element, field), known)


PLANAR_VECTOR = "models are planar: write [x, z]"


def vectors(at: Location, value: Sequence[Quantity], known: Known) -> Iterator[Finding]:
    """Problems of a pair (x, z) of numbers or expressions."""
    is_pair = isinstance(value, tuple | list) and len(value) == 2
    if not is_pair and getattr(value, "shape", None) != (2,):  # of NumPy's arrays
        yield Finding(at, f"expected two entries, got {value!r}", PLANAR_VECTOR)
        return
    for index, entry in enumerate(value):
        yield from expressions((*at, index), entry, known)


def expressions(at: Location, value: Quantity, known: Known) -> Iterator[Finding]:
    """Problems of a number or an expression."""
    try:
        expression = as_expression(value)
    except ExpressionError as error:
        where = f" (column {error.column} of {value!r})" if error.column else ""
        yield Finding(at, f"{error}{where}", _instead(value, error, known))
        return
    for name in sorted(expression.names()):
        complaint = known.complaint(name)
        if complaint:
            yield Finding(at, *complaint)


def _instead(value: Quantity, error: ExpressionError, known: Known) -> str:
    """Remedy: what to write in place of `value`, which is no expression because of `error`."""
    text = value if isinstance(value, str) else ""
    if isinstance(error, UnknownFunctionError):
        return suggestion(error.name.rpartition(".")[2], FUNCTIONS, "functions")
    if re.search(r"[<>=]|\bif\b", text):
        return "there are no conditions: use max, min, sign or tanh, as in max(0, t - 2)"
    if re.fullmatch(r"\s*[+-]?\d+,\d+\s*", text):
        return f"numbers have a decimal point: {text.strip().replace(',', '.')}"
    factor = re.match(r"\s*([\d.]+)\s*([A-Za-z_]\w*)\s*($|[-+*(])", text)
    if factor and factor[2] in {*known.names, *FUNCTIONS, *CONSTANTS}:
        return f"write a product with *, as in {factor[1]}*{factor[2]}"
    try:
        given = parse_quantity(text)
    except ValueError:
        return "allowed: numbers without a unit, names, + - * / **, functions"
    if not (number := given.si_number):
        return TOO_LARGE
    parameter = f"{{value: {given.value:g}, unit: {given.unit.text}}}"
    return f"write {number}, which is SI, or the name of a parameter that is {parameter}"


def reference(at: Location, name: str, known: Iterable[str], noun: str) -> Iterator[Finding]:
    """A finding if `name` is not one of the `known` bodies, points or joints (`noun`)."""
    if name in ("world", "earth", "origin", "inertial") and GROUND in known and name not in known:
        yield Finding(at, f"unknown {SINGULAR[noun]} {name!r}", f"did you mean {GROUND!r}?")
    elif name not in known:
        yield Finding(at, f"unknown {SINGULAR[noun]} {name!r}", suggestion(name, known, noun))
