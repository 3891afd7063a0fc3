"""Mesh files: panels as they are drawn. Formats that only Capytaine knows are read by it."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.geometry.readers.gmsh_files import gmsh_panels
from m4e_adapters.hydrodynamics.geometry.readers.mesh_formats import (
    gdf_panels,
    obj_panels,
    stl_panels,
)
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
