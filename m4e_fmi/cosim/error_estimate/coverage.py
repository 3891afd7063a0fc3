"""Coverage of a run by the estimate of its coupling error: which parts were repeated, and how."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.cosim.system.simulation import NS_PER_SECOND

NAMED = 3
"""Number of times that a text lists, of more."""


@dataclass(frozen=True)
class Coverage:
    """Repeated parts of a run from `start` to `end`; times in nanoseconds.

    `doubled` are the spans that were repeated in steps of another length; `followed` those over
    which a second run went beside the first, `kinks` the times of contacts, switches and jumps
    that it met in finer steps. They were many from `crowded` on, and left to windows. `lost` are
    times from which on kinks could not be followed, and why.
    """

    start: int
    end: int
    doubled: tuple[tuple[int, int], ...] = ()
    followed: tuple[tuple[int, int], ...] = ()
    kinks: tuple[int, ...] = ()
    crowded: int | None = None
    lost: tuple[tuple[int, str], ...] = ()

    def twice(self, begin: int, end: int) -> Coverage:
        """With a further window."""
        return replace(self, doubled=(*self.doubled, (begin, end)))

    def follow(self, since: int, until: int, kinks: np.ndarray) -> Coverage:
        """With a second run over this span [ns], and `kinks` (k,) [ns] within its last part."""
        others = tuple(one for one in self.followed if one[0] != since)
        met = (*self.kinks, *kinks.tolist())
        return replace(self, followed=(*others, (since, until)), kinks=met)

    def crowd(self, time: int) -> Coverage:
        """With many kinks, from this time on if it is the first."""
        return self if self.crowded is not None else replace(self, crowded=time)

    def lose(self, since: int, why: str) -> Coverage:
        """Without knowledge of kinks from some time on."""
        return self if self.lost else replace(self, lost=((since, why),))

    @property
    def share(self) -> float:
        """Share of the run that was repeated, in one way or another."""
        span = self.end - self.start
        watched, last = 0, self.start
        for begin, end in sorted((*self.doubled, *self.followed)):
            watched += max(0, end - max(begin, last))
            last = max(last, end)
        return watched / span if span else 0.0

    def __str__(self) -> str:
        share = min(99, round(100 * self.share))
        text = f"{share} % of the run repeated, the rest monitored for kinks"
        if self.share == 1.0:
            text = "all of the run repeated"
        if self.kinks:
            text += f"; finer steps about {_listed(self.kinks)}"
        if self.crowded is not None:
            since = f"{self.crowded / NS_PER_SECOND:.6g}"
            text += (
                f"; kinks are frequent from t = {since} s on, and evaluated where it is repeated"
            )
        for begin, why in self.lost:
            text += f"; kinks are not followed from t = {begin / NS_PER_SECOND:.6g} s on: {why}"
        return text


def _listed(times: Sequence[int]) -> str:
    named = ", ".join(f"{time / NS_PER_SECOND:.6g}" for time in times[:NAMED])
    more = len(times) - NAMED
    return f"t = {named} s" + (f" and {more} more" if more > 0 else "")
