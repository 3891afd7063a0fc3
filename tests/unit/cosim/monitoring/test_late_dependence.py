"""Outputs read a second time: what is rounding, and what follows an input."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from m4e_fmi.cosim.monitoring.late_dependence import _Part


def test_what_is_zero_but_for_rounding_has_not_changed() -> None:
    """Nodes of a line in the X-Z plane of space: y is 1e-13 m beside x = 260 m."""
    units = np.array([0, 0, 1, 0])  # m, m, N, m
    anything: Any = SimpleNamespace()
    part = _Part(anything, ("x", "y", "f", "z"), np.arange(4), np.zeros(4), anything, units)
    one = np.array([260.0, 1.0e-13, 1.0e-13, 1.0e-6])
    other = np.array([260.0 + 1e-8, 1.7e-13, 1.7e-13, 1.001e-6])
    assert part.changed(one, other).tolist() == [False, False, True, True]
