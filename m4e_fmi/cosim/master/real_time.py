"""Runs in real time: no communication point is passed before its wall time."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass

from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.errors import InputError

SLICE = 0.02
"""Seconds of a wait after which signals are heard."""
SLOW = 0.1
"""Seconds by which the end of a run may be late before it counts as too slow."""
NOT_IN_REAL_TIME = (
    "what is run in real time is not repeated, which would make others late; run without real "
    "time, from the start, for the error of the same values"
)


@dataclass(frozen=True)
class Lateness:
    """How late a run in real time has passed its communication points [s].

    `factor` is simulated over wall time; of `points`, so many were `late`: there was nothing left
    to wait for. `mean` is that of all points; `last` is the lateness of the last one.
    """

    factor: float
    points: int
    late: int
    largest: float
    mean: float
    last: float

    @property
    def is_slow(self) -> bool:
        """True if the run could not follow."""
        return self.last > SLOW

    def __str__(self) -> str:
        text = (
            f"{self.factor:g} × real time: {self.late} of {self.points} points late, lateness "
            f"{1e3 * self.largest:.3g} ms at most, {1e3 * self.mean:.3g} ms in the mean, "
            f"{1e3 * self.last:.3g} ms at the end"
        )
        slow = f"; too slow for it, the end was {self.last:.3g} s late"
        return text + (slow if self.is_slow else "")


class RealTime:
    """An observer that waits at each communication point until its time has come.

    That is counted from the first point on, so that nothing adds up. Where the run is late it does
    not wait, and may catch up. Signals end a wait.
    """

    def __init__(self, factor: float) -> None:
        if not (math.isfinite(factor) and factor > 0.0):
            message = f"real time factor {factor!r}: expected simulated seconds per second"
            raise InputError.single(message, "give a number above 0; 1 is real time")
        self._factor = factor
        self.since = -math.inf
        """The time [s] from which points have their wall times; all before are made again."""
        self._origin = self._start = math.nan
        self._points = self._late = 0
        self._largest = self._sum = self._last = 0.0

    def __call__(self, time: float, network: Network) -> None:
        """Wait for the wall time of the point at `time` [s]."""
        if time < self.since:
            return
        now = clock.perf_counter()
        if not self._points:
            self._origin, self._start = now, time
        due = self._origin + (time - self._start) / self._factor
        self._late += now > due
        while (rest := due - now) > 0.0:
            clock.sleep(min(rest, SLICE))
            network.pause()
            now = clock.perf_counter()
        self._points += 1
        self._last = now - due
        self._largest = max(self._largest, self._last)
        self._sum += self._last

    @property
    def lateness(self) -> Lateness:
        """The lateness of all points up to here."""
        mean = self._sum / max(1, self._points)
        return Lateness(self._factor, self._points, self._late, self._largest, mean, self._last)
