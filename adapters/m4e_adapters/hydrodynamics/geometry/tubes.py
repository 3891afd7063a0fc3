"""Panels of horizontal cylinders.

A submerged section is a polygon of the circle's area. One that the water cuts has its vertices on
the circle, and is stretched downwards to the exact displacement: its waterplane is that of the
shape.
"""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.config import HorizontalCylinder
from m4e_adapters.hydrodynamics.geometry.panels import Panels, grid, joined
from m4e_adapters.hydrodynamics.geometry.shapes import shifted


def horizontal_cylinder_panels(shape: HorizontalCylinder, panels: int, finer: int = 1) -> Panels:
    """Wetted surface of a horizontal cylinder, denser towards its ends and the waterline."""
    top, area = _half_angle(shape.radius, shape.center_z), _area(shape.radius, shape.center_z)
    girth = 2 * top * shape.radius
    edge = 1.15 * math.sqrt((girth * shape.length + 2 * area) / panels)
    arc = _arc(shape.radius, shape.center_z, 2 * finer * max(3, round(1.1 * girth / edge / 2)))
    outline = arc
    if top < math.pi:
        chord = 2 * finer * max(1, round(float(np.ptp(arc[[0, -1], 0])) / edge / 2))
        way = np.linspace(0.0, 1.0, chord + 1)[1:, None]
        outline = np.concatenate([arc, arc[-1] + way * (arc[0] - arc[-1])])
        stretch = [1.0, area / _enclosed(outline)]
        arc, outline = arc * stretch, outline * stretch
    along = 2 * finer * max(2, round(1.1 * shape.length / edge / 2))
    x = -0.5 * shape.length * np.cos(np.pi * np.linspace(0, 1, along + 1))
    side = grid(np.array([[(u, *point) for point in arc[::-1]] for u in x]))
    end = _end(outline, 0.5 * shape.length, edge, finer)
    hull = joined(side, end, end.mirrored(0))
    if shape.axis == "y":
        hull = Panels(hull.vertices[:, [1, 0, 2]] * [-1.0, 1.0, 1.0], hull.faces)
    return shifted(hull, shape)


def _half_angle(radius: float, height: float) -> float:
    """Angle [rad] at the centre from the lowest point of a circle to the water or its top."""
    return math.acos(height / radius) if height > -radius else math.pi


def _area(radius: float, height: float) -> float:
    """Area [m2] below the water of an upright disc whose centre is at that height [m]."""
    top = _half_angle(radius, height)
    return radius**2 * (top - math.sin(top) * math.cos(top))


def _arc(radius: float, height: float, count: int) -> np.ndarray:
    """Points (count + 1, 2) [m], aside and z, on the circle below the water, by its lowest point.

    All around it, if it is submerged: then the polygon has the circle's area.
    """
    part, top = np.linspace(-1.0, 1.0, count + 1), _half_angle(radius, height)
    angles = top * part
    if top < math.pi:  # finer towards the waterline
        angles = top * (0.7 * part + 0.3 * np.sin(0.5 * np.pi * part))
    else:
        radius *= math.sqrt(2 * math.pi / count / math.sin(2 * math.pi / count))
    points = np.stack([radius * np.sin(angles), height - radius * np.cos(angles)], axis=1)
    if top < math.pi:
        points[[0, -1], 1] = 0.0
    else:
        points[-1] = points[0]
    return points


def _enclosed(outline: np.ndarray) -> float:
    """Area [m2] within a closed line (n, 2) [m] whose last point is its first."""
    (y, z), (v, w) = outline[:-1].T, outline[1:].T
    return 0.5 * float(y @ w - v @ z)


def _end(outline: np.ndarray, x: float, edge: float, finer: int) -> Panels:
    """Rings of panels [m] within a closed line (n, 2), at that x, facing +X."""
    center = np.array([0.0, 0.5 * (outline[:, 1].min() + outline[:, 1].max())])
    spokes = outline - center
    count = finer * max(2, round(float(np.linalg.norm(spokes, axis=1).mean()) / edge))
    places = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, count + 1))
    points = center + places[:, None, None] * spokes
    return grid(np.concatenate([np.full((*points.shape[:2], 1), x), points], axis=2)).merged()
