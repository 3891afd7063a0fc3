"""Triangles of mesh files: STL, binary or ASCII, and OBJ."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_MESH

Triangles = NDArray[np.float64]
"""(T, 3, 3) [m]: triangle, corner, x y z; the order of the corners is that of the file."""

_HEADER, _FACET = 84, np.dtype([("numbers", "<f4", 12), ("attribute", "<u2")])


class MeshFileError(ValueError):
    """A mesh file cannot be read; the text tells why."""


def read_triangles(path: Path) -> Triangles:
    """The triangles (T, 3, 3) [m] of a file; MeshFileError with the reason, or OSError."""
    kind = path.suffix.lower()
    if kind not in READERS:
        known = " and ".join(READERS)
        raise MeshFileError(f"the format {kind or 'without a suffix'} is not one of {known}")
    try:
        content = read_bytes(path, largest=LARGEST_MESH)
    except TooLongError as error:
        raise MeshFileError(f"it {error}") from None
    found = READERS[kind](content)
    if not len(found):
        raise MeshFileError("it has no triangles")
    return found


def stl_triangles(content: bytes) -> Triangles:
    """The triangles (T, 3, 3) [m] of an STL file. MeshFileError.

    A binary file is known by its length, 84 + 50 n bytes: many begin with "solid", too.
    """
    count = int.from_bytes(content[80:_HEADER], "little")
    if len(content) >= _HEADER and len(content) == _HEADER + count * _FACET.itemsize:
        facets = np.frombuffer(content, _FACET, offset=_HEADER)["numbers"]
        corners = facets.reshape(-1, 4, 3)[:, 1:]  # the first is the normal
        return _finite(corners.astype(float))
    words = content.decode("ascii", "replace").split()
    if words[:1] != ["solid"] or b"\0" in content:
        raise MeshFileError("neither an ASCII nor a whole binary STL file")
    at = [k for k, word in enumerate(words) if word == "vertex"]
    try:
        return _finite(np.array([words[k + 1 : k + 4] for k in at], float).reshape(-1, 3, 3))
    except ValueError:
        raise MeshFileError("a vertex has no three numbers, or a facet no three vertices") from None


def obj_triangles(content: bytes) -> Triangles:
    """The triangles (T, 3, 3) [m] of an OBJ file; faces of more corners are cut. MeshFileError."""
    vertices, polygons = obj_polygons(content)
    faces = [(first, a, b) for first, *rest in polygons for a, b in pairwise(rest)]
    return vertices[np.array(faces, int).reshape(-1, 3)]


def obj_polygons(content: bytes) -> tuple[NDArray[np.float64], list[tuple[int, ...]]]:
    """The vertices (n, 3) [m] of an OBJ file, and the corners of each face. MeshFileError."""
    vertices: list[list[float]] = []
    polygons: list[tuple[int, ...]] = []
    for number, line in enumerate(content.decode("utf-8", "replace").splitlines(), start=1):
        key, *words = line.split() or [""]
        try:
            if key == "v":
                x, y, z = map(float, words[:3])
                vertices.append([x, y, z])
            elif key == "f":
                polygons.append(tuple(_corner(word, len(vertices)) for word in words))
        except ValueError:
            message = f"line {number} is neither a vertex nor a face: {line[:40]!r}"
            raise MeshFileError(message) from None
    return _finite(np.array(vertices, float).reshape(-1, 3)), polygons


def _corner(word: str, count: int) -> int:
    """Index of a vertex, of those read so far, from ``7``, ``7/1/2`` or ``-1``; ValueError."""
    given = int(word.partition("/")[0])
    index = given - 1 if given > 0 else count + given
    if given == 0 or not 0 <= index < count:
        raise ValueError(word)
    return index


def _finite(coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
    if not np.all(np.isfinite(coordinates)):
        raise MeshFileError("coordinates that are not finite")
    return coordinates


READERS = {".stl": stl_triangles, ".obj": obj_triangles}


def reduced(triangles: Triangles, most: int) -> Triangles:
    """At most `most` triangles (T, 3, 3) [m] of about the same surface.

    Corners that lie in the same cell of a grid become one, in their mean.
    """
    corners = triangles.reshape(-1, 3)
    low, size = corners.min(axis=0), np.ptp(corners, axis=0).max() or 1.0
    cells = float(most) ** 0.5
    while len(triangles) > most:
        grid = np.floor((corners - low) / size * cells).astype(np.int64)
        _, cell = np.unique(grid @ [1, 1 << 20, 1 << 40], return_inverse=True)
        means = np.stack([np.bincount(cell, corners[:, c]) for c in range(3)], axis=1)
        means /= np.bincount(cell)[:, None]
        faces = np.unique(np.sort(cell.reshape(-1, 3), axis=1), axis=0)
        flat = (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2])
        triangles = means[faces[~flat]]
        cells *= 0.8
    return triangles
