"""Shapes of bodies in space, for pictures only: they change no motion.

`shape` has the elements, `mesh_files` reads triangles.
"""

from m4e_fmi.model.shapes.mesh_files import reduced
from m4e_fmi.model.shapes.shape import (
    MOST_TRIANGLES,
    Box,
    Cylinder,
    Mesh,
    Shape,
    Sphere,
)

__all__ = [
    "MOST_TRIANGLES",
    "Box",
    "Cylinder",
    "Mesh",
    "Shape",
    "Sphere",
    "reduced",
]
