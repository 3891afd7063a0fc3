"""Errors of a whole run, from those of its windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

PIECES = 8
"""Pieces of a window, which show how its errors grow and fall."""
DOUBLE = 1.8
"""Growth from one half to the other from which on errors are taken to go on growing."""
LEAST, MOST = 0.05, 1.0
"""Bounds of the exponent."""


@dataclass(frozen=True)
class Told:
    """Largest errors (n_pieces, n_sources) in the pieces of a window of `span` from `begin` [ns].

    They are in the sources' units; half the step would leave the share `left` of them. A window
    that `speaks` stands for all steps up to the next that speaks; windows between them that do not
    speak stand for their own steps only.
    """

    errors: np.ndarray
    begin: int
    span: int
    speaks: bool
    left: float = 1.0

    @property
    def largest(self) -> np.ndarray:
        """Largest errors (n_sources,), in the sources' units."""
        return self.errors.max(axis=0)

    @property
    def halved(self) -> Told:
        """The same at half the step."""
        return replace(self, errors=self.left * self.errors)

    @property
    def growth(self) -> np.ndarray:
        """Growth factors (n_sources,) [1] of errors in the second half; 1 if they were 0 before."""
        first, whole = self.errors[: (len(self.errors) + 1) // 2].max(axis=0), self.largest
        return np.divide(whole, first, out=np.ones_like(whole), where=first > 0.0)

    def doubles(self, spans: np.ndarray) -> bool:
        """True if the largest error over its span is twice as large in the second half.

        `spans` (n_sources,) are in the sources' units.
        """
        largest = np.divide(self.errors, spans, out=np.zeros_like(self.errors), where=spans > 0.0)
        first = largest[: (len(largest) + 1) // 2].max()
        return bool(largest.max() > DOUBLE * first)

    @property
    def lasting(self) -> np.ndarray:
        """Share (n_sources,) [1] of the errors that lasts: what they fall to in two pieces running.

        One piece says little: it may be where an oscillation goes through zero.
        """
        before = np.maximum.accumulate(self.errors, axis=0)[:-2]
        after = np.maximum(self.errors[1:-1], self.errors[2:])
        fallen = np.divide(after, before, out=np.ones_like(after), where=before > 0.0)
        return fallen.min(axis=0, initial=1.0)


def pieces(errors: np.ndarray) -> np.ndarray:
    """Largest errors (n_pieces, n) in each piece of a run, in the outputs' units.

    `errors` (n_steps, n) are in the outputs' units.
    """
    begins = np.arange(min(PIECES, len(errors))) * len(errors) // min(PIECES, len(errors))
    return np.maximum.reduceat(errors, begins, axis=0)


def throughout(told: Sequence[Told], start: int, end: int) -> np.ndarray:
    """Errors (n_sources,) of a run from `start` to `end` [ns], in the sources' units.

    How they grow beyond a window is taken from the longest with errors. If E doubles with the time
    (as the phase of an undamped oscillation), the error of all that a window speaks for, over the
    time S, is E S/τ with τ the length of the window, and these add up; if it does not grow (where
    oscillations are damped and forced), the error is E, and the largest counts. In between, with an
    exponent γ = log₂ of what E grows by in the second half of the window, error =
    (Σ E^(1/γ) S/τ)^γ. Errors may also grow because motions do, and die out in between: only the
    share of them that lasts adds up.
    """
    edges = [start, *[one.begin for one in told if one.speaks][1:], end]
    alone = [one for one in told if not one.speaks]
    parts = iter(
        [
            end - begin - sum(one.span for one in alone if begin <= one.begin < end)
            for begin, end in pairwise(edges)
        ]
    )
    errors = np.array([one.largest for one in told])
    largest = errors.max(axis=0)
    longest = max(told, key=lambda one: (one.errors.any(), one.span))
    exponent = np.clip(np.log2(np.maximum(longest.growth, 1.0)), LEAST, MOST)
    scale = np.where(largest > 0.0, largest, 1.0)
    times = [[max(next(parts) / one.span, 1.0) if one.speaks else 1.0] for one in told]
    total = np.sum((errors / scale) ** (1 / exponent) * times, axis=0)
    grown = scale * np.where(largest > 0.0, total, 0.0) ** exponent
    return largest + longest.lasting * (grown - largest)
