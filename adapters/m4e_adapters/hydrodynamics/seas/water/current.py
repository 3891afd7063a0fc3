"""The velocity of a steady current at a height, in numbers and recorded.

Its speed is uniform, U ((z + h)/h)^p over the depth h, or linear between rows of a table. Above
z = 0 it is that of z = 0, below the bed that of the bed. Waves are not changed by it: their
dispersion and heights are those of water at rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from m4e_adapters.hydrodynamics.config.waves import Current
from m4e_fmi.program import Recorder, Scalar, Variable, cos, maximum, minimum, sin

Number = Scalar | float
ABOVE_BED = 1e-9  # of the depth: the slope of a power law is finite there


def current_velocity(current: Current, z: ArrayLike, *, depth: float) -> np.ndarray:
    """Velocity (..., 3) [m/s], (x, y, z), at heights `z` (...) or scalar [m].

    The water has the `depth` [m].
    """
    level = np.minimum(np.asarray(z, dtype=float), 0.0)
    match current.profile:
        case tuple() as rows:
            heights, speeds = np.array(rows).T
            speed = np.interp(level, heights, speeds)
        case float() as exponent:
            share = np.maximum((level + depth) / depth, ABOVE_BED)
            speed = (current.speed or 0.0) * share**exponent
        case _:
            speed = np.full_like(level, current.speed or 0.0)
    beta = math.radians(current.direction)
    return speed[..., None] * np.array([math.cos(beta), math.sin(beta), 0.0])


@dataclass(frozen=True)
class RecordedCurrent:
    """A current whose speed and direction are parameters; none if there is no `speed_at`."""

    speed_at: Callable[[Number], Number] | None = field(default=None, repr=False)
    cosine: Number = 1.0
    sine: Number = 0.0

    def velocity(self, z: Number) -> tuple[Number, Number]:
        """Components (x, y) [m/s] at the height `z` [m]."""
        if self.speed_at is None:
            return 0.0, 0.0
        speed = self.speed_at(minimum(z, 0.0))
        return speed * self.cosine, speed * self.sine


NO_CURRENT = RecordedCurrent()


def record_current(
    recorder: Recorder, current: Current | None, *, depth: float, in_space: bool
) -> RecordedCurrent:
    """Record the parameters `current.speed` (of a table `current.speed[k]`), `current.direction`.

    They are tunable. In the plane the direction is that of the configuration. `depth` in m.
    """
    if current is None:
        return NO_CURRENT
    speed_at = _recorded_profile(recorder, current, depth)
    angle = math.radians(current.direction)
    if not in_space:
        return RecordedCurrent(speed_at, math.cos(angle), 0.0)
    text = "direction that the current flows to, from +X towards +Y"
    variable = Variable(
        "current.direction", "rad", text, start=angle, tunable=True, display_unit="deg"
    )
    direction = recorder.parameter(variable)
    return RecordedCurrent(speed_at, cos(direction), sin(direction))


def _recorded_profile(
    recorder: Recorder, current: Current, depth: float
) -> Callable[[Number], Number]:
    if isinstance(current.profile, tuple):
        rows = [
            (z, _speed(recorder, f"current.speed[{k}]", f"z = {z:g} m", start))
            for k, (z, start) in enumerate(current.profile, start=1)
        ]
        return lambda level: _interpolated(rows, level)
    surface = _speed(recorder, "current.speed", "the still-water level", current.speed or 0.0)
    exponent = current.profile
    if isinstance(exponent, float):
        power = exponent
        return lambda level: surface * maximum((level + depth) / depth, ABOVE_BED) ** power
    return lambda _: surface


def _speed(recorder: Recorder, name: str, place: str, start: float) -> Scalar:
    text = f"speed of the current at {place}"
    return recorder.parameter(Variable(name, "m/s", text, start=start, tunable=True))


def _interpolated(rows: list[tuple[float, Scalar]], level: Number) -> Number:
    """Linear between rows, constant beyond: each interval adds what is gained in it."""
    speed: Number = rows[0][1]
    for (low, slow), (high, fast) in pairwise(rows):
        share = minimum(maximum((level - low) / (high - low), 0.0), 1.0)
        speed = speed + (fast - slow) * share
    return speed
