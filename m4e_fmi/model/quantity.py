"""Quantities as authors give them (numbers, texts, expressions of SymPy), as Expressions."""

from __future__ import annotations

import math
import sys
from numbers import Real
from typing import TYPE_CHECKING

from m4e_fmi.model.expression import Expression, ExpressionError, parse

if TYPE_CHECKING:
    import sympy


def as_expression(value: float | str | Expression | sympy.Expr) -> Expression:
    """`value` as an Expression; ExpressionError if a text does not follow the grammar.

    Expressions of SymPy may hold numbers, π, symbols, + − * / **, and the functions known here.
    """
    if isinstance(value, Expression):
        return value
    if isinstance(value, str):
        return parse(value)
    if "sympy" in sys.modules:
        from m4e_fmi.model.sympy_expression import from_sympy, is_sympy

        if is_sympy(value):
            return from_sympy(value)
    item = getattr(value, "item", None)
    if item is not None and getattr(value, "shape", None) == ():  # an array without dimensions
        return as_expression(item())
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ExpressionError(f"expected a number or an expression, got {value!r}")
    if not math.isfinite(value):
        raise ExpressionError(f"expected a finite number, got {value}")
    return Expression("number", (float(value),))
