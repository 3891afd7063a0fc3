"""Jumps of outputs, told from smooth motions by extrapolation from the last points of a run.

An algorithm's own estimate compares two ways of making a step. Both may take the same jump for a
steep but smooth motion, agree, and be wrong. So outputs are extrapolated here, by the parabola
through their last three points. Of a smooth motion that is resolved by the steps, the parabola
misses a small part; of a jump, all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

POINTS = 3
JUMPED = 0.5
"""Share of an output's movement in a step from which on missing it is a jump."""


@dataclass(frozen=True)
class JumpDetectionSnapshot:
    """The last POINTS points, of which some are `known`: `times` [ns], `values` (POINTS, count)."""

    times: np.ndarray
    values: np.ndarray
    known: int


class JumpDetection:
    """Follows `count` outputs from the point (`time` [ns], `values`) on."""

    def __init__(self, time: int, values: np.ndarray) -> None:
        self._times = np.zeros(POINTS)
        self._values = np.zeros((POINTS, len(values)))
        self._known = 0
        self.note(time, values)

    def snapshot(self) -> JumpDetectionSnapshot:
        """The points as they are now."""
        return JumpDetectionSnapshot(self._times.copy(), self._values.copy(), self._known)

    def restore(self, snapshot: JumpDetectionSnapshot) -> None:
        """Continue as from where the snapshot was taken."""
        self._times, self._values = snapshot.times.copy(), snapshot.values.copy()
        self._known = snapshot.known

    def note(self, time: int, values: np.ndarray) -> None:
        """Add the point at `time` [ns], where the outputs are `values` (count,), in their units."""
        self._times[1:], self._values[1:] = self._times[:-1].copy(), self._values[:-1].copy()
        self._times[0], self._values[0] = time, values
        self._known = min(self._known + 1, POINTS)

    def forget(self) -> None:
        """Drop the points before the last one, at which the outputs have jumped."""
        self._known = 1

    def missed(self, time: int, values: np.ndarray) -> np.ndarray:
        """Misses (count,) of outputs that are `values` (count,) at `time` [ns] and have jumped.

        They are in the outputs' units; zero for outputs that move smoothly, and as long as too few
        points are known.
        """
        if self._known < POINTS:
            return np.zeros_like(values)
        ahead = (time - self._times)[:, None]
        last, earlier, _ = steps = self._values
        by_time = np.diff(steps, axis=0) / np.diff(self._times)[:, None]
        bend = (by_time[0] - by_time[1]) / (self._times[0] - self._times[2])
        off = np.abs(values - last - ahead[0] * by_time[0] - ahead[0] * ahead[1] * bend)
        movement = np.maximum(np.abs(values - last), np.abs(last - earlier))
        return np.where(off > JUMPED * movement, off, 0.0)
