"""Outlines of the symbols of mechanics, as polylines (n, 2) in metres. Pure geometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

Line = np.ndarray


def spring(start: ArrayLike, end: ArrayLike, width: float, *, turns: int = 9) -> Line:
    """A zigzag (n, 2) [m] of `width` from `start` to `end`, (2,) [m] each, straight at its ends."""
    inner = (np.arange(2 * turns) + 0.5) / (2 * turns)
    along = np.concatenate([[0, 0.12], 0.12 + 0.76 * inner, [0.88, 1]])
    across = np.zeros_like(along)
    across[2:-2] = np.where(np.arange(2 * turns) % 2, 0.5, -0.5)
    return between(start, end, along, width * across)


def damper(start: ArrayLike, end: ArrayLike, width: float) -> list[Line]:
    """A dashpot of `width` midway between `start` and `end`, (2,) [m] each.

    Returns rod, piston, cylinder and rod, (n, 2) each [m].
    """
    length = float(np.linalg.norm(np.asarray(end, float) - np.asarray(start, float))) or 1.0
    half = min(0.2, 0.9 * width / length)  # of the cylinder, as a part of the length
    low, high, w = 0.5 - half, 0.5 + half, width / 2
    pieces = (
        ((0, 0), (0.5, 0)),
        ((0.5, 0.75 * w), (0.5, -0.75 * w)),
        ((low, w), (high, w), (high, -w), (low, -w)),
        ((high, 0), (1, 0)),
    )
    return [between(start, end, *np.array(piece, float).T) for piece in pieces]


def between(start: ArrayLike, end: ArrayLike, along: ArrayLike, across: ArrayLike) -> Line:
    """Points (n, 2) [m] at parts `along` (n,) [1] of the way from `start` to `end`, (2,) [m] each.

    They are `across` (n,) [m] beside it.
    """
    a, b = np.asarray(start, float), np.asarray(end, float)
    way = b - a
    length = np.linalg.norm(way)
    normal = np.array([-way[1], way[0]]) / (length or 1.0)
    return a + np.outer(np.asarray(along), way) + np.outer(np.asarray(across), normal)


def spiral(centre: ArrayLike, inner: float, outer: float, *, turns: float = 2.0) -> Line:
    """A torsion spring (n, 2) [m] about `centre` (2,) [m], between two radii [m]."""
    angle = np.linspace(0, 2 * np.pi * turns, 80)
    radius = np.linspace(inner, outer, 80)
    return np.asarray(centre) + radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def arc(centre: ArrayLike, radius: float, first: float, last: float) -> Line:
    """An arc (n, 2) [m] about `centre` (2,) [m].

    It leads from angle `first` to `last` [rad], counted from +X towards +Z.
    """
    angle = np.linspace(first, last, 40)
    return np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def ground(start: ArrayLike, end: ArrayLike, hatch: float) -> list[Line]:
    """A line from `start` to `end`, (2,) [m] each, with hatching below it.

    Returns the line and the strokes, each of about `hatch` [m], (2, 2) [m].
    """
    ends = sorted((np.asarray(start, float), np.asarray(end, float)), key=tuple)
    way = ends[1] - ends[0]
    length = float(np.hypot(*way))
    along = way / length
    below = np.array([along[1], -along[0]])
    count = max(3, round(length / hatch))
    tops = ends[0] + np.outer((np.arange(count) + 0.5) / count, way)
    return [np.array(ends), *(np.array([t, t + hatch * (below - 0.8 * along)]) for t in tops)]
