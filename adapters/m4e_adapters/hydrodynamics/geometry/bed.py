"""Bodies on the sea bed: panels that lie on it close the surface, and no water touches them."""

from __future__ import annotations

import math

import numpy as np

from m4e_adapters.hydrodynamics.geometry.lid import loops
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
    rims = [
        (low, high) if sides[0] > 0 else (high, low)
        for (low, high), sides in panels.edges().items()
        if len(sides) == 1 and at_bed[low] and at_bed[high]
    ]
    faces = [panels.faces]
    for loop in loops(rims):
        middle = len(vertices)
        vertices = np.concatenate([vertices, vertices[loop].mean(axis=0, keepdims=True)])
        edges = zip(loop, [*loop[1:], loop[0]], strict=True)
        faces.append(np.array([[b, a, middle, middle] for a, b in edges]))
    return Panels(vertices, np.concatenate(faces)).merged()


def off_the_bed(panels: Panels, depth: float) -> tuple[Panels, Panels | None]:
    """The panels of a closed surface that the water touches, and those at z = −`depth` [m]."""
    below = np.all(panels.corners[:, :, 2] == -depth, axis=1)
    if not below.any():
        return panels, None
    return panels.selected(~below), panels.selected(below)
