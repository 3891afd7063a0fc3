"""Triangles cut by a plane, exactly."""

from __future__ import annotations

import numpy as np


def below(triangles: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """The parts of `triangles` (n, 3, 3) [m] that are below a plane, as triangles (k, 3, 3) [m].

    `heights` (n, 3) [m] are those of the corners above the plane. Corners keep their order, so that
    normals keep their side; a triangle that touches the plane with a corner or an edge only, or
    lies in it, is left out if no part of it is below.
    """
    under = heights < 0.0
    count = under.sum(axis=1)
    one, two = count == 1, count == 2
    # the corner that differs from the two others comes first
    first = np.where(one, np.argmax(under, axis=1), np.argmin(under, axis=1))
    order = (first[:, None] + np.arange(3)) % 3
    rows = np.arange(len(triangles))[:, None]
    a, b, c = np.moveaxis(triangles[rows, order], 1, 0)
    h = heights[rows, order]
    ab, ac = _crossing(a, b, h[:, 0], h[:, 1]), _crossing(a, c, h[:, 0], h[:, 2])

    def stacked(mask: np.ndarray, *corners: np.ndarray) -> np.ndarray:
        """The triangles of `corners`, each (n, 3) [m], where `mask` (n,), booleans, is true."""
        return np.stack([corner[mask] for corner in corners], axis=1)

    return np.concatenate(
        [
            triangles[count == 3],
            stacked(one, a, ab, ac),
            stacked(two, ab, b, c),
            stacked(two, ab, c, ac),
        ]
    )


def _crossing(p: np.ndarray, q: np.ndarray, h_p: np.ndarray, h_q: np.ndarray) -> np.ndarray:
    """Points (n, 3) [m] where the edges from `p` to `q` (n, 3) [m] pass the plane.

    `h_p` and `h_q` (n,) [m] are their heights above it. Edges that do not pass it give their start.
    """
    passes = (h_p < 0.0) != (h_q < 0.0)
    # from the lower end, whichever way the edge runs: neighbours meet in the same point
    low = np.where(h_p < h_q, h_p, h_q)
    high = np.where(h_p < h_q, h_q, h_p)
    lower = np.where((h_p < h_q)[:, None], p, q)
    upper = np.where((h_p < h_q)[:, None], q, p)
    part = np.where(passes, low / np.where(passes, low - high, 1.0), 0.0)
    return np.where(passes[:, None], lower + part[:, None] * (upper - lower), p)
