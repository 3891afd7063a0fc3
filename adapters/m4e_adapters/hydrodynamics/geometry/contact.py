"""Walls of bodies that slide on each other: between them there is no water.

A pile in its sleeve, a float on its spar: the walls that both have in common are dry. What is left
of both hulls is the surface that the water touches, so their flow is that of one body whose parts
move on their own along the walls.
"""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.geometry.checks import place
from m4e_adapters.hydrodynamics.geometry.clearance import points_on, sides_of
from m4e_adapters.hydrodynamics.geometry.lid import loops, waterline
from m4e_adapters.hydrodynamics.geometry.panels import RELATIVE_TOLERANCE, Panels


def on_the_bed(panels: Panels, depth: float) -> Panels:
    """The surface, closed at z = −`depth` [m] where it is open there, its vertices exactly there.

    Surfaces that do not reach so deep are as they were.
    """
    if math.isinf(depth):
        return panels
    vertices = panels.vertices.copy()
    at_bed = np.abs(vertices[:, 2] + depth) < RELATIVE_TOLERANCE * panels.size
    vertices[at_bed, 2] = -depth
    panels = Panels(vertices, panels.faces)
    rims = [edge for edge in waterline(panels) if at_bed[list(edge)].all()]
    faces = [panels.faces]
    for loop in loops(rims):
        middle = len(vertices)
        vertices = np.concatenate([vertices, vertices[loop].mean(axis=0, keepdims=True)])
        edges = zip(loop, [*loop[1:], loop[0]], strict=True)
        faces.append(np.array([[b, a, middle, middle] for a, b in edges]))
    return Panels(vertices, np.concatenate(faces)).merged()


APART = 0.1  # of a panel's side: distance of two walls in contact, of round ones with flat panels
OPPOSITE = 0.8  # cosine of the angle between their normals, of round ones with flat panels
ALONG = 0.02  # of a wall's area, that it may turn against the direction in which bodies slide
INSET = 0.1  # of a panel, by which the points that are looked at lie within its edges


class SlidingError(ValueError):
    """Two bodies do not slide along a common wall: the message says why."""


REMEDY = (
    "both hulls need the same wall, as a cylinder in a hole of its radius, and edges of panels "
    "where it begins and ends: give profiles a point there"
)


def common_walls(
    first: Panels, second: Panels, *, whole: tuple[Panels, Panels]
) -> tuple[np.ndarray, np.ndarray]:
    """Which panels of the `first` and `second` surface are walls of both, (n,) and (m,) booleans.

    They are parts of `whole` hulls. SlidingError if there are none, if some panels are such a wall
    only in part, or if the wall holds the bodies in all directions.
    """
    found = []
    for panels, wall in ((first, whole[1]), (second, whole[0])):
        shares = _shares(panels, wall)
        partly = np.flatnonzero((shares > 0.0) & (shares < 1.0))
        if len(partly):
            where = place(panels.centers[partly[0]])
            raise SlidingError(f"panels of one lie only partly on the wall of the other {where}")
        found.append(shares == 1.0)
    if not all(walls.any() for walls in found):
        raise SlidingError("they have no wall in common")
    areas = first.normals[found[0]]
    units = areas / np.sqrt(np.linalg.norm(areas, axis=1))[:, None]
    least, *_, most = np.linalg.eigvalsh(units.T @ units)
    if least > ALONG * most:
        raise SlidingError("their common wall faces all ways, along which they cannot slide")
    return found[0], found[1]


def _shares(panels: Panels, wall: Panels) -> np.ndarray:
    """Share of each of the `panels` that lies on a `wall` which faces it, (nf,) [1]."""
    points = points_on(panels, inset=INSET).reshape(len(panels.faces), -1, 3)
    areas, sides = panels.normals, sides_of(panels)
    normals = areas / np.linalg.norm(areas, axis=1)[:, None]
    triangles, facing, length = _triangles(wall)
    shares = np.zeros(len(points))
    low, high = wall.vertices.min(axis=0), wall.vertices.max(axis=0)
    reach = panels.radii[:, None] + APART * max(float(sides.max()), float(length.max()))
    near = (panels.centers > low - reach) & (panels.centers < high + reach)
    for k in np.flatnonzero(near.all(axis=1)):
        against = normals[k] @ facing.T < -OPPOSITE
        within = np.maximum(sides[k], length[against]) * APART
        on = _on(points[k], triangles[against], facing[against], within, 0.5 * INSET * sides[k])
        shares[k] = on.any(axis=1).mean()
    return shares


def _triangles(wall: Panels) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles (n, 3, 3) [m] that have an area, normals (n, 3), their panels' sides (n,) [m]."""
    triangles = wall.triangles
    sides = np.tile(sides_of(wall), 2)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1)
    some = length > 1e-9 * sides**2
    return triangles[some], normals[some] / length[some, None], sides[some]


def _on(
    points: np.ndarray,
    triangles: np.ndarray,
    normals: np.ndarray,
    within: np.ndarray,
    beside: float,
) -> np.ndarray:
    """Which `points` (p, 3) are on which `triangles` (n, 3, 3), (p, n); all in m.

    They may be `within` (n,) [m] before or behind them, and as far as `beside` [m] their edges.
    """
    height = np.einsum("pnx,nx->pn", points[:, None] - triangles[:, 0], normals)
    level = points[:, None] - height[:, :, None] * normals  # (p, n, 3), in the triangle's plane
    within_edges = np.ones(height.shape, dtype=bool)
    distance = np.full(height.shape, np.inf)
    for k in range(3):
        edge = triangles[:, (k + 1) % 3] - triangles[:, k]
        away = level - triangles[:, k]
        within_edges &= np.einsum("pnx,nx->pn", away, np.cross(normals, edge)) >= 0.0
        along = np.einsum("pnx,nx->pn", away, edge) / np.einsum("nx,nx->n", edge, edge)
        nearest = np.clip(along, 0.0, 1.0)[:, :, None] * edge
        distance = np.minimum(distance, np.linalg.norm(away - nearest, axis=2))
    return (np.abs(height) <= within) & (within_edges | (distance <= beside))
