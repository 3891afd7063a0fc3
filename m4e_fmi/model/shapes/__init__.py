"""Shapes of bodies in space, for pictures only: they change no motion.

`shape` has the elements and their checks, `mesh_files` reads triangles.
"""

from m4e_fmi.model.shapes.shape import (
    Box,
    Cylinder,
    Mesh,
    Shape,
    Sphere,
    axis_without_direction,
    shape_findings,
    shape_quantities,
)

__all__ = [
    "Box",
    "Cylinder",
    "Mesh",
    "Shape",
    "Sphere",
    "axis_without_direction",
    "shape_findings",
    "shape_quantities",
]
