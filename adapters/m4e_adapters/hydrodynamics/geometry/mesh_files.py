"""Mesh files: panels as they are drawn. Formats that only Capytaine knows are read by it."""

from __future__ import annotations

import io
import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.config.numbers import Place
from m4e_adapters.hydrodynamics.config.shapes import Part
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import Panels, joined
from m4e_fmi.errors import InputError, is_file, missing_file
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_MESH
from m4e_fmi.model.shapes.mesh_files import MeshFileError, obj_polygons, stl_triangles

FOOT = 0.3048  # m
_FEET = (32.0, 32.4)
"""Gravities [ft/s2] of files in feet."""


def gdf_panels(content: bytes, *, scale: float) -> Panels:
    """The panels of a WAMIT file, in its units; halves and quarters are completed.

    ISX and ISY tell the planes of symmetry x = 0 and y = 0. ULEN only makes WAMIT's results
    dimensionless. Lengths in feet, known by the gravity, are refused if the `scale` [1] is 1.
    """
    lines = content.decode(errors="replace").splitlines()
    try:
        gravity, planes = _number(lines[1].split()[1]), [int(w) for w in lines[2].split()[:2]]
        count = int(lines[3].split()[0])
    except (IndexError, ValueError):
        text = "lines 2 to 4 do not begin with length and gravity, ISX and ISY, number of panels"
        raise MeshFileError(text) from None
    if _FEET[0] < gravity < _FEET[1] and scale == 1.0:
        text = f"line 2: a gravity of {gravity:g} is that of lengths in feet: add 'scale: {FOOT}'"
        raise MeshFileError(text)
    if len(planes) < 2 or not set(planes) <= {0, 1}:
        raise MeshFileError(f"line 3: ISX and ISY are {lines[2].strip()}, known are 0 and 1")
    found: list[float] = []
    for number, line in enumerate(lines[4:], start=5):
        for word in line.split()[: 12 * count - len(found)]:
            try:
                found.append(_number(word))
            except ValueError:
                text = f"line {number}: {word[:20]!r} is not a finite number"
                raise MeshFileError(text) from None
    if len(found) < 12 * count:
        raise MeshFileError(f"it ends early: {count} panels have {12 * count} coordinates")
    corners = np.array(found).reshape(-1, 3)
    panels = Panels(corners, np.arange(len(corners)).reshape(-1, 4)).merged()
    for axis in (0, 1):
        if planes[axis]:
            panels = joined(panels, panels.mirrored(axis))
    return panels


def _number(word: str) -> float:
    """A finite number, also with an exponent of Fortran; ValueError."""
    value = float(word.upper().replace("D", "E"))
    if not math.isfinite(value):
        raise ValueError(word)
    return value


def stl_panels(content: bytes) -> Panels:
    """The triangles of an STL file, binary or ASCII; the order of their corners is kept."""
    corners = stl_triangles(content).reshape(-1, 3)
    index = np.arange(len(corners)).reshape(-1, 3)
    return Panels(corners, index[:, [0, 1, 2, 2]]).merged()


def obj_panels(content: bytes) -> Panels:
    """The faces of an OBJ file; those of more than four corners are cut into triangles."""
    vertices, polygons = obj_polygons(content)
    faces: list[tuple[int, ...]] = []
    for face in polygons:
        if len(face) in (3, 4):
            faces.append((*face, face[-1])[:4])
        else:
            faces += [(face[0], a, b, b) for a, b in pairwise(face[1:])]
    return Panels(vertices, np.array(faces, dtype=int).reshape(-1, 4)).merged()


FORMATS = (
    "formats: gdf (WAMIT), nemoh or dat (Nemoh), hst (Hydrostar), pnl (HAMS), stl, obj (Gmsh "
    "exports both); all of a mesh must be in one file"
)
READERS = {".stl": stl_panels, ".obj": obj_panels}
BY_CAPYTAINE = {".nemoh": "nemoh", ".dat": "nemoh", ".mar": "mar", ".hst": "hst", ".pnl": "pnl"}
_NEMOH = re.compile(rb"\s*2[ \t,]+[01]\s*\n")
"""First line of a mesh of Nemoh, whose files are mostly called .dat: 2, and 1 if it is half."""


def read_mesh(path: Path, *, scale: float = 1.0) -> Panels:
    """The panels [m] of a mesh file whose numbers, times `scale` [1], are lengths in m.

    Coincident vertices are made one, halves of symmetric files completed. MeshFileError with the
    reason, where that is known: not in the words of a reader, which are of its arrays. OSError if
    the file cannot be read at all.
    """
    try:
        content = read_bytes(path, largest=LARGEST_MESH)
    except TooLongError as error:
        raise MeshFileError(f"it {error}") from None
    if not content.strip():
        raise MeshFileError("it is empty")
    kind = path.suffix.lower()
    if kind == ".dat" and not _NEMOH.match(content):
        raise MeshFileError("it is no mesh of Nemoh: its first line is not '2 0' or '2 1'")
    if kind == ".gdf":
        panels = gdf_panels(content, scale=scale)
    elif kind in READERS:
        panels = READERS[kind](content)
    elif kind in BY_CAPYTAINE:
        kind = BY_CAPYTAINE[kind]
        capytaine, text = import_capytaine(), io.StringIO(content.decode(errors="replace"))
        try:
            mesh = capytaine.load_mesh(text, file_format=kind).merged()
        except Exception as error:  # readers of other programs' formats raise what they like
            raise MeshFileError(f"it is damaged, or not of the format {kind}") from error
        panels = Panels(np.asarray(mesh.vertices), np.asarray(mesh.faces)).merged()
    else:
        raise MeshFileError(f"the format {kind or 'without a suffix'} is not known")
    return Panels(scale * panels.vertices, panels.faces)


Keys = tuple[str | int, ...]
"""The way to a value in a HydrodynamicsConfig."""


def drawn_panels(
    name: str, shape: Part, center: Place, folder: Path, *, keys: Keys | None = None
) -> Panels:
    """The panels of a mesh file as they are drawn, of a body with this `center` of gravity [m].

    They are in the reference pose. `keys` lead to the file's name.
    """
    keys = ("bodies", name, "shape", "mesh") if keys is None else keys
    path = folder / str(shape.mesh)
    if not is_file(path):
        message, remedy = missing_file(path, "mesh file")
        where = "the name is relative to the system file's folder"
        remedy = "; ".join(filter(None, (where, remedy)))
        raise InputError.single(f"body {name!r}: {message}", remedy, keys=keys)
    try:
        drawn = read_mesh(path, scale=shape.scale)
    except (MeshFileError, OSError) as error:
        message = f"body {name!r}: the mesh cannot be read: {error}"
        raise InputError.single(message, FORMATS, str(path), keys=keys) from None
    if not len(drawn.faces):
        message = f"body {name!r}: the mesh has no panels"
        raise InputError.single(message, FORMATS, str(path), keys=keys)
    origin = np.array(point_in_space(shape.mesh_origin or (0.0, 0.0)))
    if shape.frame == "body":
        origin += point_in_space(center or (0.0, 0.0))
    return Panels(drawn.vertices + origin, drawn.faces)
