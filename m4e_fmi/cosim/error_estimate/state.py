"""All that step doubling knows at a point of the run: errors so far, kinks, the open stretch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from m4e_fmi.cosim.error_estimate.coverage import Coverage
from m4e_fmi.cosim.error_estimate.kinks import halved_kinks
from m4e_fmi.cosim.error_estimate.repeated_steps import Recorded
from m4e_fmi.cosim.error_estimate.report import over
from m4e_fmi.cosim.error_estimate.roughness import RoughnessSnapshot
from m4e_fmi.cosim.error_estimate.stretch import Followed, Stretch
from m4e_fmi.cosim.error_estimate.windows import Told, throughout
from m4e_fmi.cosim.exchange.network import NetworkSnapshot
from m4e_fmi.files.encoding import LIVE

LITTLE = 1 / 3
"""Kinks do not matter where their error over that of smooth steps is so small."""


@dataclass
class StepDoublingState:
    """Errors of the monitored outputs (n,), in their units, and what the estimate does next.

    `spans_of` gives the range of all outputs of its unit for the range of each output. `told` are
    the errors of windows, `kinked` (n,) the largest differences of the followed run, and
    `kinked_since` (n,) those since kinks may be of another kind; `met` counts the events of kinks
    since then in windows, or where the run was followed. They are many and left to windows if
    `crowded`. `bounds` (2, n) are the smallest and largest values, `leaps` (n,) the
    largest changes within one step. `watched` and `rough`
    (n_outputs,), in the outputs' units, are the largest fourth differences in windows, and where
    the run was followed. `lengths` are those of repeated steps, over the run's, that can be made;
    `falls` is the order of smooth errors as measured, 0 at least.

    `steps` counts those of the run, `begins` is the first of the next window, `size` [ns] that of
    the last step. `failure` says why nothing is known, if so. Arrays are replaced, never changed.
    """

    spans_of: Callable[[np.ndarray], np.ndarray] = field(metadata=LIVE)
    lengths: tuple[float, ...]
    coverage: Coverage
    bounds: np.ndarray
    leaps: np.ndarray
    kinked: np.ndarray
    kinked_since: np.ndarray
    watched: np.ndarray
    rough: np.ndarray
    told: tuple[Told, ...] = ()
    met: int = 0
    crowded: bool = False
    followed: Followed | None = None
    falls: float | None = None
    steps: int = 0
    begins: int = 0
    size: int = 0
    failure: str = ""
    stretch: Stretch | None = None

    def copy(self) -> StepDoublingState:
        """The same, which stays as it is while this changes."""
        return replace(self, stretch=self.stretch.copy() if self.stretch else None)

    def ranges(self) -> np.ndarray:
        """Ranges (n,) of the known values, in the outputs' units."""
        return np.ptp(self.bounds, axis=0)

    def spans(self) -> np.ndarray:
        """Ranges (n,) of all outputs of each one's unit, in the outputs' units."""
        return self.spans_of(self.ranges())

    def add_window(self, told: Told, better: Recorded) -> None:
        """Add the errors of a window, and the range of values of the better run."""
        self.told = (*self.told, told)
        self.widen(better)
        self.coverage = self.coverage.twice(told.begin, told.begin + told.span)

    def add_kinks(self, largest: np.ndarray) -> None:
        """Account for the `largest` (n,) errors by kinks in a stretch, in the outputs' units."""
        self.kinked = np.maximum(self.kinked, largest)
        self.kinked_since = np.maximum(self.kinked_since, largest)

    def widen(self, run: Recorded) -> None:
        """Account for the values of `run` in the ranges and leaps."""
        self.leaps = np.maximum(self.leaps, run.leaps)
        (low, high), (least, most) = self.bounds, run.bounds
        self.bounds = np.array([np.minimum(low, least), np.maximum(high, most)])

    def of_known(self, share: float) -> np.ndarray:
        """A share of the largest known error over its range, as errors (n,) in the outputs' units.

        0 before the first window.
        """
        spans = self.spans()
        if not self.told:
            return 0.0 * spans
        largest = np.max([one.largest for one in self.told], axis=0) + self.kinked
        return share * float(over(largest, spans).max()) * spans

    def kinks_outweigh(self, now: int) -> bool:
        """True if errors of kinks up to `now` [ns] matter beside those of smooth steps, or grow."""
        if not self.told:
            return True
        spans = self.spans()
        smooth = throughout(self.told, self.coverage.start, now)
        if over(self.kinked_since, spans).max() > LITTLE * over(smooth, spans).max():
            return True
        return self.followed is not None and self.followed.told.doubles(spans)

    def errors(self, now: int, *, halved: bool) -> np.ndarray:
        """Largest errors (n,) up to `now` [ns], in the outputs' units; or those at half the step.

        They need one window at least.
        """
        told = [one.halved for one in self.told] if halved else self.told
        smooth = throughout(told, self.coverage.start, now)
        return smooth + (halved_kinks(self.kinked, self.spans()) if halved else self.kinked)


@dataclass(frozen=True)
class StepDoublingSnapshot:
    """Saved state of a `StepDoublingEstimator`."""

    state: StepDoublingState
    roughness: RoughnessSnapshot

    @property
    def points(self) -> tuple[NetworkSnapshot, ...]:
        """The points that the estimate returns to."""
        stretch, followed = self.state.stretch, self.state.followed
        found = (stretch and stretch.start, followed and followed.point)
        return tuple(point for point in found if point)
