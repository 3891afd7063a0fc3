"""Quantities as authors give them (numbers, texts, expressions of SymPy), as Expressions."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import MISSING, field
from functools import cache, reduce
from numbers import Real
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from m4e_fmi.model.expression import FUNCTIONS, Expression, ExpressionError, parse

if TYPE_CHECKING:
    import sympy

Quantity: TypeAlias = "float | str | Expression | sympy.Expr"
Vector: TypeAlias = "tuple[Quantity, ...]"
"""(x, z) in a model of the plane, (x, y, z) in one of space."""
Bound = Literal["", "positive", "not negative", "seldom negative"]


def given(
    unit: str,
    default: object = MISSING,
    *,
    is_vector: bool = False,
    bound: Bound = "",
    counts: tuple[int, ...] = (),
) -> Any:
    """A field of an element that is a number or expression in `unit`, or a vector of these.

    None, as a default, is no number. `bound` is that of its value; a warning tells those that are
    "seldom negative". In space it has as many numbers as one of `counts`, if there are any.
    """
    about = {"unit": unit, "is_vector": is_vector, "bound": bound, "counts": counts}
    return field(default=default, metadata=about | {"is_optional": default is None})


About = dict[str, Mapping[str, Any]]


def quantities_of(element: object) -> About:
    """The fields of an element that are `given` as numbers, and what is said of each."""
    return _quantities_of(type(element))


@cache
def _quantities_of(kind: type) -> About:
    every = vars(kind)["__dataclass_fields__"].values()
    return {one.name: one.metadata for one in every if one.metadata}


_SYMPY_NAMES = {"Abs": "abs", "Min": "min", "Max": "max"}


def as_expression(value: float | str | Expression | sympy.Expr) -> Expression:
    """`value` as an Expression; ExpressionError if a text does not follow the grammar.

    Expressions of SymPy may hold numbers, π, symbols, + − * / **, and the functions known here.
    """
    if type(value) is float and math.isfinite(value):  # nearly all of them
        return Expression("number", (value,))
    if isinstance(value, Expression):
        return value
    if isinstance(value, str):
        return parse(value)
    if (sympy := sys.modules.get("sympy")) and isinstance(value, sympy.Basic):
        return _from_sympy(value)
    item = getattr(value, "item", None)
    if item is not None and getattr(value, "shape", None) == ():  # an array without dimensions
        return as_expression(item())
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ExpressionError(f"expected a number or an expression, got {value!r}")
    if not math.isfinite(value):
        raise ExpressionError(f"expected a finite number, got {value}")
    return Expression("number", (float(value),))


def _from_sympy(node: sympy.Basic) -> Expression:
    """`node` as an Expression; ExpressionError names what has no counterpart."""
    import sympy

    if isinstance(node, sympy.Rational):
        top, bottom = (Expression("number", (float(part),)) for part in (node.p, node.q))
        return top if node.q == 1 else Expression("div", (top, bottom))
    if isinstance(node, sympy.Float):
        return Expression("number", (float(node),))
    if node is sympy.pi or isinstance(node, sympy.Symbol):
        return Expression("name", (str(node),))
    if node is sympy.E:
        return Expression("exp", (Expression("number", (1.0,)),))
    if isinstance(node, sympy.Add):
        return reduce(_plus, map(_from_sympy, node.args[1:]), _from_sympy(node.args[0]))
    if isinstance(node, sympy.Mul):
        return _product(node)
    if isinstance(node, sympy.Pow):
        return _power(node)
    name = _SYMPY_NAMES.get(type(node).__name__, type(node).__name__)
    if name not in FUNCTIONS:
        raise ExpressionError(f"{name} of SymPy has no counterpart here: {node}")
    arguments = [_from_sympy(argument) for argument in node.args]
    if name in ("min", "max"):
        return reduce(lambda a, b: Expression(name, (a, b)), arguments)
    return Expression(name, tuple(arguments))


def _plus(total: Expression, term: Expression) -> Expression:
    if term.kind == "neg":
        return Expression("sub", (total, term.arguments[0]))
    return Expression("add", (total, term))


def _product(node: sympy.Mul) -> Expression:
    """Numerator over denominator, which SymPy keeps as factors with a negative power."""
    import sympy

    above: list[sympy.Expr] = []
    below: list[sympy.Expr] = []
    for factor in node.args:
        power = factor.exp if isinstance(factor, sympy.Pow) else sympy.Integer(1)
        negative = power.is_Number and power.is_negative
        (below if negative else above).append(1 / factor if negative else factor)
    negated = sympy.Integer(-1) in above
    if negated:
        above.remove(sympy.Integer(-1))
    result = _times(above)
    if below:
        result = Expression("div", (result, _times(below)))
    return Expression("neg", (result,)) if negated else result


def _times(factors: list[sympy.Expr]) -> Expression:

    if not factors:
        return Expression("number", (1.0,))
    return reduce(lambda a, b: Expression("mul", (a, b)), map(_from_sympy, factors))


def _power(node: sympy.Pow) -> Expression:
    import sympy

    base, exponent = node.args
    if exponent == sympy.Rational(1, 2):
        return Expression("sqrt", (_from_sympy(base),))
    if exponent.is_Number and exponent.is_negative:
        return Expression("div", (Expression("number", (1.0,)), _from_sympy(1 / node)))
    return Expression("pow", (_from_sympy(base), _from_sympy(exponent)))
