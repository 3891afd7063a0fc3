"""Overlap of hulls: panels of one body inside another.

A point is inside a closed surface if the surface covers the whole sphere around it (solid angle 4π)
and outside if it covers nothing. A hull and its mirror image in the still-water level close each
other.
"""

from __future__ import annotations

import numpy as np

from m4e_adapters.hydrodynamics.panels import Panels

INSIDE = 0.5  # of 4π
DEPTH = 0.02  # below its panel that a point is looked at, over the panel's size


def panels_inside(panels: Panels, other: Panels) -> np.ndarray:
    """Centres (n, 3) [m] of those of `panels` that have the hull `other` behind them.

    The points looked at are a little inside the panels' own body: where two bodies only touch, none
    is in the other; where they coincide, all are.
    """
    corners, centers = panels.corners, panels.centers
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    twice_area = np.linalg.norm(normals, axis=1, keepdims=True)
    points = centers - DEPTH * normals / np.sqrt(np.maximum(twice_area, 1e-300))
    low, high = other.vertices.min(axis=0), other.vertices.max(axis=0)
    near = np.all((points > low) & (points < high), axis=1)
    return centers[near][enclosed_share(points[near], other) > INSIDE]


def enclosed_share(points: np.ndarray, hull: Panels) -> np.ndarray:
    """Solid angle of `hull` with its mirror image in z = 0 from `points` (n, 3), over 4π, (n,)."""
    triangles = hull.triangles
    image = triangles[:, ::-1] * np.array([1.0, 1.0, -1.0])  # reversed: normals stay outward
    surface = np.concatenate([triangles, image])
    return np.array([_solid_angle(surface - point) for point in points]) / (4 * np.pi)


def _solid_angle(corners: np.ndarray) -> float:
    """Solid angle of triangles (n, 3, 3) from the origin (van Oosterom and Strackee, 1983)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ra, rb, rc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    volume = (a * np.cross(b, c)).sum(axis=1)
    below = ra * rb * rc + (a * b).sum(axis=1) * rc
    below += (a * c).sum(axis=1) * rb + (b * c).sum(axis=1) * ra
    return float(2.0 * np.arctan2(volume, below).sum())
