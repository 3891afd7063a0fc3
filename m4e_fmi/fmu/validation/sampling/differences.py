"""Derivatives from values, with an error estimate from the values themselves (Richardson).

Source: L. F. Richardson, "The deferred approach to the limit", Phil. Trans. R. Soc. A 226 (1927).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

SAMPLES = 9
"""Equidistant samples that `at_centre` needs."""
CENTRE = SAMPLES // 2
SAFETY = 10.0
"""Between an error estimate and what is called a contradiction."""
_EPS = np.finfo(float).eps


class Estimate(NamedTuple):
    """A derivative and a bound on its error, for each column."""

    value: np.ndarray
    error: np.ndarray


def at_centre(samples: np.ndarray, spacing: float) -> Estimate:
    """Time derivative at the middle of `samples` (SAMPLES, n), in the variables' units.

    Rows are `spacing` [s] apart.
    """
    differences = [
        (samples[CENTRE + k] - samples[CENTRE - k]) / (2 * k * spacing) for k in (1, 2, 4)
    ]
    return _extrapolated(*differences, rounding=_rounding(samples, spacing))


def _extrapolated(
    fine: np.ndarray, middle: np.ndarray, coarse: np.ndarray, rounding: np.ndarray
) -> Estimate:
    """From central differences with steps 1, 2 and 4: the error terms are h², h⁴, …"""
    once, before = (4 * fine - middle) / 3, (4 * middle - coarse) / 3
    return Estimate((16 * once - before) / 15, np.abs(once - before) + rounding)


def central(above: np.ndarray, below: np.ndarray, steps: np.ndarray) -> Estimate:
    """∂/∂v from values at v ± each of three steps, in ratio 1 : 2 : 4, one row for each.

    `above` and `below` (3, n), in the units of the values; `steps` (3,), in v's unit.

    The error covers what the three differ by, too, and rounding in the largest of all values: small
    ones may be what is left of large ones.
    """
    differences = (above - below) / (2 * steps[:, None])
    rounding = np.max(_rounding(np.vstack([above, below]), float(steps[0])))
    found = _extrapolated(*differences, rounding=np.full(len(differences[0]), rounding))
    return Estimate(found.value, found.error + np.ptp(differences, axis=0))


def _rounding(values: np.ndarray, spacing: float) -> np.ndarray:
    return SAFETY * _EPS * np.max(np.abs(values), axis=0) / spacing
