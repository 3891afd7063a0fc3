"""Mesh files: panels as they are drawn. Formats that only Capytaine knows are read by it."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

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
_HEADER = 4
"""Lines of a WAMIT file before its coordinates; the last begins with the number of panels."""
_NUMBERS = 12
"""Of each panel."""
_FEET = (32.0, 32.4)
"""Gravities [ft/s2] of files in feet."""


def gdf_panels(content: bytes, *, scale: float) -> Panels:
    """The panels of a WAMIT file, in its units; halves and quarters are completed.

    ISX and ISY tell the planes of symmetry x = 0 and y = 0. ULEN only makes WAMIT's results
    dimensionless. Lengths in feet, known by the gravity, are refused if the `scale` [1] is 1.
    """
    lines = content.decode(errors="replace").splitlines()
    _, gravity = _header(lines, 2, "length and gravity")
    planes = _header(lines, 3, "symmetries ISX and ISY")
    if _FEET[0] < gravity < _FEET[1] and scale == 1.0:
        text = f"line 2: a gravity of {gravity:g} is that of lengths in feet: add 'scale: {FOOT}'"
        raise MeshFileError(text)
    if not set(planes) <= {0.0, 1.0}:
        told = " ".join(f"{plane:g}" for plane in planes)
        raise MeshFileError(f"line 3: ISX and ISY are {told}, known are 0 and 1")
    corners = _coordinates(lines).reshape(-1, 3)
    panels = Panels(corners, np.arange(len(corners)).reshape(-1, 4)).merged()
    for axis in (0, 1):
        if planes[axis]:
            panels = joined(panels, panels.mirrored(axis))
    return panels


def _header(lines: Sequence[str], line: int, names: str) -> tuple[float, float]:
    """The two numbers with which a line of the header begins."""
    try:
        first, second = map(_number, lines[line - 1].split()[:2])
    except (IndexError, ValueError):
        raise MeshFileError(f"line {line} does not begin with {names}") from None
    return first, second


def _coordinates(lines: Sequence[str]) -> np.ndarray:
    """All coordinates, (12 nf,), in units of the file."""
    words = lines[_HEADER - 1].split() if len(lines) >= _HEADER else []
    if not words or not words[0].isdecimal():
        raise MeshFileError(f"line {_HEADER} does not begin with the number of panels")
    wanted = _NUMBERS * int(words[0])
    found: list[float] = []
    for number, line in enumerate(lines[_HEADER:], start=_HEADER + 1):
        for word in line.split()[: wanted - len(found)]:
            try:
                found.append(_number(word))
            except ValueError:
                text = f"line {number}: {word[:20]!r} is not a finite number"
                raise MeshFileError(text) from None
    if len(found) < wanted:
        raise MeshFileError(
            f"it ends early: its {words[0]} panels have {wanted} coordinates, of which "
            f"{len(found)} are there"
        )
    return np.array(found)


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
    faces = np.array([*_of_four(polygons)], dtype=int).reshape(-1, 4)
    return Panels(vertices, faces).merged()


def _of_four(polygons: Sequence[tuple[int, ...]]) -> Iterator[tuple[int, ...]]:
    for face in polygons:
        if len(face) in (3, 4):
            yield (*face, face[-1])[:4]
        else:
            yield from ((face[0], a, b, b) for a, b in pairwise(face[1:]))


CORNERS = {2: 3, 3: 4, 9: 3, 10: 4, 16: 4}
"""Corners of each kind of surface element; the last three have nodes between them."""

Number = TypeVar("Number", int, float)
Row = tuple[int, list[str]]
"""A line's number and its words."""


def gmsh_panels(content: bytes) -> Panels:
    """The surface elements of a file; MeshFileError with the line where it is wrong."""
    text = content.decode(errors="replace")
    number, words = _section(text, "MeshFormat")[0]
    version, binary = (*words, "", "")[:2]
    if binary != "0":
        raise MeshFileError("it is a binary file: save it as ASCII (Mesh.Binary = 0)")
    if not (version.startswith("2") or version == "4.1"):
        text = f"line {number}: version {version} is none of 2 and 4.1 (Mesh.MshFileVersion)"
        raise MeshFileError(text)
    blocks = version == "4.1"
    tags, vertices = _nodes(_section(text, "Nodes"), blocks=blocks)
    places = {tag: k for k, tag in enumerate(tags)}
    faces = [
        [places[tag] for tag in corners]
        for corners in _elements(_section(text, "Elements"), set(places), blocks=blocks)
    ]
    return Panels(vertices, np.array([[*f, f[-1]][:4] for f in faces], int).reshape(-1, 4)).merged()


def _section(text: str, name: str) -> list[Row]:
    """The lines between ``$name`` and ``$Endname``."""
    found: list[Row] | None = None
    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip() == f"${name}":
            found = []
        elif line.strip() == f"$End{name}" and found:
            return found
        elif found is not None and line.strip():
            found.append((number, line.split()))
    state = "has no" if found is None else "ends within"
    raise MeshFileError(f"it {state} section ${name}")


def _nodes(rows: Sequence[Row], *, blocks: bool) -> tuple[list[int], np.ndarray]:
    """The tags of all nodes, and their places (n, 3) [m], of a file in m."""
    tags: list[int] = []
    places: list[list[float]] = []
    for head, block in _blocks(rows, lines_of_each=2) if blocks else [(rows[0], rows[1:])]:
        count = int(head[1][3]) if blocks else len(block)
        for number, words in block[:count] if blocks else block:
            tags.append(_numbers(number, words, int, 1)[0])
        for number, words in block[count:] if blocks else block:
            places.append(_numbers(number, words if blocks else words[1:], float, 3))
    vertices = np.array(places, dtype=float).reshape(-1, 3)
    if not np.all(np.isfinite(vertices)):
        raise MeshFileError("coordinates that are not finite")
    return tags, vertices


def _elements(rows: Sequence[Row], known: set[int], *, blocks: bool) -> Iterator[list[int]]:
    """The tags of the corners of each surface element."""
    if blocks:
        listed = [
            (number, int(head[1][2]), words[1:])
            for head, block in _blocks(rows, lines_of_each=1)
            for number, words in block
        ]
    else:
        listed = []
        for number, words in rows[1:]:
            _, kind, count = _numbers(number, words, int, 3)
            listed.append((number, kind, words[3 + count :]))
    for number, kind, words in listed:
        if kind in CORNERS:
            corners = _numbers(number, words, int, CORNERS[kind])
            if (unknown := set(corners) - known) != set():
                raise MeshFileError(f"line {number}: there is no node {min(unknown)}")
            yield corners


def _blocks(rows: Sequence[Row], *, lines_of_each: int) -> Iterator[tuple[Row, Sequence[Row]]]:
    """Heads and lines of the blocks of a section, with so many lines for each thing in it."""
    at = 1
    for _ in range(_numbers(*rows[0], int, 1)[0]):
        if at >= len(rows):
            raise MeshFileError(f"line {rows[-1][0]}: a block is missing here")
        head = rows[at]
        count = lines_of_each * _numbers(*head, int, 4)[3]
        block = rows[at + 1 : at + 1 + count]
        if len(block) < count:
            raise MeshFileError(f"line {head[0]}: the block ends early")
        yield head, block
        at += 1 + count


def _numbers(number: int, words: Sequence[str], kind: type[Number], count: int) -> list[Number]:
    """The first `count` words as numbers; MeshFileError with the line's `number`."""
    try:
        found = [kind(word) for word in words[:count]]
    except ValueError:
        found = []
    if len(found) < count:
        raise MeshFileError(f"line {number}: not {count} numbers")
    return found


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
