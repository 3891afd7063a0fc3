"""Lids: panels on the still water inside a hull, against irregular frequencies."""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.geometry.panels import Panels, grid, joined

LID_TRIALS = (1.0, 0.8, 0.6, 1.3)  # panel sizes tried, relative to the hull's


def waterline(panels: Panels) -> list[tuple[int, int]]:
    """The open edges, as (from, to) vertices in the direction of their panel."""
    found = []
    for (low, high), sides in panels.edges().items():
        if len(sides) == 1:
            found.append((low, high) if sides[0] > 0 else (high, low))
    return found


def make_lid(panels: Panels) -> Panels | None:
    """Panels on the still water inside the hull, None if there is no waterline or no way.

    Waterlines that are visible from their centres, or two with as many points around each other,
    are filled with rings, which keeps the hull's symmetries; any other shape is left to Capytaine,
    whose generator can return nothing at all and is then asked again with another spacing.
    """
    edges = waterline(panels)
    if not edges:
        return None
    lines = [panels.vertices[loop] for loop in loops(edges)]
    rings = _filled(lines)
    if rings is not None:
        return rings
    mesh = import_capytaine().Mesh(panels.vertices, panels.faces, auto_check=False)
    spacing = float(np.mean(mesh.faces_radiuses))
    for trial in LID_TRIALS:
        lid = mesh.generate_lid(faces_max_radius=trial * spacing)
        if lid.nb_faces > 0:
            return Panels(np.asarray(lid.vertices), np.asarray(lid.faces)).merged()
    return None


def _filled(lines: list[np.ndarray]) -> Panels | None:
    """Rings of panels within closed lines (n, 3) [m], or between two; None if there is no way.

    The water is on one side of all lines that stand apart, and within one that others surround.
    """
    turns = [np.sign(enclosed(line)) for line in lines]
    if len(set(turns)) == 1:
        found = [_rings(line) for line in lines]
        parts = [rings for rings in found if rings is not None]
        return joined(*parts) if parts and len(parts) == len(lines) else None
    return _between(*lines) if len(lines) == 2 else None


def enclosed(line: np.ndarray) -> float:
    """Area [m2] within a closed line (n, 2) [m], or (n, 3), positive if it runs round +Z."""
    x, y = line.T[:2]
    return 0.5 * float(x @ np.roll(y, -1) - np.roll(x, -1) @ y)


def loops(edges: list[tuple[int, int]]) -> list[list[int]]:
    """Vertices of the closed lines that `edges` make; none if they are not closed lines."""
    following = dict(edges)
    if len(following) < len(edges):
        return []
    found: list[list[int]] = []
    while following:
        start, vertex = following.popitem()
        loop = [start]
        while vertex != start:
            if vertex not in following:
                return []
            loop.append(vertex)
            vertex = following.pop(vertex)
        found.append(loop)
    return found


def _between(first: np.ndarray, second: np.ndarray) -> Panels | None:
    """Rings of panels between two closed lines (n, 3) around each other, normals down.

    None if they are not, or have different numbers of points.
    """
    if len(first) != len(second):
        return None
    second = second[::-1]  # the water is outside of the one and inside of the other
    second = np.roll(second, -int(np.argmin(np.linalg.norm(second - first[0], axis=1))), axis=0)
    edge = np.linalg.norm(np.roll(first, -1, axis=0) - first, axis=1).mean()
    count = max(2, math.ceil(np.linalg.norm(second - first, axis=1).mean() / (2.0 * edge)))
    fractions = np.linspace(0.0, 1.0, count + 1)[:, None, None]
    closed = [np.concatenate([line, line[:1]]) for line in (first, second)]
    lid = grid(closed[0] + fractions * (closed[1] - closed[0])).merged()
    upwards = lid.normals[:, 2]
    if np.all(upwards > 0):
        return lid.reversed
    return lid if np.all(upwards < 0) else None


def _rings(line: np.ndarray) -> Panels | None:
    """Rings of panels inside a closed line (n, 3) about its centre, normals down.

    None if some part of the line is not visible from there.
    """
    following = np.roll(line, -1, axis=0)
    doubled = line[:, 0] * following[:, 1] - line[:, 1] * following[:, 0]
    center = ((line + following) * doubled[:, None]).sum(axis=0) / (3 * doubled.sum())
    spokes = line - center
    turns = spokes[:, 0] * np.roll(spokes, -1, axis=0)[:, 1]
    turns -= spokes[:, 1] * np.roll(spokes, -1, axis=0)[:, 0]
    if not (np.all(turns > 0) or np.all(turns < 0)):
        return None
    edge = np.linalg.norm(following - line, axis=1).mean()
    count = max(2, math.ceil(np.linalg.norm(spokes, axis=1).mean() / (2.0 * edge)))
    closed = np.concatenate([spokes, spokes[:1]])
    if turns[0] < 0:
        closed = closed[::-1]
    fractions = np.linspace(0.0, 1.0, count + 1)
    return grid(center + fractions[None, :, None] * closed[:, None, :]).merged()
