"""How the parts of a scene are drawn: lines and outlines in metres."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence

import numpy as np

from m4e_fmi.report.drawing import symbols
from m4e_fmi.report.drawing.symbols import Line

SPRING, DAMPER, OTHER = "#2a7f62", "#7a4fa3", "#7b8794"
WIDTH = 0.022  # of a spring, as a part of the picture's size
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
    start, end = symbols.between(ends[0], ends[1], [0, 1], [SPACING * width * rank] * 2)
    arms = [np.array(pair) for pair in ((ends[0], start), (end, ends[1]))]
    if kind == "tension_spring":
        return [symbols.spring(start, end, width), *arms]
    if kind == "tension_damper":
        return [*symbols.damper(start, end, width), *arms]
    return [np.array([start, end]), *arms]


def _around(kind: str, ends: np.ndarray, rank: float, unit: float) -> list[Line]:
    """A spiral or an arc with a bar, around the joint between two bodies."""
    lines = [] if np.allclose(*ends) else [ends]
    centre = ends.mean(axis=0)
    inner = (1.5 + 1.1 * rank) * unit
    if kind == "torsion_spring":
        return [symbols.spiral(centre, inner, inner + 1.3 * unit), *lines]
    radius = inner + 0.9 * unit
    angle = -1.4
    bar = [
        symbols.arc(centre, r, angle, angle)[0] for r in (radius - 0.7 * unit, radius + 0.7 * unit)
    ]
    return [symbols.arc(centre, radius, -2.6, -0.2), np.array(bar), *lines]
