"""Potentials of springs whose law is a polynomial of the extension or twist.

Any other law counts by its power: no potential is an honest answer, a wrong one is not.
"""

from __future__ import annotations

from functools import reduce

from m4e_fmi.model.expression import Expression


def number(value: float) -> Expression:
    """A constant as an Expression."""
    return Expression("number", (float(value),))


ZERO, ONE = number(0), number(1)
HIGHEST_DEGREE = 12
MOST_FACTORS = 4
"""Of a sum raised to a power that is multiplied out: the terms grow exponentially with them."""


def potential(law: Expression, variable: str) -> Expression | None:
    """∫ `law` from 0 by `variable`, None if it is no polynomial of it."""
    coefficients = _polynomial(law, variable)
    return None if coefficients is None else _of_polynomial(coefficients, variable)


def _plus(a: Expression, b: Expression) -> Expression:
    return b if a == ZERO else a if b == ZERO else Expression("add", (a, b))


def _times(a: Expression, b: Expression) -> Expression:
    if ZERO in (a, b):
        return ZERO
    return b if a == ONE else a if b == ONE else Expression("mul", (a, b))


def _over(a: Expression, b: Expression) -> Expression:
    return a if b == ONE else Expression("div", (a, b))


def _minus(a: Expression, b: Expression) -> Expression:
    return a if b == ZERO else Expression("sub", (a, b))


def _call(name: str, *arguments: Expression) -> Expression:
    return Expression(name, arguments)


def _polynomial(e: Expression, variable: str) -> list[Expression] | None:
    """Coefficients of 1, x, x², … if `e` is a polynomial in x, `variable`."""
    if variable not in e.names():
        return [e]
    if e.kind == "name":
        return [ZERO, ONE]
    if e.kind == "pow":
        base, (kind, exponent) = e.arguments[0], (e.arguments[1].kind, e.arguments[1].arguments)
        most = HIGHEST_DEGREE if base.kind == "name" else MOST_FACTORS
        factor = _polynomial(base, variable)
        if factor is None or kind != "number" or exponent[0] not in range(1, most + 1):
            return None
        return _short(reduce(_product, [factor] * int(exponent[0]), [ONE]))
    if e.kind not in ("neg", "add", "sub", "mul", "div"):
        return None
    parts = [_polynomial(a, variable) for a in e.arguments]
    if any(part is None for part in parts):
        return None
    first, second = parts[0] or [], parts[-1] or []
    if e.kind == "neg":
        return [_call("neg", c) for c in first]
    if e.kind == "mul":
        return _short(_product(first, second))
    if e.kind == "div":
        return [_over(c, second[0]) for c in first] if len(second) == 1 else None
    size = max(len(first), len(second))
    first, second = (part + [ZERO] * (size - len(part)) for part in (first, second))
    combine = _plus if e.kind == "add" else _minus
    return [combine(a, b) for a, b in zip(first, second, strict=True)]


def _short(coefficients: list[Expression]) -> list[Expression] | None:
    return coefficients if len(coefficients) <= HIGHEST_DEGREE + 1 else None


def _product(a: list[Expression], b: list[Expression]) -> list[Expression]:
    result = [ZERO] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] = _plus(result[i + j], _times(x, y))
    return result


def _of_polynomial(coefficients: list[Expression], variable: str) -> Expression:
    x, total = Expression("name", (variable,)), ZERO
    for power, c in enumerate(coefficients, start=1):
        raised = x if power == 1 else _call("pow", x, number(power))
        total = _plus(total, _times(_over(c, number(power)), raised))
    return total
