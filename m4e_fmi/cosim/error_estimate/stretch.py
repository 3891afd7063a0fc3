"""Steps of a run that are made a second time together, and the saved state of the estimate."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from m4e_fmi.cosim.error_estimate.coverage import Coverage
from m4e_fmi.cosim.error_estimate.repeated_steps import SecondCourse
from m4e_fmi.cosim.error_estimate.roughness import RoughnessSnapshot
from m4e_fmi.cosim.error_estimate.windows import Told
from m4e_fmi.cosim.exchange.network import Change, NetworkSnapshot


@dataclass
class Stretch:
    """Steps since `start`, up to the `last` time [ns], and if it is `recorded`, source values.

    They are piece by piece; `runs` are sizes [ns] and numbers of steps that are like each other.
    `jumps` are the times to which a jump has led, of which some were `within` the step; `kinks`
    numbers of steps that are rough at once, `changes` what was set at some times, and `steps` their
    number so far. A `window` is made again in any case, up to the step `end` of the run.
    """

    start: NetworkSnapshot
    window: bool
    recorded: bool
    end: int
    values: list[np.ndarray]
    last: int
    runs: list[tuple[int, int]] = field(default_factory=list)
    jumps: list[int] = field(default_factory=list)
    kinks: list[np.ndarray] = field(default_factory=list)
    within: list[int] = field(default_factory=list)
    changes: dict[int, list[Change]] = field(default_factory=dict)
    steps: int = 0

    def copy(self) -> Stretch:
        """The same, which stays as it is while this goes on."""
        changes = {time: changes.copy() for time, changes in self.changes.items()}
        lists = {n: getattr(self, n).copy() for n in ("runs", "values", "jumps", "kinks", "within")}
        return replace(self, changes=changes, **lists)

    def go_on(self, steps: int, size: int) -> None:
        """With so many further steps of `size` [ns]."""
        if self.runs and self.runs[-1][0] == size:
            self.runs[-1] = size, self.runs[-1][1] + steps
        else:
            self.runs.append((size, steps))
        self.last += size * steps
        self.steps += steps

    @property
    def times(self) -> np.ndarray:
        """The times [ns] of all points, the first included."""
        sizes, counts = np.array(self.runs, dtype=np.int64).T
        passed = np.concatenate([np.zeros(1, dtype=np.int64), np.repeat(sizes, counts)]).cumsum()
        return self.last - passed[-1] + passed


@dataclass(frozen=True)
class Followed:
    """A course without the errors of kinks, at `point`, and what it has `told` of these.

    It goes beside the run `since` a time [ns], and tells from the first kink on.
    """

    point: NetworkSnapshot
    since: int
    told: Told


@dataclass(frozen=True)
class StepDoublingSnapshot:
    """All that a `StepDoublingEstimator` knows at a point of the run."""

    steps: int
    begins: int
    size: int
    told: tuple[Told, ...]
    bounds: np.ndarray
    kinked: np.ndarray
    kinked_since: np.ndarray
    met: int
    followed: Followed | None
    watched: np.ndarray
    rough: np.ndarray
    coverage: Coverage
    crowded: bool
    falls: float | None
    failure: str
    others: dict[float, SecondCourse]
    roughness: RoughnessSnapshot
    stretch: Stretch | None
