"""Mesh files: panels as they are drawn. STL is read here, other formats by Capytaine."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_MESH
from m4e_fmi.model.shapes.mesh_files import MeshFileError, stl_triangles

FORMATS = (
    "formats: gdf (WAMIT), nemoh, hst (Hydrostar), pnl (HAMS), stl; all of a mesh must be in one "
    "file"
)
_GDF_HEADER = 4
"""Lines of a WAMIT file before its numbers; the last of them begins with the number of panels."""
_NUMBERS = 12
"""Of each panel."""
_UNKNOWN_FORMAT = "Unrecognized or unsupported mesh format"
"""How Capytaine begins, before it lists what other programs' formats there are."""


def read_mesh(path: Path) -> Panels:
    """The panels of a mesh file, coincident vertices made one.

    It is read as a copy, away from files beside it: they would not count as what the FMU is of.
    MeshFileError with the reason, where that is known: not in the words of a reader, which are
    of its arrays. OSError if the file cannot be read at all.
    """
    kind = path.suffix.lower()
    try:
        content = read_bytes(path, largest=LARGEST_MESH)
    except TooLongError as error:
        raise MeshFileError(f"it {error}") from None
    try:
        if kind == ".stl":
            return stl_panels(content)
        if kind == ".gdf":
            _check_gdf(content)
        return _by_capytaine(path, content)
    except (MeshFileError, OSError):
        raise
    except Exception as error:  # readers of a dozen formats raise what they like
        if str(error).startswith(_UNKNOWN_FORMAT):
            raise MeshFileError(f"the format {kind or 'without a suffix'} is not known") from None
        raise MeshFileError(f"it is damaged, or not of the format {kind}") from error


def _check_gdf(content: bytes) -> None:
    """MeshFileError for a WAMIT file that ends early, or has something else than numbers."""
    lines = content.decode(errors="replace").splitlines()
    words = lines[_GDF_HEADER - 1].split() if len(lines) >= _GDF_HEADER else []
    if not words or not words[0].isdecimal():
        raise MeshFileError(f"line {_GDF_HEADER} does not begin with the number of panels")
    wanted, found = _NUMBERS * int(words[0]), 0
    for number, line in enumerate(lines[_GDF_HEADER:], start=_GDF_HEADER + 1):
        for word in line.split()[: wanted - found]:
            try:
                finite = math.isfinite(float(word.replace("D", "E").replace("d", "e")))
            except ValueError:
                finite = False
            if not finite:
                raise MeshFileError(f"line {number}: {word[:20]!r} is not a finite number")
            found += 1
    if found < wanted:
        raise MeshFileError(
            f"it ends early: its {words[0]} panels have {wanted} coordinates, of which {found} are "
            "there"
        )


def _by_capytaine(path: Path, content: bytes) -> Panels:
    """The panels that Capytaine finds in a file of that name and content."""
    capytaine = import_capytaine()
    with tempfile.TemporaryDirectory(prefix="m4e_fmi_") as alone:
        copy = Path(alone, path.name)
        copy.write_bytes(content)
        mesh = capytaine.load_mesh(copy).merged()
    return Panels(np.asarray(mesh.vertices), np.asarray(mesh.faces)).merged()


def stl_panels(content: bytes) -> Panels:
    """The triangles of an STL file, binary or ASCII; the order of their corners is kept."""
    corners = stl_triangles(content).reshape(-1, 3)
    index = np.arange(len(corners)).reshape(-1, 3)
    return Panels(corners, index[:, [0, 1, 2, 2]]).merged()
