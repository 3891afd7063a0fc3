"""Shapes of bodies in space, for pictures only: they change no motion.

`shape` has the elements and their checks, `mesh_files` reads triangles.
"""

from m4e_fmi.model.shapes.mesh_files import reduced
from m4e_fmi.model.shapes.shape import (
    MOST_TRIANGLES,
    Box,
    Cylinder,
    Mesh,
    Shape,
    Sphere,
    axis_without_direction,
    shape_findings,
    shape_place,
)

__all__ = [
    "MOST_TRIANGLES",
    "Box",
    "Cylinder",
    "Mesh",
    "Shape",
    "Sphere",
    "axis_without_direction",
    "reduced",
    "shape_findings",
    "shape_place",
]
