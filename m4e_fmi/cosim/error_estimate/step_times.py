"""Times of the steps of a repeated run: of twice or half the length, or finer about kinks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

PARTS = 16
"""Steps in place of one about a kink."""
LEAST = 100
"""Length [ns] below which a step is not divided."""


def among(times: np.ndarray, others: np.ndarray) -> np.ndarray:
    """True (n,) for those of `times` (n,) [ns] that are among `others` (m,) [ns], both in order."""
    place = np.searchsorted(others, times)
    return others[np.minimum(place, len(others) - 1)] == times


def doubled(times: np.ndarray, jumps: Sequence[int], *, phase: int | None = None) -> np.ndarray:
    """Times (m,) [ns] of steps of twice the length, along those of `times` (n,) [ns].

    They are every second one, and both ends of each jump. With a `phase`, 0 or 1, they are every
    second one from that on, also after a jump: components that step more rarely have their points
    there.
    """
    last = len(times) - 1
    after = np.searchsorted(times, jumps)
    edges = np.concatenate([[0], np.column_stack((after - 1, after)).ravel(), [last]])
    begins = edges if phase is None else edges + (edges + phase) % 2
    met = np.zeros(last + 1, dtype=bool)
    met[edges] = True
    for begin, end in zip(begins[:-1], edges[1:], strict=True):
        met[begin:end:2] = True
    kept = np.flatnonzero(met)
    if len(kept) > 1 and kept[-1] - kept[-2] == 1 and last not in after:
        kept = kept[:-1]  # a single step at the end gives no difference
    return times[kept]


def halved(times: np.ndarray, jumps: Sequence[int]) -> np.ndarray:
    """Times (m,) [ns] of steps of half the length of those of `times` (n,) [ns], but over jumps."""
    smooth = ~np.isin(times[1:], jumps)
    middles = times[:-1] + np.diff(times) // 2
    return np.unique(np.concatenate([times, middles[smooth]]))


def refined(times: np.ndarray, jumps: Sequence[int], steps: np.ndarray) -> np.ndarray:
    """Times (m,) [ns] with PARTS steps in place of some of those of `times` (n,) [ns].

    These are `steps` (k,), indices, but not over jumps. If there are many, each gets fewer parts,
    so that all steps are three times as many at most.
    """
    found, most = [times], 1 + 2 * (len(times) - 1) // max(1, len(steps))
    for k in steps[~np.isin(times[1:][steps], jumps)].tolist():
        begin, end = int(times[k]), int(times[k + 1])
        parts = min(PARTS, most, (end - begin) // LEAST)
        if parts > 1:
            found.append(np.round(np.linspace(begin, end, parts + 1)).astype(np.int64))
    return np.unique(np.concatenate(found))


def length_of_others(times: np.ndarray, run: np.ndarray) -> int:
    """Length [ns] of all steps along `times` (n,) [ns] that are not steps of `run` (m,) [ns]."""
    met = among(times, run)
    same = met[:-1] & met[1:] & (np.diff(np.searchsorted(run, times)) == 1)
    return int(np.diff(times)[~same].sum())
