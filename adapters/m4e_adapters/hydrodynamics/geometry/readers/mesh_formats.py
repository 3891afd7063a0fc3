"""Panels in the content of mesh files: WAMIT, STL, OBJ. MeshFileError tells what is wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from m4e_adapters.hydrodynamics.geometry.panels import Panels, joined
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
