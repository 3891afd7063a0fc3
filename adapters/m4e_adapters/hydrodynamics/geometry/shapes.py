"""Panels of built-in shapes: vertical cylinder, sphere, box, body of revolution.

Each panel of a mesh of about so many `panels` is divided into `finer` by `finer`: such meshes are
similar, and their errors follow the size of their panels.

The bodies of revolution are drawn with polygons of the circle's *area* (not inscribed in it) and
stretched upright to the exact displacement: buoyancy and waterplane area are those of the shape
whatever the number of panels, and the potential-flow forces converge with a smaller constant.
Angular and fore-aft numbers of panels are multiples of four: every shape is symmetric about its
own axes, which the solver makes use of.

Panels of horizontal cylinders.

A submerged section is a polygon of the circle's area. One that the water cuts has its vertices on
the circle, and is stretched downwards to the exact displacement: its waterplane is that of the
shape.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

import numpy as np

from m4e_adapters.hydrodynamics.config import Box, Cylinder, HorizontalCylinder, Revolved, Sphere
from m4e_adapters.hydrodynamics.geometry.hydrostatics import Hydrostatics, hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.lid import enclosed
from m4e_adapters.hydrodynamics.geometry.panels import Panels, grid, joined

TALLEST, GROWTH = 4.0, 0.5  # of panels on bodies of revolution: height over width, per distance

Placing = Callable[[float, float], tuple[float, float, float]]


Placed = Box | Cylinder | HorizontalCylinder | Revolved | Sphere


def cylinder_panels(shape: Cylinder, panels: int, finer: int = 1) -> Panels:
    """Wetted surface of a vertical cylinder, denser towards its edges and the waterline."""
    height, submerged = shape.draft + shape.top_z, shape.top_z < 0.0
    profile = height + shape.radius * (1 + submerged)
    around, edge = divisions(profile, 2 * math.pi * shape.radius, panels)
    bottom = finer * max(2, round(0.8 * shape.radius / edge))
    side = finer * max(2, round(1.4 * height / edge))
    outwards = shape.radius * np.sin(0.5 * np.pi * np.linspace(0, 1, bottom + 1))
    upwards = shape.top_z - 0.5 * height * (1.0 - np.cos(np.pi * np.linspace(1, 0, side + 1)))
    radii = np.concatenate([outwards, np.full(side, shape.radius)])
    heights = np.concatenate([np.full(bottom + 1, -shape.draft), upwards[1:]])
    if submerged:
        radii = np.concatenate([radii, outwards[-2::-1]])
        heights = np.concatenate([heights, np.full(bottom, shape.top_z)])
    volume = math.pi * shape.radius**2 * height
    return shifted(turned(radii, heights, finer * around, volume, pivot=shape.top_z), shape)


def sphere_panels(shape: Sphere, panels: int, finer: int = 1) -> Panels:
    """Wetted surface of a sphere, cut by the water or wholly below it."""
    radius, height = shape.radius, shape.center_z
    top = math.acos(height / radius) if height > -radius else math.pi  # angle from the lowest point
    around, edge = divisions(radius * top, 2 * math.pi * radius, panels)
    part = np.linspace(0.0, 1.0, finer * max(4, round(radius * top / edge)) + 1)
    angles = top * (0.7 * part + 0.3 * np.sin(0.5 * np.pi * part))  # finer towards the waterline
    radii, heights = radius * np.sin(angles), height - radius * np.cos(angles)
    radii[0] = 0.0
    if top == math.pi:
        radii[-1] = 0.0
        volume, pivot = 4 / 3 * math.pi * radius**3, height
    else:
        heights[-1] = 0.0
        depth = radius - height  # of the cap
        volume, pivot = math.pi * depth**2 * (3 * radius - depth) / 3, 0.0
    return shifted(turned(radii, heights, finer * around, volume, pivot=pivot), shape)


def revolved_panels(shape: Revolved, panels: int, finer: int = 1) -> Panels:
    """Wetted surface of a body of revolution, denser towards the ends of each straight part."""
    corners = _ring(shape) if shape.hole else _wetted(shape)
    around, width, rings = 8, 0.0, corners[:0]
    while around * (len(rings) - 1) < panels:
        around += 4
        width = 2 * math.pi * float(corners[:, 0].max()) / around
        rings = np.concatenate([corners[:1], *_divided(corners, width)])
    rings = np.concatenate([corners[:1], *_divided(corners, width, finer)])
    radii, heights = rings.T
    squares = radii[1:] ** 2 + radii[1:] * radii[:-1] + radii[:-1] ** 2
    volume = math.pi / 3 * float(np.diff(heights) @ squares)
    return shifted(turned(radii, heights, finer * around, volume, pivot=0.0), shape)


def _divided(corners: np.ndarray, width: float, finer: int = 1) -> Iterator[np.ndarray]:
    """Points (k, 2) [m] on each straight part of a profile, its last corner the last of them.

    They are `width` [m] apart at the ends of the part, and up to `TALLEST` times that in between;
    then each distance is divided into so many parts.
    """
    for first, last in itertools.pairwise(corners):
        way = np.linspace(0.0, 1.0, 401)
        from_end = np.minimum(way, way[::-1]) * np.linalg.norm(last - first)
        density = 1.0 / np.minimum(TALLEST * width, width + GROWTH * from_end)
        passed = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
        count = finer * max(1, round(passed[-1] * np.linalg.norm(last - first) / 400))
        part = np.interp(np.linspace(0.0, passed[-1], count + 1)[1:], passed, way)
        yield first + part[:, None] * (last - first)


def _wetted(shape: Revolved) -> np.ndarray:
    """Corners (n, 2), radius and z [m], of the closed profile below the water, from the axis."""
    points = np.array(shape.profile)
    if points[0, 0] > 0.0:
        points = np.concatenate([[[0.0, points[0, 1]]], points])
    if points[-1, 1] < 0.0 < points[-1, 0]:
        points = np.concatenate([points, [[0.0, points[-1, 1]]]])
    dry = int(np.argmax(np.append(points[:, 1], 0.0) >= 0.0))  # the first that is not below
    if dry == len(points):
        return points
    below, above = points[dry - 1], points[dry]
    radius = below[0] + (above[0] - below[0]) * below[1] / (below[1] - above[1])
    return np.concatenate([points[:dry], [[radius, 0.0]]])


def _ring(shape: Revolved) -> np.ndarray:
    """The same of a body with a hole: down its wall from the top or the water, and up outside."""
    outside = _wetted(shape)[1:]
    if outside[-1, 0] == 0.0:  # the middle of a flat end below the water
        outside = outside[:-1]
    (lowest, highest), hole = outside[[0, -1], 1], float(shape.hole or 0.0)
    top, bottom = np.array([[hole, highest]]), np.array([[hole, lowest]])
    below = [] if np.array_equal(outside[:1], bottom) else [bottom]
    return np.concatenate([top, *below, outside, *([top] if highest < 0.0 else [])])


def sphere_hydrostatics(shape: Sphere) -> Hydrostatics:
    """Hydrostatics in closed form: the metacentre is the centre of the sphere.

    That of the panels is off by 0.003 radii at 144 panels, and by as much less as there are more.
    """
    radius, height = shape.radius, shape.center_z
    x, y = shape.center_x, shape.center_y
    if height <= -radius:
        nothing = (0.0, 0.0, 0.0)
        return Hydrostatics(4 / 3 * math.pi * radius**3, (x, y, height), nothing, nothing)
    depth = radius - height  # of the cap
    volume = math.pi * depth**2 * (3 * radius - depth) / 3
    area = math.pi * (radius**2 - height**2)
    second = area**2 / (4 * math.pi)
    return Hydrostatics(
        volume,
        (x, y, height - second / volume),
        waterplane=(area, area * x, second + area * x**2),
        across=(area * y, area * x * y, second + area * y**2),
    )


def box_panels(shape: Box, panels: int, finer: int = 1) -> Panels:
    """Wetted surface of a box: flat ends and four sides, nearly square panels."""
    length, width, draft = shape.length, shape.width, shape.draft
    height, submerged = draft + shape.top_z, shape.top_z < 0.0
    area = length * width * (1 + submerged) + 2 * height * (length + width)
    edge = math.sqrt(area / panels)
    along, across = (2 * finer * max(2, round(extent / edge / 2)) for extent in (length, width))
    x = -0.5 * length * np.cos(np.pi * np.linspace(0, 1, along + 1))
    y = -0.5 * width * np.cos(np.pi * np.linspace(0, 1, across + 1))
    upwards = np.linspace(1, 0, finer * max(2, round(height / edge)) + 1)
    z = shape.top_z - 0.5 * height * (1.0 - np.cos(np.pi * upwards))

    def patch(us: np.ndarray, vs: np.ndarray, place: Placing) -> Panels:
        return grid(np.array([[place(u, v) for v in vs] for u in us]))

    top = [patch(x, y, lambda u, v: (u, v, shape.top_z))] if submerged else []
    hull = joined(
        *top,
        patch(y, x, lambda u, v: (v, u, -draft)),
        patch(y, z, lambda u, v: (0.5 * length, u, v)),
        patch(z, y, lambda u, v: (-0.5 * length, v, u)),
        patch(x, z, lambda u, v: (u, -0.5 * width, v)),
        patch(z, x, lambda u, v: (v, 0.5 * width, u)),
    )
    return shifted(hull, shape)


def divisions(profile: float, circumference: float, panels: int) -> tuple[int, float]:
    """Number of panels around (a multiple of 4) and the length [m] of a panel on the profile."""
    edge = math.sqrt(profile * circumference / panels)
    around = 4 * max(3, round(circumference / edge / 4))
    return around, profile * around / panels


def turned(
    radii: np.ndarray, heights: np.ndarray, around: int, volume: float, *, pivot: float
) -> Panels:
    """A profile turned about Z in `around` steps, stretched upright to its `volume` [m3].

    Its `radii` and `heights` (n,) [m] go from the lowest point outwards and up. The height `pivot`
    [m] stays.
    """
    turn = 2 * math.pi / around
    angles = turn * np.arange(around + 1)
    angles[-1] = 0.0
    wider = radii * math.sqrt(turn / math.sin(turn))
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.zeros((around + 1, len(radii), 3))
    points[:, :, :2] = ring[:, None, :] * wider[None, :, None]
    points[:, :, 2] = heights
    panels = grid(points).merged()
    displaced = hydrostatics_of(panels).volume
    taller = volume / displaced
    vertices = panels.vertices.copy()
    vertices[:, 2] = pivot + taller * (vertices[:, 2] - pivot)
    return Panels(vertices, panels.faces)


def shifted(panels: Panels, shape: Placed) -> Panels:
    """The panels about the place of a shape."""
    center = np.array([shape.center_x, shape.center_y, 0.0])
    return Panels(panels.vertices + center, panels.faces)


def horizontal_cylinder_panels(shape: HorizontalCylinder, panels: int, finer: int = 1) -> Panels:
    """Wetted surface of a horizontal cylinder, denser towards its ends and the waterline."""
    top = _half_angle(shape.radius, shape.center_z)
    area = shape.radius**2 * (top - math.sin(top) * math.cos(top))  # of the wetted section
    girth = 2 * top * shape.radius
    edge = 1.15 * math.sqrt((girth * shape.length + 2 * area) / panels)
    arc = _arc(shape.radius, shape.center_z, 2 * finer * max(3, round(1.1 * girth / edge / 2)))
    outline = arc
    if top < math.pi:
        chord = 2 * finer * max(1, round(float(np.ptp(arc[[0, -1], 0])) / edge / 2))
        way = np.linspace(0.0, 1.0, chord + 1)[1:, None]
        outline = np.concatenate([arc, arc[-1] + way * (arc[0] - arc[-1])])
        stretch = [1.0, area / enclosed(outline[:-1])]
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


def _end(outline: np.ndarray, x: float, edge: float, finer: int) -> Panels:
    """Rings of panels [m] within a closed line (n, 2), at that x, facing +X."""
    center = np.array([0.0, 0.5 * (outline[:, 1].min() + outline[:, 1].max())])
    spokes = outline - center
    count = finer * max(2, round(float(np.linalg.norm(spokes, axis=1).mean()) / edge))
    places = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, count + 1))
    points = center + places[:, None, None] * spokes
    return grid(np.concatenate([np.full((*points.shape[:2], 1), x), points], axis=2)).merged()
