"""Elementary functions (sin, sqrt, …) over any scalar: float, recording `Scalar`, SymPy expression.

An algorithm written with these (and + − * / **) has one source: run on floats it computes, run on a
tape it is recorded, run on SymPy symbols it is derived.
"""

from __future__ import annotations

from typing import Any, TypeVar

from m4e_fmi.program.tape import BINARY, UNARY, Scalar

AnyScalar = Any
"""A scalar of the same kind as others that it is computed with, or a float."""


ScalarLike = AnyScalar
"""A scalar to compute with: a float, a recording `Scalar` or a SymPy expression."""

S = TypeVar("S")
"""A kind of scalar."""


def _unary(name: str, value: AnyScalar) -> AnyScalar:
    if isinstance(value, Scalar):
        return value.record(name)
    if isinstance(value, int | float):
        return UNARY[name](value)
    import sympy

    return getattr(sympy, name)(value)


def _binary(name: str, symbolic: str, a: AnyScalar, b: AnyScalar) -> AnyScalar:
    if isinstance(a, Scalar):
        return a.record(name, b)
    if isinstance(b, Scalar):
        return b.tape.constant(a).record(name, b)
    if isinstance(a, int | float) and isinstance(b, int | float):
        return BINARY[name](a, b)
    import sympy

    # SymPy would compare long expressions in a maximum, at great cost and to no effect
    return getattr(sympy, symbolic)(a, b, evaluate=False)


def sin(x: S) -> S:
    """Sine of an angle [rad]."""
    return _unary("sin", x)


def cos(x: S) -> S:
    """Cosine of an angle [rad]."""
    return _unary("cos", x)


def tan(x: S) -> S:
    """Tangent of an angle [rad]."""
    return _unary("tan", x)


def asin(x: S) -> S:
    """Arc sine [rad], from −π/2 to π/2."""
    return _unary("asin", x)


def acos(x: S) -> S:
    """Arc cosine [rad], from 0 to π."""
    return _unary("acos", x)


def atan(x: S) -> S:
    """Arc tangent [rad], from −π/2 to π/2."""
    return _unary("atan", x)


def tanh(x: S) -> S:
    """Hyperbolic tangent."""
    return _unary("tanh", x)


def exp(x: S) -> S:
    """Exponential function."""
    return _unary("exp", x)


def log(x: S) -> S:
    """Natural logarithm."""
    return _unary("log", x)


def sqrt(x: S) -> S:
    """Square root."""
    return _unary("sqrt", x)


def sign(x: S) -> S:
    """−1, 0 or 1."""
    return _unary("sign", x)


def atan2(y: ScalarLike, x: ScalarLike) -> AnyScalar:
    """Angle [rad] of the point (x, y) from the x axis, from −π to π."""
    return _binary("atan2", "atan2", y, x)


def minimum(a: ScalarLike, b: ScalarLike) -> AnyScalar:
    """The smaller of two scalars."""
    return _binary("min", "Min", a, b)


def maximum(a: ScalarLike, b: ScalarLike) -> AnyScalar:
    """The larger of two scalars."""
    return _binary("max", "Max", a, b)
