"""How the parts of a scene are drawn: symbols of mechanics as polylines (n, 2) in metres."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

Line = np.ndarray
SPRING, DAMPER, OTHER = "#2a7f62", "#7a4fa3", "#7b8794"
WIDTH = 0.022  # of a spring, as a part of the picture's size
TURNS = 9  # of a spring
SPACING = 1.5  # between ties that lie abreast, in widths
JOINT = 0.0085  # radius of a joint, as a part of the picture's size


def colour_of(kind: str) -> str:
    """The colour of springs, of dampers, or of other loads."""
    if "spring" in kind:
        return SPRING
    return DAMPER if "damper" in kind else OTHER


def ranks(ties: Sequence[tuple[str, frozenset[Hashable]]]) -> Iterator[float]:
    """For each load of a kind between two ends its place among those with the same ends.

    The places are counted from their middle; around a joint, from the inside.
    """
    counts, seen = Counter(ends for _, ends in ties), Counter[frozenset[Hashable]]()
    for kind, ends in ties:
        yield seen[ends] - (0.0 if kind.startswith("torsion") else (counts[ends] - 1) / 2)
        seen[ends] += 1


def tie_lines(kind: str, ends: np.ndarray, rank: float, size: float) -> list[Line]:
    """Lines of a load, (n, 2) each [m], between `ends` (2, 2) [m] in a picture of this size [m]."""
    if kind.startswith("torsion"):
        return _around(kind, ends, rank, JOINT * size)
    width = WIDTH * size
    if np.allclose(*ends):
        return []
    start, end = between(ends[0], ends[1], [0, 1], [SPACING * width * rank] * 2)
    arms = [np.array(pair) for pair in ((ends[0], start), (end, ends[1]))]
    if kind == "tension_spring":
        return [spring(start, end, width), *arms]
    if kind == "tension_damper":
        return [*damper(start, end, width), *arms]
    return [np.array([start, end]), *arms]


def _around(kind: str, ends: np.ndarray, rank: float, unit: float) -> list[Line]:
    """A spiral or an arc with a bar, around the joint between two bodies."""
    lines = [] if np.allclose(*ends) else [ends]
    centre = ends.mean(axis=0)
    inner = (1.5 + 1.1 * rank) * unit
    if kind == "torsion_spring":
        return [spiral(centre, inner, inner + 1.3 * unit), *lines]
    radius = inner + 0.9 * unit
    angle = -1.4
    bar = [arc(centre, r, angle, angle)[0] for r in (radius - 0.7 * unit, radius + 0.7 * unit)]
    return [arc(centre, radius, -2.6, -0.2), np.array(bar), *lines]


def spring(start: ArrayLike, end: ArrayLike, width: float) -> Line:
    """A zigzag (n, 2) [m] of `width` from `start` to `end`, (2,) [m] each, straight at its ends."""
    inner = (np.arange(2 * TURNS) + 0.5) / (2 * TURNS)
    along = np.concatenate([[0, 0.12], 0.12 + 0.76 * inner, [0.88, 1]])
    across = np.zeros_like(along)
    across[2:-2] = np.where(np.arange(2 * TURNS) % 2, 0.5, -0.5)
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


def spiral(centre: ArrayLike, inner: float, outer: float) -> Line:
    """A torsion spring (n, 2) [m] of two turns about `centre` (2,) [m], between two radii [m]."""
    angle = np.linspace(0, 4 * np.pi, 80)
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
