"""Differences of a second trajectory from the run, and the errors of a whole run by them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from m4e_fmi.cosim.network.network import TWICE

EQUAL = 8
"""Parts of a course of equal times, which show how its errors grow and fall."""
DOUBLE, FASTER = 1.8, 2.2
"""Growth from one half to the other from which on errors are taken to go on growing, and to grow
faster than with the time."""
LEAST, MOST = 0.05, np.log2(FASTER)
"""Bounds of the exponent: a window whose errors grow FASTER goes on, while they are the largest."""


@dataclass(frozen=True)
class Course:
    """Differences between a second trajectory, which starts at `begin` [ns], and the run.

    The steps of the trajectory are `length` times as long as the run's. `differences` (n_pieces, n)
    are the largest in each piece of it, in the sources' units; the pieces end at the times `edges`
    [ns]. Of its `span` [ns], the part `other` was made in steps that are not the run's.

    A course that `speaks` stands for all steps up to the next one that speaks; the others stand for
    their own steps only.
    """

    begin: int
    length: float
    speaks: bool
    differences: np.ndarray
    edges: tuple[int, ...] = ()
    other: int = 0

    @classmethod
    def at(cls, begin: int, length: float, count: int, *, speaks: bool) -> Course:
        """A course of steps of this `length` that is to begin, of `count` sources."""
        return cls(begin, length, speaks, np.zeros((0, count)))

    @property
    def end(self) -> int:
        """The time [ns] up to which it has gone."""
        return self.edges[-1] if self.edges else self.begin

    @property
    def span(self) -> int:
        """The time [ns] that it has gone."""
        return self.end - self.begin

    def further(self, found: np.ndarray, end: int, other: int) -> Course:
        """The course with a further piece up to `end` [ns].

        Differences `found` there, (m, n), are in the sources' units. Of the piece, the time `other`
        [ns] was made in steps that are not the run's.
        """
        largest = found.max(axis=0, initial=0.0)
        return replace(
            self,
            differences=np.concatenate((self.differences, largest[None])),
            edges=(*self.edges, end),
            other=self.other + other,
        )

    def errors(self, order: float) -> np.ndarray:
        """Largest errors (m, n) of the run in EQUAL times, in the sources' units, by their order.

        Where some steps are the same in both runs, these are taken to have errors like the others.
        """
        whole = 1.0 if self.length == TWICE else 2.0**order
        ends = np.array(self.edges, dtype=np.int64) - self.begin
        parts = np.maximum(ends - 1, 0) * EQUAL // max(1, self.span)
        begins = np.unique(parts, return_index=True)[1]
        found = np.maximum.reduceat(self.differences, begins, axis=0)
        return found * (self.span / max(1, self.other) * whole / (2.0**order - 1))


def grows(shares: np.ndarray, factor: float = DOUBLE) -> bool:
    """True if the largest error over range, of `shares` (m, n) [1], grows in the second half."""
    first = shares[: (len(shares) + 1) // 2].max(initial=0.0)
    return bool(shares.max(initial=0.0) > factor * first)


def throughout(
    courses: Sequence[Course], errors: Sequence[np.ndarray], start: int, end: int
) -> np.ndarray:
    """Errors (n,) of a run from `start` to `end` [ns], in the sources' units.

    `errors` are those of each course, (m, n), in the sources' units. How they grow beyond it is
    taken from the longest with errors. If E doubles with the time (as the phase of an undamped
    oscillation), the error of all that a course speaks for, over the time S, is E S/τ with τ its
    length, and these add up; if it does not grow (where oscillations are damped and forced), the
    error is E, and the largest counts. In between, with an exponent γ = log₂ of what E grows by in
    the second half of the course, error = (Σ E^(1/γ) S/τ)^γ. Errors may also grow because motions
    do, and die out in between: only the share of them that lasts adds up.
    """
    edges = [start, *[one.begin for one in courses if one.speaks][1:], end]
    alone = [one for one in courses if not one.speaks]
    parts = iter(
        [
            end - begin - sum(one.span for one in alone if begin <= one.begin < end)
            for begin, end in pairwise(edges)
        ]
    )
    each = np.array([found.max(axis=0) for found in errors])
    largest = each.max(axis=0)
    longest = max(range(len(courses)), key=lambda k: (each[k].any(), courses[k].span))
    first = errors[longest][: (len(errors[longest]) + 1) // 2].max(axis=0)
    growth = np.divide(each[longest], first, out=np.ones_like(first), where=first > 0.0)
    exponent = np.clip(np.log2(growth), LEAST, MOST)
    scale = np.where(largest > 0.0, largest, 1.0)
    times = [[max(next(parts) / one.span, 1.0) if one.speaks else 1.0] for one in courses]
    total = np.sum((each / scale) ** (1 / exponent) * times, axis=0)
    grown = scale * np.where(largest > 0.0, total, 0.0) ** exponent
    return largest + _lasting(errors[longest]) * (grown - largest)


def _lasting(errors: np.ndarray) -> np.ndarray:
    """Share (n,) [1] of errors (m, n) that lasts: what they fall to in two pieces running.

    One piece says little: it may be where an oscillation goes through zero.
    """
    before = np.maximum.accumulate(errors, axis=0)[:-2]
    after = np.maximum(errors[1:-1], errors[2:])
    fallen = np.divide(after, before, out=np.ones_like(after), where=before > 0.0)
    return fallen.min(axis=0, initial=1.0)
