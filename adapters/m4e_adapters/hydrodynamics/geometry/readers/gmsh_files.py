"""Panels of Gmsh's files, version 2 or 4.1 in ASCII: its triangles and quadrilaterals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

import numpy as np

from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_fmi.model.shapes.mesh_files import MeshFileError

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
