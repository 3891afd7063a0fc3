"""Whole hulls: the wetted surface and what is above the water, in the reference pose."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config import Cylinder, Revolved, Shape, Sphere
from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.geometry.shapes import revolved_panels, sphere_panels
from m4e_adapters.hydrodynamics.geometry.unions.solids import (
    box_to,
    ends_are_known,
    raised,
    triangles_of,
    union_of,
)
from m4e_fmi.errors import InputError

BELOW = 2.0
"""Depth of a whole hull that is drawn under water, over its height."""


def whole_shape(shape: Shape, panels: int) -> Panels | None:
    """The closed surface of a built-in shape, of about so many `panels`.

    None for a mesh file, and for a box or cylinder without a `freeboard`.
    """
    if shape.sphere is not None:
        return _sphere(shape.sphere, panels)
    if shape.revolved is not None:
        return _revolved(shape.revolved, panels)
    if shape.box is not None and shape.box.freeboard is not None:
        return box_to(shape.box, shape.box.freeboard)
    if shape.cylinder is not None and shape.cylinder.freeboard is not None:
        return _cylinder(shape.cylinder, shape.cylinder.freeboard, panels)
    return None


def whole_union(name: str, shape: Shape, center: Place, folder: Path) -> Panels | None:
    """The closed surface of a union of shapes; its triangles are exact, and may be thin.

    None where a cylinder, box or mesh ends at the waterline.
    """
    if not ends_are_known(shape):
        return None
    try:
        solid = union_of(name, shape, center, folder, whole=True)
    except InputError:  # a mesh that is open at the waterline: the wetted hull has been made
        return None
    vertices, triangles = triangles_of(solid)
    return Panels(vertices, np.column_stack([triangles, triangles[:, 2]]))


def _sphere(shape: Sphere, panels: int) -> Panels:
    depth = BELOW * shape.radius
    below = shape.model_copy(update={"center_z": -depth})
    return raised(sphere_panels(below, panels), shape.center_z + depth)


def _revolved(shape: Revolved, panels: int) -> Panels:
    heights = [z for _, z in shape.profile]
    depth = max(heights) + BELOW * (max(heights) - min(heights))
    profile = tuple((radius, z - depth) for radius, z in shape.profile)
    return raised(revolved_panels(shape.model_copy(update={"profile": profile}), panels), depth)


def _cylinder(shape: Cylinder, freeboard: float, panels: int) -> Panels:
    profile = ((shape.radius, -shape.draft), (shape.radius, freeboard))
    x, y = shape.center_x, shape.center_y
    return _revolved(Revolved(profile=profile, center_x=x, center_y=y), panels)
