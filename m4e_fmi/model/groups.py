"""The groups of a model's elements, right or wrong: what the checks look at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from m4e_fmi.model.elements import Body, Joint, Parameter, Point
from m4e_fmi.model.expression import NOTHING, Expression, negative
from m4e_fmi.model.loads import Load
from m4e_fmi.model.quantity import Quantity, Vector, as_expression
from m4e_fmi.model.table import Table

STANDARD_GRAVITY = 9.80665  # m/s², CGPM 1901


@dataclass(frozen=True)
class Groups:
    """The fields of a `Model`; some of its elements may be wrong or missing."""

    name: str
    bodies: Mapping[str, Body]
    joints: Mapping[str, Joint]
    points: Mapping[str, Point] = field(default_factory=dict)
    loads: Mapping[str, Load] = field(default_factory=dict)
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)
    gravity: Quantity | Vector = STANDARD_GRAVITY
    description: str = ""
    dimensions: Literal[2, 3] = 2


def gravity_of(groups: Groups) -> tuple[Expression, ...]:
    """The acceleration of gravity against its direction, (x, y, z)."""
    gravity = groups.gravity
    if not isinstance(gravity, (tuple, list)):
        return NOTHING, NOTHING, as_expression(gravity)
    return tuple(negative(as_expression(part)) for part in gravity)
