"""The surface of a body as polygons: that of its shape, or of the box with its inertia."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.model import Body, Box, Cylinder, Mesh, Sphere
from m4e_fmi.model.elements import inertia_of, quantity, vector
from m4e_fmi.model.expression import Values
from m4e_fmi.model.shapes import Shape, reduced

Floats = NDArray[np.float64]

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
SIDES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
"""Corners of each side of a box, in order."""
THINNEST, WIDEST = 0.015, 0.6
"""Half sides of a box with the inertia of a body, relative to the size of the scene."""
AROUND, DOWN = 24, 12
"""Sides of a cylinder and of a sphere; rows of a sphere."""


@dataclass(frozen=True)
class Hull:
    """Polygons in body axes: `vertices` (n, 3) [m], and for each of the `faces` its corners.

    The edges of an `edged` one are drawn.
    """

    vertices: Floats
    faces: tuple[tuple[int, ...], ...]
    edged: bool = True

    @cached_property
    def alike(self) -> tuple[NDArray[np.intp], ...]:
        """The faces (F, k) [1] of each number k of corners."""
        counts = {len(face) for face in self.faces}
        return tuple(
            np.array([face for face in self.faces if len(face) == k]) for k in sorted(counts)
        )


def shape_hull(shape: Shape, values: Values, most: int) -> Hull:
    """The surface of a shape, with these values of the parameters; a mesh of `most` triangles."""

    def number(name: str) -> float:
        return float(quantity(shape, name).evaluate(values))

    def place(name: str) -> Floats:
        return np.array([float(part.evaluate(values)) for part in vector(shape, name)])

    match shape:
        case Box():
            sides = np.array([number("length"), number("width"), number("height")])
            return Hull(place("center") + CORNERS * sides / 2, SIDES)
        case Cylinder():
            rims = _turned(np.array([[1, 0.5], [1, -0.5]]), number("radius"), number("height"))
            return Hull(place("center") + rims @ _towards(place("axis")), (*_rings(2), *_ends(2)))
        case Sphere():
            angles = np.linspace(0, np.pi, DOWN + 1)
            rows = np.stack([np.sin(angles), np.cos(angles)], axis=1)
            radius = number("radius")
            return Hull(place("center") + _turned(rows, radius, radius), _rings(DOWN + 1))
        case Mesh():
            points = reduced(shape.triangles, most).reshape(-1, 3)
            corners, index = np.unique(points, axis=0, return_inverse=True)
            faces = tuple(map(tuple, index.reshape(-1, 3).tolist()))
            return Hull(place("mesh_origin") + corners, faces, edged=False)


def turned_hull(
    profile: Floats, center: Floats, axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
) -> Hull:
    """A body of revolution about an `axis` through `center` (3,) [m], its ends closed.

    Its `profile` (n, 2) [m] has radii, and places along the axis.
    """
    rings = _turned(profile, 1.0, 1.0)
    upright = axis[0] == axis[1] == 0.0
    along = rings if upright else rings @ _towards(np.array(axis))
    faces = [*_rings(len(profile)), *_ends(len(profile))]
    return Hull(center + along, tuple(faces))


def _turned(profile: Floats, radius: float, height: float) -> Floats:
    """A profile (n, 2) of distances from Z and heights, turned about Z: (n·AROUND, 3)."""
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    across = radius * np.multiply.outer(profile[:, 0], np.stack([np.cos(angles), np.sin(angles)]))
    up = np.broadcast_to(height * profile[:, 1, None], (len(profile), AROUND))
    return np.stack([across[:, 0], across[:, 1], up], axis=-1).reshape(-1, 3)


def _rings(count: int) -> tuple[tuple[int, ...], ...]:
    """Quadrilaterals between each ring of AROUND corners and the next."""
    return tuple(
        (AROUND * row + k, AROUND * row + following,
         AROUND * (row + 1) + following, AROUND * (row + 1) + k)
        for row in range(count - 1)
        for k in range(AROUND)
        for following in [(k + 1) % AROUND]
    )  # fmt: skip


def _ends(count: int) -> tuple[tuple[int, ...], ...]:
    """The first and the last of `count` rings as halves of discs, so that they are seen to turn."""
    half = AROUND // 2
    halves = [range(k * half, (k + 1) * half + 1) for k in range(2)]
    return tuple(
        tuple(ring * AROUND + k % AROUND for k in part)
        for ring in (0, count - 1)
        for part in halves
    )


def _towards(axis: Floats) -> Floats:
    """Rows: unit vectors across and, last, along `axis`."""
    along = axis / np.linalg.norm(axis)
    across = np.cross(np.eye(3)[np.argmin(np.abs(along))], along)
    across /= np.linalg.norm(across)
    return np.array([across, np.cross(along, across), along])


def inertia_box(body: Body, values: Values) -> Hull:
    """The uniform box with the mass and inertia of a body, about its centre of gravity.

    Of a mass that is not known yet the proportions are right.
    """
    mass = 1.0 if body.is_neutral else float(quantity(body, "mass").evaluate(values))
    given = [float(part.evaluate(values)) for part in inertia_of(body)]
    xx, yy, zz, xy, yz, zx = [*given, 0.0, 0.0, 0.0][:6]
    moments, axes = np.linalg.eigh([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    squares = np.maximum(0.0, 1.5 * (moments.sum() - 2 * moments) / mass)
    return Hull(CORNERS * np.sqrt(squares) @ axes.T, SIDES)


def fitted(box: Hull, size: float) -> Hull:
    """A box in a scene of this size [m]: smaller if it is too long, thin sides made visible."""
    corners = box.vertices
    sides = np.array([corners[4] - corners[0], corners[2] - corners[0], corners[1] - corners[0]])
    lengths = np.linalg.norm(sides, axis=1) / 2
    smaller = min(1.0, WIDEST * size / max(lengths.max(), 1e-300))
    spare = np.linalg.qr(np.vstack([sides, np.eye(3)]).T)[0].T
    units = [
        side / (2 * length) if length > 0 else spare[k]
        for k, (side, length) in enumerate(zip(sides, lengths, strict=True))
    ]
    halves = np.maximum(smaller * lengths, THINNEST * size)[:, None] * np.array(units)
    return Hull(CORNERS @ halves, SIDES)
