"""Box, cylinder, sphere and mesh: the form in which a body is drawn.

All lengths in m, places from the body's centre of gravity in body axes, in the pose q = 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, TypeAlias

from m4e_fmi.errors import InputError, is_file, missing_file
from m4e_fmi.model.quantity import Quantity, Vector, given
from m4e_fmi.model.shapes.mesh_files import MeshFileError, Triangles, read_triangles, reduced

MOST_TRIANGLES = 5000
"""Of all meshes of a model together. A browser without a graphics card paints these in 25 ms."""
ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Box:
    """A box: `length` [m] along X, `width` along Y, `height` along Z, its middle at `center`."""

    length: Quantity = given("m", bound="positive")
    width: Quantity = given("m", bound="positive")
    height: Quantity = given("m", bound="positive")
    center: Vector = given("m", ORIGIN, is_vector=True)

    keys: ClassVar = ("box",)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder of `radius` [m] and `height` [m] along `axis`, its middle at `center` [m].

    The length of the axis does not matter.
    """

    radius: Quantity = given("m", bound="positive")
    height: Quantity = given("m", bound="positive")
    axis: Vector = given("", (0.0, 0.0, 1.0), is_vector=True)
    center: Vector = given("m", ORIGIN, is_vector=True)

    keys: ClassVar = ("cylinder",)


@dataclass(frozen=True)
class Sphere:
    """A sphere of `radius` [m] about `center` [m]."""

    radius: Quantity = given("m", bound="positive")
    center: Vector = given("m", ORIGIN, is_vector=True)

    keys: ClassVar = ("sphere",)


@dataclass(frozen=True)
class Mesh:
    """The surface in an STL or OBJ `file`, in m; its origin lies at `mesh_origin` [m].

    `triangles` (T, 3, 3) [m] are those of the file, at most MOST_TRIANGLES: a finer mesh is made
    coarser. InputError if the file cannot be read.
    """

    file: str | Path
    mesh_origin: Vector = given("m", ORIGIN, is_vector=True)
    triangles: Triangles = field(init=False, repr=False, compare=False)

    keys: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        path = Path(self.file)
        if not is_file(path):
            raise InputError.single(*missing_file(path, "mesh file"))
        try:
            triangles = reduced(read_triangles(path), MOST_TRIANGLES)
        except (MeshFileError, OSError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            message = f"mesh file {path.name} cannot be read: {reason}"
            raise InputError.single(message, "give an STL or OBJ file with triangles") from None
        triangles.setflags(write=False)
        object.__setattr__(self, "triangles", triangles)


Shape: TypeAlias = "Box | Cylinder | Sphere | Mesh"
