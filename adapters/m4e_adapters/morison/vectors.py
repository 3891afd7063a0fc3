"""Vectors of three scalars, numbers or recorded."""

from __future__ import annotations

from m4e_fmi.program import Scalar, cos, sin

Number = Scalar | float
Vector = tuple[Number, Number, Number]
ZERO: Vector = (0.0, 0.0, 0.0)


def add(*vectors: Vector) -> Vector:
    """Their sum."""
    x, y, z = ZERO
    for a, b, c in vectors:
        x, y, z = x + a, y + b, z + c
    return x, y, z


def scaled(factor: Number, a: Vector) -> Vector:
    """Each component times `factor`."""
    return factor * a[0], factor * a[1], factor * a[2]


def difference(a: Vector, b: Vector) -> Vector:
    """a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def dot(a: Vector, b: Vector) -> Number:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def across(a: Vector, axis: Vector) -> Vector:
    """The part of `a` across a unit vector `axis`."""
    return difference(a, scaled(dot(a, axis), axis))


def turned(a: Vector, phi: Number, theta: Number, psi: Number) -> Vector:
    """R_z(psi) R_y(theta) R_x(phi) a, for angles in rad."""
    x, y, z = a
    y, z = cos(phi) * y - sin(phi) * z, sin(phi) * y + cos(phi) * z
    x, z = cos(theta) * x + sin(theta) * z, cos(theta) * z - sin(theta) * x
    return cos(psi) * x - sin(psi) * y, sin(psi) * x + cos(psi) * y, z
