"""Surfaces of bodies for pictures: whole shapes in few polygons, mesh files as they are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config.component import Placed
from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.shapes import Part
from m4e_adapters.hydrodynamics.geometry.mesh_files import drawn_panels
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_fmi.model.shapes import reduced
from m4e_fmi.report.animation.shown import ShownHull
from m4e_fmi.report.drawing.hulls import CORNERS, SIDES, Hull, turned_hull

DOWN = 8
"""Rows of polygons of a ball."""
MOST_TRIANGLES = 2000
"""Of all meshes of a component."""


def drawn_hulls(bodies: Mapping[str, Placed], folder: Path) -> tuple[ShownHull, ...]:
    """The surfaces of `bodies`, whose mesh files are in `folder`, in the axes of each.

    Those of `fixed` bodies are in world axes; bodies without a shape are left out. InputError for
    mesh files that cannot be read.
    """
    shaped = {name: body for name, body in bodies.items() if body.shape.kind}
    meshes = sum(part.mesh is not None for body in shaped.values() for part in body.shape.parts)
    most = MOST_TRIANGLES // max(1, meshes)
    found: list[ShownHull] = []
    for name, body in shaped.items():
        fixed = bool(getattr(body, "fixed", False))
        hull = _surface(name, body, folder, most)
        center = np.zeros(3) if fixed else np.array(point_in_space(body.center_of_gravity))
        found.append(ShownHull(name, Hull(hull.vertices - center, hull.faces, hull.edged), fixed))
    return tuple(found)


def _surface(name: str, body: Placed, folder: Path, most: int) -> Hull:
    """The surface of a body in the reference pose; of a union the surfaces of its parts."""
    hulls = [_part(name, part, body.center_of_gravity, folder, most) for part in body.shape.parts]
    if len(hulls) == 1:
        return hulls[0]
    first, faces = 0, list[tuple[int, ...]]()
    for hull in hulls:
        faces += [tuple(first + k for k in face) for face in hull.faces]
        first += len(hull.vertices)
    return Hull(np.concatenate([hull.vertices for hull in hulls]), tuple(faces), edged=False)


def _part(name: str, shape: Part, center: Place, folder: Path, most: int) -> Hull:
    """The surface of a shape that is no union."""
    if shape.mesh is not None:
        panels = drawn_panels(name, shape, center, folder)
        corners = panels.corners
        upper = corners[panels.faces[:, 2] != panels.faces[:, 3]]
        triangles = np.concatenate([corners[:, [0, 1, 2]], upper[:, [0, 2, 3]]])
        points, index = np.unique(
            reduced(triangles, most).reshape(-1, 3), axis=0, return_inverse=True
        )
        return Hull(points, tuple(map(tuple, index.reshape(-1, 3).tolist())), edged=False)
    return _built_in(shape)


def _built_in(shape: Part) -> Hull:
    """A built-in shape, up to its deck where that is given, else to the still water."""
    if (one := shape.box) is not None:
        low, high = -one.draft, one.freeboard or one.top_z
        half = np.array([one.length, one.width, high - low]) / 2
        return Hull(
            np.array([one.center_x, one.center_y, (low + high) / 2]) + CORNERS * half, SIDES
        )
    if (one := shape.horizontal_cylinder) is not None:
        rims = np.array([[one.radius, -one.length / 2], [one.radius, one.length / 2]])
        axis = (1.0, 0.0, 0.0) if one.axis == "x" else (0.0, 1.0, 0.0)
        return turned_hull(rims, np.array([one.center_x, one.center_y, one.center_z]), axis)
    if (one := shape.sphere) is not None:
        angles = np.linspace(0.0, np.pi, DOWN + 1)
        profile = one.radius * np.stack([np.sin(angles), -np.cos(angles)], axis=1)
        return turned_hull(profile, np.array([one.center_x, one.center_y, one.center_z]))
    if (one := shape.revolved) is not None:
        return turned_hull(np.array(one.profile), np.array([one.center_x, one.center_y, 0.0]))
    one = shape.cylinder
    assert one is not None
    rims = np.array([[one.radius, -one.draft], [one.radius, one.freeboard or one.top_z]])
    return turned_hull(rims, np.array([one.center_x, one.center_y, 0.0]))
