"""Frequencies up to which a radiation memory is fitted, and to which its errors refer.

Where panels are too coarse for the waves, they break the causality that ties damping to added mass:
such data help a fit only as long as it can follow them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory import soundness
from m4e_fmi.errors import InputError, Problem

TAIL = 0.05  # of the largest B
MOST_FREQUENCIES = 400  # that the key `count` accepts
COARSEST = 0.5  # of a motion's memory limit that counts as resolved, however coarse the panels


@dataclass(frozen=True)
class Reach:
    """Frequencies [rad/s] of each motion, (n,).

    Attributes
    ----------
    limits : up to which the data matter.
    resolved : up to which, of these, the panels resolve the waves.
    fitted : up to which the data are fitted.
    """

    limits: np.ndarray
    resolved: np.ndarray
    fitted: np.ndarray

    @classmethod
    def of(cls, data: Coefficients) -> Reach:
        """All data that matter, and the tails beyond that the panels resolve."""
        limits = data.memory_limits
        resolved = np.maximum(data.resolved_limits, COARSEST * limits)
        ends = [_tail(data, k, limit) for k, limit in enumerate(limits.tolist())]
        fitted = np.maximum(limits, np.minimum(ends, resolved))
        return cls(limits, np.minimum(limits, resolved), fitted)

    def shorter(self) -> Reach:
        """Without the data that the panels do not resolve."""
        fitted = np.where(self.resolved < self.limits, self.resolved, self.fitted)
        return replace(self, fitted=fitted)


def check_counts(data: Coefficients, reach: Reach) -> None:
    """InputError that names each body with too few frequencies for a memory."""
    problems = []
    for k, name in enumerate(data.bodies):
        own = k * data.per_body
        limit, resolved = float(reach.limits[own]), float(reach.resolved[own])
        matter, used = (int((data.omega <= end).sum()) for end in (limit, resolved))
        if used >= soundness.FEWEST:
            continue
        text = (
            f"radiation of body {name!r}: {matter} of the {len(data.omega)} frequencies are up to "
            f"{limit:.4g} rad/s, where it matters"
        )
        panels = matter >= soundness.FEWEST
        if panels:
            text += f", and {used} up to {resolved:.4g} rad/s, where the panels resolve the waves"
        text += f"; a radiation memory needs {soundness.FEWEST} or more"
        remedy = _more_frequencies(data.omega, resolved)
        remedy = f"use more panels for it, or {remedy}" if panels else remedy
        problems.append(Problem(text, remedy, keys=("frequencies", "count")))
    InputError.raise_for(problems)


def _more_frequencies(omega: np.ndarray, end: float) -> str:
    """The words for FEWEST frequencies up to `end` [rad/s] in a table as `omega`.

    That begins at its spacing, unless with another minimum, and ends with wider steps.
    """
    steps = np.diff(omega)
    last = float(omega[int((np.cumsum(steps > 1.01 * steps[:1].sum()) == 0).sum())])
    count = max(soundness.FEWEST, math.ceil(soundness.FEWEST * last / end - 1e-9))
    if count > MOST_FREQUENCIES:
        return (
            "put bodies of so different sizes into hydrodynamics components of their own (each "
            "then feels no waves radiated by the others)"
        )
    return f"use a frequencies.count of {count} or more, without a frequencies.minimum"


def _tail(data: Coefficients, motion: int, limit: float) -> float:
    """Where [rad/s] a motion's B falls to TAIL of its largest below `limit`."""
    own = data.radiation_damping[:, motion, motion]
    below = np.where(data.omega <= limit, own, -np.inf)
    peak = int(np.argmax(below))
    small = np.flatnonzero(own[peak:] <= TAIL * below[peak])
    return float(data.omega[peak + small[0]] if len(small) else data.omega[-1])
