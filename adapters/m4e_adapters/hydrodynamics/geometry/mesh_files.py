"""Mesh files: panels as they are drawn. Formats that only Capytaine knows are read by it."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.shapes import Part
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.geometry.mesh_formats import (
    gdf_panels,
    gmsh_panels,
    obj_panels,
    stl_panels,
)
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_fmi.errors import InputError, is_file, missing_file
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_MESH
from m4e_fmi.model.shapes.mesh_files import MeshFileError

FORMATS = (
    "formats: gdf (WAMIT), nemoh or dat (Nemoh), hst (Hydrostar), pnl (HAMS), msh (Gmsh), stl, "
    "obj; all of a mesh must be in one file"
)
READERS = {".stl": stl_panels, ".obj": obj_panels, ".msh": gmsh_panels}
BY_CAPYTAINE = (".nemoh", ".mar", ".hst", ".pnl")
_NEMOH = re.compile(rb"\s*2[ \t,]+[01]\s*\n")
"""First line of a mesh of Nemoh, whose files are mostly called .dat: 2, and 1 if it is half."""


def read_mesh(path: Path, *, scale: float = 1.0) -> Panels:
    """The panels [m] of a mesh file whose numbers, times `scale` [1], are lengths in m.

    Coincident vertices are made one, halves of symmetric files completed. The file is read as a
    copy, away from files beside it: they would not count as what the FMU is of.
    MeshFileError with the reason, where that is known: not in the words of a reader, which are
    of its arrays. OSError if the file cannot be read at all.
    """
    try:
        content = read_bytes(path, largest=LARGEST_MESH)
    except TooLongError as error:
        raise MeshFileError(f"it {error}") from None
    if not content.strip():
        raise MeshFileError("it is empty")
    panels = _drawn(path, content, scale)
    return Panels(scale * panels.vertices, panels.faces)


def _drawn(path: Path, content: bytes, scale: float) -> Panels:
    """The panels in units of the file."""
    kind = path.suffix.lower()
    if kind == ".dat":
        if not _NEMOH.match(content):
            text = "it is no mesh of Nemoh: its first line is not '2 0' or '2 1'"
            raise MeshFileError(text)
        kind = ".nemoh"
    if kind == ".gdf":
        return gdf_panels(content, scale=scale)
    if kind in READERS:
        return READERS[kind](content)
    if kind not in BY_CAPYTAINE:
        raise MeshFileError(f"the format {kind or 'without a suffix'} is not known")
    try:
        return _by_capytaine(kind, content)
    except Exception as error:  # readers of other programs' formats raise what they like
        raise MeshFileError(f"it is damaged, or not of the format {kind}") from error


def _by_capytaine(kind: str, content: bytes) -> Panels:
    """The panels that Capytaine finds in a file of that suffix and content."""
    capytaine = import_capytaine()
    with tempfile.TemporaryDirectory(prefix="m4e_fmi_") as alone:
        copy = Path(alone, f"mesh{kind}")
        copy.write_bytes(content)
        mesh = capytaine.load_mesh(copy).merged()
    return Panels(np.asarray(mesh.vertices), np.asarray(mesh.faces)).merged()


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
