"""Pulls of the analytic elastic catenary, of a chain of 150 kg/m and 0.1 m in 200 m of water.

Source: Irvine, Cable Structures (1981), chapter 2, in the form of Jonkman, NREL/TP-500-41958
(2007), equations 2-35 (suspended) and 2-37 (part on a frictionless seabed).
"""

from __future__ import annotations

import math

from scipy.optimize import root

STIFFNESS, MASS, DIAMETER, DENSITY, GRAVITY = 1e9, 150.0, 0.1, 1025.0, 9.80665
WEIGHT = (MASS - DENSITY * math.pi * DIAMETER**2 / 4) * GRAVITY
RISE = 200.0


def suspended(span: float, length: float) -> tuple[float, float]:
    """Horizontal and vertical pull [N] at the upper end, no part on the seabed."""

    def residual(pull):
        h, v = pull
        low = v - WEIGHT * length
        x = h / WEIGHT * (math.asinh(v / h) - math.asinh(low / h)) + h * length / STIFFNESS
        z = h / WEIGHT * (math.hypot(1, v / h) - math.hypot(1, low / h))
        z += (v * length - WEIGHT * length**2 / 2) / STIFFNESS
        return x - span, z - RISE

    h, v = root(residual, (WEIGHT * length / 2, WEIGHT * length), tol=1e-13).x
    return h, v


def touching(span: float, length: float) -> tuple[float, float]:
    """Horizontal and vertical pull [N] at the upper end, the lower part on the seabed."""

    def residual(pull):
        h, v = pull
        x = length - v / WEIGHT + h / WEIGHT * math.asinh(v / h) + h * length / STIFFNESS
        z = h / WEIGHT * (math.hypot(1, v / h) - 1) + v * v / (2 * STIFFNESS * WEIGHT)
        return x - span, z - RISE

    h, v = root(residual, (WEIGHT * length / 2, 2 * WEIGHT * RISE), tol=1e-13).x
    return h, v
