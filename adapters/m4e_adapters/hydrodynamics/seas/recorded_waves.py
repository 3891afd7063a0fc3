"""Components of a system of waves while a program is recorded."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_fmi.program import Scalar, cos, sin

Number = Scalar | float


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
