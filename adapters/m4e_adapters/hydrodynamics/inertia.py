"""Inertia of bodies with the shape of a hull: a homogeneous solid, and a shell of one thickness.

With a point p of the body, its mean C = <p pᵀ> about the centre of gravity gives I = m (tr C − C).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def solid_inertia(triangles: np.ndarray, center: Sequence[float]) -> np.ndarray:
    """Tensor (3, 3) over the mass [m2] about `center` [m] of the solid within a surface.

    Its `triangles` (n, 3, 3) [m] may be open at z = 0.
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    return _tensor(triangles, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, 4, center)


def shell_inertia(triangles: np.ndarray, center: Sequence[float]) -> np.ndarray:
    """Tensor (3, 3) over the mass [m2] about `center` [m] of `triangles` (n, 3, 3) [m]."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return _tensor(triangles, 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1), 3, center)


def _tensor(
    triangles: np.ndarray, sizes: np.ndarray, corners: int, center: Sequence[float]
) -> np.ndarray:
    """Of simplices of these `sizes` (n,) [m2 or m3], with a fourth of their corners at 0."""
    total, sums = sizes.sum(), triangles.sum(axis=1)
    mean = sizes @ sums / (corners * total)
    squares = np.einsum("n,nki,nkj->ij", sizes, triangles, triangles)
    squares += np.einsum("n,ni,nj->ij", sizes, sums, sums)
    squares /= corners * (corners + 1) * total
    g = np.array(center)
    spread = squares - np.outer(g, mean) - np.outer(mean, g) + np.outer(g, g)
    return np.trace(spread) * np.eye(3) - spread
