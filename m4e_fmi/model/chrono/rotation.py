"""Orientations in space.

Quaternions are (e0, e1, e2, e3), scalar first, and map body axes to world axes. An angle about +Y
is the angle of our models: it turns +Z towards +X.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


DIGITS = 13
"""Decimals [m] that are kept: what rounding leaves of a zero is a zero."""
TURNED = 1e-6
"""How far [rad] the axis of a turn may be from that of a hinge which has made it."""


def quaternion(orientation: Sequence[float], *, degrees: bool) -> Quaternion:
    """The quaternion of an orientation in a file: four numbers, or three angles about Z, Y and X.

    The angles are [yaw, pitch, roll], applied as R_z·R_y·R_x (Chrono's ReadCardanAngles).
    ValueError for four numbers that are all zero.
    """
    if len(orientation) == 3:
        yaw, pitch, roll = (math.radians(a) if degrees else a for a in orientation)
        turns = ((yaw, (0, 0, 1)), (pitch, (0, 1, 0)), (roll, (1, 0, 0)))
        result: Quaternion = (1.0, 0.0, 0.0, 0.0)
        for angle, axis in turns:
            result = product(result, turned_about(axis, angle))
        return result
    length = math.hypot(*orientation)
    if not length > 0:
        raise ValueError("a quaternion of length zero is not an orientation")
    e0, e1, e2, e3 = (e / length for e in orientation)
    return e0, e1, e2, e3


def turned_about(axis: Sequence[float] | Array, angle: float) -> Quaternion:
    """The turn by `angle` [rad] about `axis` (3,) [1], which has length 1."""
    s = math.sin(angle / 2)
    return math.cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """First q, then p."""
    a, b, c, d = p
    e, f, g, h = q
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def rotated(q: Quaternion, v: Sequence[float]) -> Vector3:
    """A vector in body axes as one in world axes."""
    e0, *e = q
    _, x, y, z = product(product(q, (0.0, v[0], v[1], v[2])), (e0, -e[0], -e[1], -e[2]))
    return x, y, z


def matrix(q: Quaternion) -> Array:
    """The rotation matrix (3, 3) [1] of a quaternion."""
    return np.array([rotated(q, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]).T


def angle_about(axis: Array, turn: Array) -> float:
    """The angle (scalar) [rad] of the rotation `turn` (3, 3) [1] about `axis` (3,) [1].

    The axis has length 1; 0 if the rotation is about another.
    """
    if np.linalg.norm(turn @ axis - axis) > TURNED:
        return 0.0
    sine = axis @ (turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]) / 2
    return round(math.atan2(sine, (np.trace(turn) - 1) / 2), DIGITS) + 0.0


def rounded(v: Array) -> Vector3:
    """The vector `v` (3,) [1 or m], in which what rounding leaves of a zero is a zero."""
    x, y, z = (round(float(part), DIGITS) + 0.0 for part in v)
    return x, y, z
