"""The water's motion at places that move, for code inside FMUs.

Travels inside FMUs: imports numpy and its neighbours that travel as well. World frame, SI units.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .kinematics import Components, Stretching, flow

MOVED: tuple[str, ...] = ("omega", "amplitude", "phase", "direction")  # of each component


class MovingWater:
    """Waves that grow with their ramps, and a current.

    Parameters
    ----------
    code
        The components of the waves, their ramps and the current, as functions of the parameters:
        a program that `system_seas.water_program` makes, in its plain-Python form.
    counts
        How many components each system of waves has.
    current
        True if there is a current.
    depth
        Of the water [m], None if it is deep.
    gravity
        [m/s2].
    stretching
        How velocities are continued up to the surface.
    """

    def __init__(
        self,
        code: Any,
        *,
        counts: Sequence[int],
        current: bool,
        depth: float | None,
        gravity: float,
        stretching: Stretching,
    ) -> None:
        self._code, self._counts, self._flows = code, list(counts), current
        self._depth = math.inf if depth is None else depth
        self._gravity = gravity
        self._stretching: Stretching = stretching

    def set(self, parameters: Sequence[float]) -> None:
        """Take values of all parameters, in the order of the program."""
        self._parameters = list(parameters)
        self._fixed = self._code.constants(self._parameters)
        found = np.array(self._code.calculated(self._parameters, self._fixed), dtype=float)
        omega, amplitude, phase, direction = found.reshape(len(MOVED), -1)
        self._waves = Components(
            omega, amplitude, phase, direction, depth=self._depth, gravity=self._gravity
        )

    def at(self, t: float, places: np.ndarray) -> np.ndarray:
        """Velocity and acceleration (2, n, 3) [m/s, m/s2] at `t` [s] and `places` (n, 3) [m]."""
        result = self.steady(places)
        if self._counts:
            ramps = self._outputs(t, 0.0)[:-2]
            waves = self._waves
            if any(ramp != 1.0 for ramp in ramps):
                waves = waves.scaled(np.repeat(ramps, self._counts))
            found = flow(waves, t, places, stretching=self._stretching)
            result += np.stack([found.velocity, found.acceleration])
        return result

    def steady(self, places: np.ndarray) -> np.ndarray:
        """As `at` [m/s, m/s2], (2, n, 3), without waves; `places` (n, 3) [m]."""
        result = np.zeros((2, len(places), 3))
        if self._flows:
            result[0, :, :2] = [self._outputs(0.0, z)[-2:] for z in places[:, 2].tolist()]
        return result

    def _outputs(self, t: float, z: float) -> list[float]:
        """Ramps at `t` [s], and the current (x, y) [m/s] at the height `z` [m]."""
        return self._code.outputs(t, [], [z], self._parameters, self._fixed)
