"""The water at places, recorded: Airy waves and a steady current.

The equations are those of `kinematics`, with one difference: all components of a system are
multiplied by its ramp, accelerations and pressures too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.seas.water.current import NO_CURRENT, RecordedCurrent
from m4e_adapters.hydrodynamics.seas.water.kinematics import Stretching
from m4e_fmi.program import Scalar, cos, exp, maximum, minimum, sin


@dataclass(frozen=True)
class RecordedWaves:
    """Components of a system as scalars, k of them.

    `omega` [rad/s], wavenumbers `number` [rad/m], `amplitude` [m], and `phase` [rad] at x = y = 0,
    t = 0. They travel to `direction` [rad] + `offsets` (k,) [rad]. All are multiplied by `ramp`.
    """

    omega: Sequence[Number]
    number: Sequence[Number]
    amplitude: Sequence[Number]
    phase: Sequence[Number]
    direction: Number
    offsets: np.ndarray = field(repr=False)
    ramp: Number

    def phases_at(
        self, k: int, places: Sequence[tuple[Number, Number]]
    ) -> Iterator[tuple[Number, Number]]:
        """Cosine and sine of the phase that component `k` has on its way to `places` (x, y) [m]."""
        if places:
            along, across = self.along(k)
            for x, y in places:
                way = self.number[k] * (x * along + y * across)
                yield cos(way), sin(way)

    def along(self, k: int) -> tuple[Number, Number]:
        """Cosine and sine of the direction of component `k`."""
        offset = float(self.offsets[k])
        c, s = cos(self.direction), sin(self.direction)
        cosine, sine = math.cos(offset), math.sin(offset)
        return c * cosine - s * sine, s * cosine + c * sine


Number = Scalar | float
Triple = tuple[Number, Number, Number]
Clock = list[tuple[Number, Number]]
"""Cosine and sine of ω t + φ of each component; for a point, of θ = ω t + φ − k · place."""


@dataclass(frozen=True)
class Flow:
    """The water at a point: `elevation` [m], vectors (3,) [m/s, m/s2], pressure [Pa]."""

    elevation: Number
    velocity: Triple
    acceleration: Triple
    pressure: Number


@dataclass(frozen=True)
class RecordedFlow:
    """`waves` and a `current` in `water` at a `time` [s], profiles up to the surface by
    `stretching`.
    """

    water: Water
    time: Scalar
    waves: Sequence[RecordedWaves] = field(repr=False)
    current: RecordedCurrent = NO_CURRENT
    stretching: Stretching = "wheeler"

    @cached_property
    def _clocks(self) -> list[Clock]:
        return [_clock(self.time, own) for own in self.waves]

    def elevation(self, x: Number, y: Number) -> Number:
        """Of the surface at (x, y) [m]."""
        return self._elevation(self._moved(x, y))

    def elevation_at_origin(self) -> Number:
        """At x = y = 0 [m], in the order of the hydrodynamics: both give the same bits."""
        return self._elevation(self._clocks)

    def at(self, place: Triple) -> Flow:
        """The water at `place` (x, y, z) [m]."""
        x, y, z = place
        here = self._moved(x, y)
        elevation = self._elevation(here)
        level, above = self._levels(z, elevation)
        velocity: list[Number] = [*self.current.velocity(z), 0.0]
        acceleration: list[Number] = [0.0] * 3
        pressure: Number = 0.0
        for own, moved in zip(self.waves, here, strict=True):
            parts = _sums(self.water, own, moved, level, above)
            velocity = [a + own.ramp * b for a, b in zip(velocity, parts[0:3], strict=True)]
            acceleration = [a + own.ramp * b for a, b in zip(acceleration, parts[3:6], strict=True)]
            pressure = pressure + own.ramp * parts[6]
        weight = self.water.density * self.water.gravity
        u, v, w = velocity
        a, b, c = acceleration
        return Flow(elevation, (u, v, w), (a, b, c), weight * pressure)

    def linear_velocity(self, place: Triple) -> Triple:
        """Of the waves [m/s] at `place` (x, y, z) [m], z ≤ 0, by linear theory."""
        x, y, z = place
        velocity: list[Number] = [0.0] * 3
        for own, moved in zip(self.waves, self._moved(x, y), strict=True):
            parts = _sums(self.water, own, moved, z, 0.0)[:3]
            velocity = [a + own.ramp * b for a, b in zip(velocity, parts, strict=True)]
        u, v, w = velocity
        return u, v, w

    def _elevation(self, clocks: Sequence[Clock]) -> Number:
        elevation: Number = 0.0
        for own, clock in zip(self.waves, clocks, strict=True):
            elevation = elevation + own.ramp * _height(own, clock)
        return elevation

    def _moved(self, x: Number, y: Number) -> list[Clock]:
        pairs = zip(self.waves, self._clocks, strict=True)
        return [_moved(own, clock, x, y) for own, clock in pairs]

    def _levels(self, z: Number, elevation: Number) -> tuple[Number, Number]:
        """Level [m] ≤ 0 at which profiles count, and how far their tangents reach above it."""
        depth = self.water.depth
        if self.stretching == "wheeler":
            level = z - elevation
            if math.isfinite(depth):
                level = level * (depth / (depth + elevation))
            above: Number = 0.0
            level = minimum(level, 0.0)
        else:
            wet = minimum(z, maximum(elevation, 0.0))
            level = minimum(wet, 0.0)
            above = wet - level
        return (maximum(level, -depth) if math.isfinite(depth) else level), above


def _clock(time: Scalar, waves: RecordedWaves) -> Clock:
    angles = [w * time + p for w, p in zip(waves.omega, waves.phase, strict=True)]
    return [(cos(angle), sin(angle)) for angle in angles]


def _moved(waves: RecordedWaves, clock: Clock, x: Number, y: Number) -> Clock:
    moved: Clock = []
    for k, (cosine, sine) in enumerate(clock):
        along, across = waves.along(k)
        way = waves.number[k] * (x * along + y * across)
        c, s = cos(way), sin(way)
        moved.append((cosine * c + sine * s, sine * c - cosine * s))
    return moved


def _height(waves: RecordedWaves, clock: Clock) -> Number:
    total: Number = 0.0
    for amplitude, (cosine, _) in zip(waves.amplitude, clock, strict=True):
        total = total + amplitude * cosine
    return total


def _sums(
    water: Water, waves: RecordedWaves, clock: Clock, level: Number, above: Number
) -> list[Number]:
    """Velocity (3), acceleration (3) and pressure over ρ g of a system, without its ramp."""
    total: list[Number] = [0.0] * 7
    for k, (cosine, sine) in enumerate(clock):
        number, rate = waves.number[k], waves.omega[k] * waves.amplitude[k]
        up, down, over_sinh, over_cosh = _profile(water, number, level)
        along, upwards = (up + down) * over_sinh, (up - down) * over_sinh
        rise = number * above
        along, upwards = along + rise * upwards, upwards + rise * along
        c, s = waves.along(k)
        horizontal, faster = rate * along, waves.omega[k] * rate
        terms = (
            horizontal * c * cosine,
            horizontal * s * cosine,
            -(rate * upwards) * sine,
            -(faster * along) * c * sine,
            -(faster * along) * s * sine,
            -(faster * upwards) * cosine,
            waves.amplitude[k] * (up + down) * over_cosh * cosine,
        )
        total = [a + b for a, b in zip(total, terms, strict=True)]
    return total


def _profile(water: Water, number: Number, level: Number) -> tuple[Number, Number, Number, Number]:
    """e^{kz}, e^{−k(z + 2h)}, and what makes profiles of their sums, as in `kinematics`."""
    up = exp(number * level)
    if math.isinf(water.depth):
        return up, 0.0, 1.0, 1.0
    bed = exp(-2.0 * water.depth * number)
    down = exp(-number * (level + 2.0 * water.depth))  # bed/up is 0/0 where short waves end
    return up, down, 1.0 / (1.0 - bed), 1.0 / (1.0 + bed)
