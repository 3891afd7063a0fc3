"""Mesh files in the reference pose: read, scaled and put in their place."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.shapes import Part
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.geometry.readers.mesh_files import FORMATS, read_mesh
from m4e_fmi.errors import InputError, is_file, missing_file
from m4e_fmi.model.shapes.mesh_files import MeshFileError

Keys = tuple[str | int, ...]
"""The way to a value in a HydrodynamicsConfig."""


def drawn_panels(
    name: str, shape: Part, center: Place, folder: Path, *, keys: Keys | None = None
) -> Panels:
    """The panels of a mesh file as they are drawn, of a body with this `center` of gravity [m].

    They are in the reference pose. `keys` lead to the file's name.
    """
    drawn = _loaded(
        folder / str(shape.mesh),
        name,
        ("bodies", name, "shape", "mesh") if keys is None else keys,
        scale=shape.scale,
    )
    origin = np.array(point_in_space(shape.mesh_origin or (0.0, 0.0)))
    if shape.frame == "body":
        origin += point_in_space(center or (0.0, 0.0))
    return Panels(drawn.vertices + origin, drawn.faces)


def _loaded(path: Path, name: str, keys: Keys = (), *, scale: float = 1.0) -> Panels:
    """The panels of a mesh file as they are drawn."""
    if not is_file(path):
        message, remedy = missing_file(path, "mesh file")
        message = f"body {name!r}: {message}"
        remedy = "; ".join(
            filter(None, ("the name is relative to the system file's folder", remedy))
        )
        raise InputError.single(message, remedy, keys=keys)
    try:
        panels = read_mesh(path, scale=scale)
    except (MeshFileError, OSError) as error:
        message = f"body {name!r}: the mesh cannot be read: {error}"
        raise InputError.single(message, FORMATS, str(path), keys=keys) from None
    if not len(panels.faces):
        message = f"body {name!r}: the mesh has no panels"
        raise InputError.single(message, FORMATS, str(path), keys=keys)
    return panels
