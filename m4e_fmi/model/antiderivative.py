"""Integrals in closed form of the laws that engineers write, for the potential of a spring.

Known are polynomials; sin, cos, exp, tanh, atan and log of a linear expression; products of powers
of one linear expression, its absolute value, its sign and its positive or negative part; sums of
these, and factors that do not depend on the variable. What is not known has no potential here: None
is an honest answer, a wrong potential is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import reduce

from m4e_fmi.model.expression import Expression, Values

Maybe = Expression | None


def number(value: float) -> Expression:
    """A constant as an Expression."""
    return Expression("number", (float(value),))


ZERO, ONE, TWO = number(0), number(1), number(2)
HIGHEST_DEGREE = 12
MOST_FACTORS = 4
"""Of a sum raised to a power that is multiplied out: the terms grow exponentially with them."""
MOST_SUMS = 8
"""In a product that is multiplied out, for the same reason."""


def antiderivative(law: Expression, variable: str) -> Maybe:
    """An expression whose derivative by `variable` is `law`, None if none is known."""
    if variable not in law.names():
        return _times(law, Expression("name", (variable,)))
    coefficients = _polynomial(law, variable)
    if coefficients is not None:
        return _of_polynomial(coefficients, variable)
    match law.kind, law.arguments:
        case "neg", (a,):
            return _map(antiderivative(a, variable), lambda A: Expression("neg", (A,)))
        case "add" | "sub", (a, b):
            A, B = antiderivative(a, variable), antiderivative(b, variable)
            return None if A is None or B is None else Expression(law.kind, (A, B))
        case "mul", (a, b) if variable not in b.names():
            return _map(antiderivative(a, variable), lambda A: _times(b, A))
        case "mul", (a, b) if variable not in a.names():
            return _map(antiderivative(b, variable), lambda B: _times(a, B))
        case "div", (a, b) if variable not in b.names():
            return _map(antiderivative(a, variable), lambda A: _over(A, b))
        case _:
            pass
    if law.kind == "mul" and _sums(law) <= MOST_SUMS:
        for factor, other in (law.arguments, law.arguments[::-1]):
            if factor.kind in ("add", "sub"):
                terms = (_times(term, other) for term in factor.arguments)
                return antiderivative(Expression(factor.kind, tuple(terms)), variable)
    return _of_function(law, variable) or _of_powers(law, variable)


def _map(value: Maybe, function: Callable[[Expression], Expression]) -> Maybe:
    return None if value is None else function(value)


def _sums(e: Expression) -> int:
    """How many sums and differences there are in `e`."""
    if e.kind in ("number", "name"):
        return 0
    return (e.kind in ("add", "sub")) + sum(_sums(a) for a in e.arguments)


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


def _slope(u: Expression, variable: str) -> Maybe:
    """du/dx if u is linear in x, `variable`."""
    coefficients = _polynomial(u, variable)
    return coefficients[1] if coefficients is not None and len(coefficients) == 2 else None


def _of_function(law: Expression, variable: str) -> Maybe:
    """Of f(u) with u linear: F(u)/u′."""
    if law.kind not in _INTEGRALS:
        return None
    (u,) = law.arguments
    return _map(_slope(u, variable), lambda slope: _over(_INTEGRALS[law.kind](u), slope))


def _log_cosh(u: Expression) -> Expression:
    """log cosh u = |u| + log(1 + exp(−2|u|)) − log 2, which does not overflow."""
    size = _call("abs", u)
    decayed = _call("exp", _times(number(-2), size))
    return _minus(_plus(size, _call("log", _plus(ONE, decayed))), _call("log", TWO))


_INTEGRALS: dict[str, Callable[[Expression], Expression]] = {
    "sin": lambda u: _call("neg", _call("cos", u)),
    "cos": lambda u: _call("sin", u),
    "exp": lambda u: _call("exp", u),
    "tanh": _log_cosh,
    "atan": lambda u: _minus(
        _times(u, _call("atan", u)), _over(_call("log", _plus(ONE, _times(u, u))), TWO)
    ),
    "log": lambda u: _minus(_times(u, _call("log", u)), u),
}


class _UnknownError(Exception):
    """No product of powers."""


def _of_powers(law: Expression, variable: str) -> Maybe:
    """Of a product of powers of u, |u|, sign u, max(0, u) or min(0, u), with u linear."""
    try:
        powers = _Powers(variable)
        powers.multiply(law, 1.0)
        return powers.integral()
    except _UnknownError:
        return None


class _Powers:
    """factor · |u|^power · (sign u)^odd, on all of the line or on the `part` where max or min is u.

    A power that is no whole number is that of something positive.
    """

    def __init__(self, variable: str) -> None:
        self.variable = variable
        self.factor = ONE
        self.u: Maybe = None
        self.power = 0.0
        self.odd = False
        self.part = ""

    def multiply(self, e: Expression, power: float) -> None:
        """Multiply by e^power; _UnknownError if that leaves the form."""
        if self.variable not in e.names():
            raised = e if power == 1 else _call("pow", e, number(power))
            self.factor = _times(self.factor, raised)
            return
        first, *others = e.arguments
        if e.kind == "mul":
            self.multiply(first, power)
            self.multiply(others[0], power)
        elif e.kind == "div":
            self.multiply(first, power)
            self.multiply(others[0], -power)
        elif e.kind == "neg" and power == 1:
            self.factor = _times(number(-1), self.factor)
            self.multiply(first, power)
        elif e.kind == "pow" and others[0].kind == "number":
            self.multiply(first, power * others[0].arguments[0])
        elif e.kind == "sqrt":
            self.multiply(first, power / 2)
        elif e.kind == "abs":
            self._raise(first, power, odd=False)
        elif e.kind == "sign" and power == 1:
            self._raise(first, 0.0, odd=True)
        elif e.kind in ("max", "min") and ZERO in e.arguments and self.part in ("", e.kind):
            self.part = e.kind
            self._raise(others[0] if first == ZERO else first, power, odd=power % 2 == 1)
        else:
            self._raise(e, power, odd=power % 2 == 1)

    def _raise(self, u: Expression, power: float, *, odd: bool) -> None:
        """Multiply by |u|^power (sign u)^odd."""
        if self.u not in (None, u):
            raise _UnknownError
        self.u, self.power, self.odd = u, self.power + power, self.odd != odd

    def integral(self) -> Maybe:
        slope = None if self.u is None else _slope(self.u, self.variable)
        if self.u is None or slope is None or (self.part and self.power <= 0):
            return None
        base = _call(self.part, ZERO, self.u) if self.part else self.u
        size, up = _call("abs", base), number(self.power + 1)
        raised = _call("log", size) if up == ZERO else _over(_call("pow", size, up), up)
        if not self.odd:  # what is even has an odd integral
            raised = _times(_call("sign", base), raised)
        return _over(_times(self.factor, raised), slope)


def potential(law: Expression, variable: str, parameters: Values) -> Maybe:
    """∫ `law` from 0, None if it is not known in closed form or not finite at 0.

    `law` depends on the variable and on `parameters` only, whose values say if it is finite.
    """
    integral = antiderivative(law, variable)
    if integral is None:
        return None
    start = _replaced(integral, variable, ZERO)
    try:
        finite = math.isfinite(start.evaluate(parameters))
    except (ArithmeticError, ValueError):
        return None
    return _minus(integral, start) if finite else None


def _replaced(e: Expression, variable: str, by: Expression) -> Expression:
    if e.kind == "number":
        return e
    if e.kind == "name":
        return by if e.arguments == (variable,) else e
    return Expression(e.kind, tuple(_replaced(a, variable, by) for a in e.arguments))
