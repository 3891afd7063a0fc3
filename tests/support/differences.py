"""Derivatives by differences, to compare exact ones with."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

STEP = 1e-4
"""Relative, of differences of fourth order: off by STEP⁴ and by 1e-16/STEP, times the curvature."""


def difference(function: Callable[[float], np.ndarray], at: float) -> np.ndarray:
    """Derivative of `function` by central differences of fourth order."""
    h = STEP * at
    near = (function(at + h) - function(at - h)) / (2 * h)
    far = (function(at + 2 * h) - function(at - 2 * h)) / (4 * h)
    return (4 * near - far) / 3
