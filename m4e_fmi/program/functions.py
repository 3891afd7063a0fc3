"""Elementary functions over any scalar: float, recording `Scalar`, SymPy expression.

An algorithm written with these (and + − * / **) has one source: run on floats it computes, run on a
tape it is recorded, run on SymPy symbols it is derived.
"""

from __future__ import annotations

import math
from typing import Any

from m4e_fmi.program.tape import Scalar


def _unary(name: str, value: Any) -> Any:
    if isinstance(value, Scalar):
        return value.record(name)
    if isinstance(value, int | float):
        return getattr(math, name)(value)
    import sympy

    return getattr(sympy, name)(value)


def _binary(name: str, numeric: Any, symbolic: str, a: Any, b: Any) -> Any:
    if isinstance(a, Scalar):
        return a.record(name, b)
    if isinstance(b, Scalar):
        return b.tape.constant(a).record(name, b)
    if isinstance(a, int | float) and isinstance(b, int | float):
        return numeric(a, b)
    import sympy

    # SymPy would compare long expressions in a maximum, at great cost and to no effect
    return getattr(sympy, symbolic)(a, b, evaluate=False)


def sin(x: Any) -> Any:
    return _unary("sin", x)


def cos(x: Any) -> Any:
    return _unary("cos", x)


def tan(x: Any) -> Any:
    return _unary("tan", x)


def asin(x: Any) -> Any:
    return _unary("asin", x)


def acos(x: Any) -> Any:
    return _unary("acos", x)


def atan(x: Any) -> Any:
    return _unary("atan", x)


def tanh(x: Any) -> Any:
    return _unary("tanh", x)


def exp(x: Any) -> Any:
    return _unary("exp", x)


def log(x: Any) -> Any:
    return _unary("log", x)


def sqrt(x: Any) -> Any:
    return _unary("sqrt", x)


def sign(x: Any) -> Any:
    """−1, 0 or 1."""
    if isinstance(x, int | float):
        return float((x > 0) - (x < 0))
    return _unary("sign", x)


def atan2(y: Any, x: Any) -> Any:
    return _binary("atan2", math.atan2, "atan2", y, x)


def minimum(a: Any, b: Any) -> Any:
    return _binary("min", min, "Min", a, b)


def maximum(a: Any, b: Any) -> Any:
    return _binary("max", max, "Max", a, b)
