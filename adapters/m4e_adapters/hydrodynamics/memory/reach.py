"""Which frequencies a radiation memory is fitted to, and which its errors are told of.

Where panels are coarse for the waves, or data of others scatter, they break the causality that ties
damping to added mass: such data help a fit only as long as it can follow them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory import soundness

TAIL = 0.05  # of the largest B
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

    def smooth(self, data: Coefficients, motions: tuple[int, ...]) -> Reach:
        """Without high frequencies at which the data of one of these motions scatter."""
        own, end = data.retardation, math.inf
        for k in motions:
            below = data.omega <= self.fitted[k]
            end = min(end, soundness.smooth_to(data.omega[below], own[below, k, k]))
        resolved = np.minimum(self.resolved, np.maximum(end, COARSEST * self.limits))
        return replace(self, resolved=resolved).shorter()


def _tail(data: Coefficients, motion: int, limit: float) -> float:
    """Where [rad/s] a motion's B falls to TAIL of its largest below `limit`."""
    own = data.radiation_damping[:, motion, motion]
    below = np.where(data.omega <= limit, own, -np.inf)
    peak = int(np.argmax(below))
    small = np.flatnonzero(own[peak:] <= TAIL * below[peak])
    return float(data.omega[peak + small[0]] if len(small) else data.omega[-1])
