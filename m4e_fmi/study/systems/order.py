"""The order in which runs are made: the longest first, so that no process waits for the last."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from m4e_fmi.study.given.grid import Grid


class LongestFirst:
    """Numbers of runs, each once: next is the one that probably takes longest.

    The time of a run is estimated from those that are done: their mean, and for each dimension of
    the grid by how much the runs at its point are above it. Runs alike come as they are given.
    """

    def __init__(self, runs: Sequence[int], grid: Grid) -> None:
        self._runs = list(runs)
        self._number = {run: k for k, run in enumerate(self._runs)}
        self._places = np.array([grid.place(run) for run in runs], dtype=int).reshape(
            len(runs), len(grid.shape)
        )
        self._waits = np.ones(len(runs), dtype=bool)
        self._sums = [np.zeros(size) for size in grid.shape]  # of times [s], by point
        self._counts = [np.zeros(size) for size in grid.shape]
        self._sum, self._count = 0.0, 0

    def __iter__(self) -> Iterator[int]:
        while self._waits.any():
            expected = np.where(self._waits, self._above_mean(), -np.inf)
            k = int(expected.argmax())
            self._waits[k] = False
            yield self._runs[k]

    def learn(self, run: int, wall_time: float) -> None:
        """A run took a `wall_time` [s]."""
        self._sum, self._count = self._sum + wall_time, self._count + 1
        place = self._places[self._number[run]]
        for sums, counts, k in zip(self._sums, self._counts, place, strict=True):
            sums[k] += wall_time
            counts[k] += 1

    def _above_mean(self) -> np.ndarray:
        """Estimated times of all runs less the mean of those done, (n_runs,) [s]."""
        mean, found = self._sum / max(self._count, 1), np.zeros(len(self._runs))
        for axis, (sums, counts) in enumerate(zip(self._sums, self._counts, strict=True)):
            above = np.where(counts > 0, sums / np.maximum(counts, 1) - mean, 0.0)
            found += above[self._places[:, axis]]
        return found
