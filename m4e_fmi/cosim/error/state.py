"""All that an estimate of the coupling error knows at a point of the run."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field, replace

import numpy as np

from m4e_fmi.cosim.error.course import Course
from m4e_fmi.cosim.error.roughness import HISTORY
from m4e_fmi.cosim.network.network import Change, NetworkSnapshot

OF_A_JUMP = np.array([1.0, -3.0, 3.0, -1.0])
"""Fourth differences about a jump, over its size."""
ALIKE = 0.9
"""Share of squared fourth differences that are those of a jump; those of a bend are 0.83 at most,
wherever it is in its step."""


@dataclass
class Stretch:
    """Steps since `start`, up to the `last` time [ns], with values of the sources.

    These are arrays (n, n_sources), in the outputs' units; `runs` are sizes [ns] and numbers of
    equal steps. `jumps` are the times to which a jump has led that was not within a step; it has
    `switched` where one was. `kinks` are the indices of steps that are suddenly rough, `changes`
    the values set at some times, `leaping` (k,) the indices of steps within which values jump
    (more after `kinks_of`); `steps` is the number of steps so far, and `end` that of the run
    up to which the stretch goes. `start` stays None beside a second set of FMUs.
    """

    start: NetworkSnapshot | None
    end: int
    values: list[np.ndarray]
    last: int
    runs: list[tuple[int, int]] = field(default_factory=list)
    jumps: list[int] = field(default_factory=list)
    kinks: list[np.ndarray] = field(default_factory=list)
    changes: dict[int, list[Change]] = field(default_factory=dict)
    leaping: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    steps: int = 0
    switched: bool = False

    def __deepcopy__(self, _: object) -> Stretch:
        """The same, which stays as it is while this goes on."""
        changes = {time: changes.copy() for time, changes in self.changes.items()}
        lists = {n: getattr(self, n).copy() for n in ("runs", "values", "jumps", "kinks")}
        return replace(self, changes=changes, **lists)

    def extend(self, steps: int, size: int) -> None:
        """Add so many steps of `size` [ns]."""
        if self.runs and self.runs[-1][0] == size:
            self.runs[-1] = size, self.runs[-1][1] + steps
        else:
            self.runs.append((size, steps))
        self.last += size * steps
        self.steps += steps

    def kinks_of(
        self, values: np.ndarray, noise: np.ndarray | float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Largest fourth differences (n_sources,) at kinks, in the sources' units; largest jumps.

        `values` (n, n_sources) are its own, in the same units; jumps (n_sources,) are kinks, too.
        What is below the `noise` (n_sources,), in these units, is 0. Steps with jumps are noted as
        `leaping`.
        """
        count = len(values)
        found = np.zeros((count + len(OF_A_JUMP), values.shape[1]))
        found[HISTORY:count] = np.diff(values, HISTORY, axis=0)[: max(0, count - HISTORY)]
        at = np.concatenate([np.zeros(0, dtype=np.intp), *self.kinks]) + 1
        at = np.minimum(np.maximum(at, HISTORY), count)
        rows = found[at[:, None] + np.arange(len(OF_A_JUMP))]
        whole = OF_A_JUMP @ OF_A_JUMP
        sizes = np.abs(np.tensordot(OF_A_JUMP, rows, axes=(0, 1))) / whole
        is_jump = (whole * sizes**2 > ALIKE * (rows**2).sum(axis=1)) & (sizes > noise)
        self.leaping = np.append(self.leaping, at[is_jump.any(axis=1)] - 1)
        kinks = np.abs(rows).max(axis=(0, 1), initial=0.0)
        jumps = np.where(is_jump, sizes, 0.0).max(axis=0, initial=0.0)
        return np.where(kinks > noise, kinks, 0.0), jumps

    @property
    def times(self) -> np.ndarray:
        """Times (steps + 1,) [ns] of all points, the first included."""
        sizes, counts = np.array(self.runs, dtype=np.int64).T
        passed = np.concatenate([np.zeros(1, dtype=np.int64), np.repeat(sizes, counts)]).cumsum()
        return self.last - passed[-1] + passed


@dataclass
class EstimateState:
    """All that an estimate knows at a point of the run.

    `lengths` are those of repeated steps over the run's that can be made. `bounds` (2, n) are the
    smallest and largest values and `leaps` (n,) the largest changes within one step where steps
    were repeated, in the sources' units; `watched` (n_outputs,) the largest fourth differences of
    all outputs there, in theirs. `kinks` (n,) are the largest fourth differences in steps that are
    suddenly rough, `jumps` (n,) the largest jumps there, in the sources' units; the run has
    `switched` if a value jumped within a step otherwise. `ended` are the courses that have ended;
    `course` is the one that continues, and `point` the state of its trajectory.

    The run has made `steps`, of which the last had a `size` [ns]; the present window ends after
    `until` of them, the next begins at `begins`. `repeated` counts the steps made again, `met` the
    kinks there. `falls` is the measured order of smooth errors. `lost` is the first time [ns] from
    which on fewer steps than wanted were repeated, and the reason; `failure` is the reason why
    nothing is known, if so. Arrays are replaced, never changed.
    """

    lengths: tuple[float, ...]
    bounds: np.ndarray
    leaps: np.ndarray
    watched: np.ndarray
    kinks: np.ndarray
    jumps: np.ndarray
    switched: bool = False
    ended: tuple[Course, ...] = ()
    course: Course | None = None
    point: NetworkSnapshot | None = None
    steps: int = 0
    size: int = 0
    until: int = 0
    begins: int = 0
    repeated: int = 0
    met: int = 0
    falls: float | None = None
    lost: tuple[int, str] | None = None
    failure: str = ""
    stretch: Stretch | None = None

    def __deepcopy__(self, _: object) -> EstimateState:
        """The same, which stays as it is while this changes."""
        return replace(self, stretch=deepcopy(self.stretch))

    def widen(self, values: np.ndarray) -> None:
        """Account for `values` (n_times, n) of the run, in the sources' units, in the bounds."""
        (low, high), least, most = self.bounds, values.min(axis=0), values.max(axis=0)
        self.bounds = np.array([np.minimum(low, least), np.maximum(high, most)])
        leaps = np.abs(np.diff(values, axis=0)).max(axis=0)
        self.leaps = np.maximum(self.leaps, leaps)

    @property
    def courses(self) -> tuple[Course, ...]:
        """All courses with known errors, in their order."""
        going = (self.course,) if self.course and self.course.other else ()
        return (*self.ended, *going)

    def end(self) -> None:
        """End the present course; its errors count."""
        self.ended, self.course, self.point = self.courses, None, None

    @property
    def points(self) -> tuple[NetworkSnapshot, ...]:
        """The points that the estimate returns to."""
        found = (self.stretch and self.stretch.start, self.point)
        return tuple(point for point in found if point)
