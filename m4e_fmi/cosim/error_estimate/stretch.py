"""Steps of a run that are repeated together, and the run that is followed about kinks."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from m4e_fmi.cosim.error_estimate.windows import Told
from m4e_fmi.cosim.exchange.network import Change, NetworkSnapshot


@dataclass
class Stretch:
    """Steps since `start`, up to the `last` time [ns], and if it is `recorded`, source values.

    These are arrays (n, n_sources), in the outputs' units; `runs` are sizes [ns] and numbers of
    equal steps. `jumps` are the times to which a jump has led, of which some were `within` the
    step; `kinks` the indices of steps that are suddenly rough, `changes` the values set at some
    times, and `steps` the number of steps so far. A `window` is repeated in any case, up to the
    step `end` of the run.
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

    def check(self) -> None:
        """ValueError if no run can have made this stretch."""
        columns = {value.shape[1] for value in self.values if value.ndim == 2}
        rows = sum(len(value) for value in self.values if value.ndim == 2)
        kinks = [kink for found in self.kinks for kink in found.tolist()]
        if any(value.ndim != 2 for value in self.values) or len(columns) > 1:
            raise ValueError("values of a stretch are not of the same outputs")
        if self.steps != sum(count for _, count in self.runs) or any(n < 1 for _, n in self.runs):
            raise ValueError("steps of a stretch are not those of its runs")
        if self.recorded and rows != self.steps + 1:
            raise ValueError("values of a stretch are not those of its steps")
        if not all(0 <= kink <= self.steps for kink in kinks):
            raise ValueError("kinks of a stretch are not within it")

    def copy(self) -> Stretch:
        """The same, which stays as it is while this goes on."""
        changes = {time: changes.copy() for time, changes in self.changes.items()}
        lists = {n: getattr(self, n).copy() for n in ("runs", "values", "jumps", "kinks", "within")}
        return replace(self, changes=changes, **lists)

    @property
    def own_jumps(self) -> list[int]:
        """Times [ns] to which a jump has led that was not within a step."""
        within = set(self.within)
        return [time for time in self.jumps if time not in within]

    def extend(self, steps: int, size: int) -> None:
        """Add so many steps of `size` [ns]."""
        if self.runs and self.runs[-1][0] == size:
            self.runs[-1] = size, self.runs[-1][1] + steps
        else:
            self.runs.append((size, steps))
        self.last += size * steps
        self.steps += steps

    @property
    def times(self) -> np.ndarray:
        """Times (steps + 1,) [ns] of all points, the first included."""
        sizes, counts = np.array(self.runs, dtype=np.int64).T
        passed = np.concatenate([np.zeros(1, dtype=np.int64), np.repeat(sizes, counts)]).cumsum()
        return self.last - passed[-1] + passed


@dataclass(frozen=True)
class Followed:
    """A run without the errors of kinks, at `point`, and the errors it has `told` of these.

    It goes beside the run `since` a time [ns]; the errors are those from the first kink on.
    """

    point: NetworkSnapshot
    since: int
    told: Told
