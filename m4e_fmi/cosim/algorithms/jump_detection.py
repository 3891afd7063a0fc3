"""What the last points of a run foretell of the next, so that a jump is told from a smooth course.

An algorithm's own estimate compares two ways of making a step. Both may take the same jump for a
steep but smooth course, agree, and be wrong. So outputs are extrapolated here, by the parabola
through their last three points. Of a smooth course that is resolved by the steps, the parabola
misses a small part of its movement; of a jump, all of it.
"""

from __future__ import annotations

import numpy as np

POINTS = 3
NO_SMOOTH_COURSE = 0.5
"""Share of an output's movement in a step from which on missing it tells of a jump."""


class Foresight:
    """Follows `count` outputs from the point (`time` [ns], `values`) on."""

    SNAPSHOT = ("_times", "_values", "_known")

    def __init__(self, time: int, values: np.ndarray) -> None:
        self._times = np.zeros(POINTS)
        self._values = np.zeros((POINTS, len(values)))
        self._known = 0
        self.note(time, values)

    def note(self, time: int, values: np.ndarray) -> None:
        """The run has come to `time` [ns], where the outputs are `values`."""
        self._times[1:], self._values[1:] = self._times[:-1].copy(), self._values[:-1].copy()
        self._times[0], self._values[0] = time, values
        self._known = min(self._known + 1, POINTS)

    def forget(self) -> None:
        """The outputs have jumped at the last point: those before it foretell nothing."""
        self._known = 1

    def missed(self, time: int, values: np.ndarray) -> np.ndarray:
        """By how much outputs that are `values` at `time` [ns] are off, where they have jumped.

        Zero for outputs that follow a smooth course, and as long as too few points are known.
        """
        if self._known < POINTS:
            return np.zeros_like(values)
        ahead = (time - self._times)[:, None]
        last, earlier, _ = steps = self._values
        by_time = np.diff(steps, axis=0) / np.diff(self._times)[:, None]
        bend = (by_time[0] - by_time[1]) / (self._times[0] - self._times[2])
        off = np.abs(values - last - ahead[0] * by_time[0] - ahead[0] * ahead[1] * bend)
        movement = np.maximum(np.abs(values - last), np.abs(last - earlier))
        return np.where(off > NO_SMOOTH_COURSE * movement, off, 0.0)
