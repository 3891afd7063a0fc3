"""Panels as files of other programs, written independently of our readers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from m4e_adapters.hydrodynamics.geometry.panels import Panels


def gdf(panels: Panels, *, gravity: float = 9.81, isx: bool = False, isy: bool = False) -> str:
    """WAMIT."""
    lines = ["test", f"1.0 {gravity}", f"{int(isx)} {int(isy)}", str(len(panels.faces))]
    lines += [" ".join(f"{x:.9g}" for x in corner) for face in panels.corners for corner in face]
    return "\n".join(lines) + "\n"


def obj(panels: Panels) -> str:
    """Wavefront: quadrilaterals, and triangles where a corner is repeated."""
    lines = ["# a hull", *(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in panels.vertices), "vn 0 0 1"]
    lines += ["f " + " ".join(f"{k + 1}//1" for k in _distinct(face)) for face in panels.faces]
    return "\n".join(lines) + "\n"


def msh2(panels: Panels) -> str:
    """Gmsh 2.2, with a point and a line as Gmsh has them."""
    nodes = _numbered(panels)
    elements = ["1 15 2 0 1 1", "2 1 2 0 1 1 2"]
    for number, face in enumerate(panels.faces, 3):
        corners = _distinct(face)
        tags = " ".join(str(k + 1) for k in corners)
        elements.append(f"{number} {len(corners) - 1} 2 0 1 {tags}")
    return _sections(
        "2.2 0 8", [str(len(nodes)), *nodes], [str(len(elements)), *elements], other=True
    )


def msh4(panels: Panels) -> str:
    """Gmsh 4.1: nodes in two blocks, the second with parameters; elements in blocks by kind."""
    rows = [f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in panels.vertices]
    count, first = len(rows), len(rows) // 2
    nodes = [f"2 {count} 1 {count}", f"1 1 0 {first}", *map(str, range(1, first + 1))]
    nodes += [*rows[:first], f"2 1 1 {count - first}", *map(str, range(first + 1, count + 1))]
    nodes += [f"{row} 0.5 0.5" for row in rows[first:]]
    kinds = {kind: [f for f in panels.faces if len(_distinct(f)) == kind + 1] for kind in (2, 3)}
    elements = [f"{1 + sum(map(bool, kinds.values()))} {1 + len(panels.faces)} 1 999"]
    elements += ["1 1 1 1", "1 1 2"]
    number = 2
    for kind, faces in kinds.items():
        if faces:
            elements.append(f"2 1 {kind} {len(faces)}")
        for face in faces:
            elements.append(f"{number} {' '.join(str(k + 1) for k in _distinct(face))}")
            number += 1
    return _sections("4.1 0 8", nodes, elements)


def nemoh(panels: Panels) -> str:
    """Nemoh, without symmetry."""
    lines = ["2 0"]
    lines += _numbered(panels)
    lines += ["0 0 0 0", *(" ".join(str(k + 1) for k in face) for face in panels.faces), "0 0 0 0"]
    return "\n".join(lines) + "\n"


def hydrostar(panels: Panels) -> str:
    """Hydrostar, without symmetry."""
    lines = ["PROJECT: test", "SYMMETRY: 0", "COORDINATES"]
    lines += _numbered(panels)
    lines += ["ENDCOORDINATES", "PANEL TYPE 0"]
    lines += [" ".join(str(k + 1) for k in _distinct(face)) for face in panels.faces]
    return "\n".join([*lines, "ENDPANEL", "ENDFILE"]) + "\n"


def hams(panels: Panels) -> str:
    """HAMS, without symmetry."""
    lines = ["title", "", "# panels, nodes, symmetries"]
    lines += [f"{len(panels.faces)} {len(panels.vertices)} 0 0", "", "# nodes"]
    lines += _numbered(panels)
    lines += ["", "", "# panels"]
    for number, face in enumerate(panels.faces, 1):
        corners = _distinct(face)
        lines.append(f"{number} {len(corners)} {' '.join(str(k + 1) for k in corners)}")
    return "\n".join(lines) + "\n"


def stl(panels: Panels) -> str:
    """ASCII STL."""
    corners = "\n".join(
        "facet normal 0 0 0 outer loop "
        + " ".join("vertex " + " ".join(f"{x:.9g}" for x in p) for p in t)
        + " endloop endfacet"
        for t in _triangles(panels).tolist()
    )
    return f"solid hull\n{corners}\nendsolid hull\n"


def binary_stl(panels: Panels) -> bytes:
    """Binary STL that begins with "solid", as those of some programs do."""
    triangles = _triangles(panels).astype("<f4")
    facets = np.zeros((len(triangles), 50), dtype=np.uint8)
    facets[:, 12:48] = np.ascontiguousarray(triangles.reshape(-1, 9)).view(np.uint8)
    return b"solid hull".ljust(80) + len(triangles).to_bytes(4, "little") + facets.tobytes()


WRITERS: dict[str, Callable[[Panels], str | bytes]] = {
    "hull.gdf": gdf,
    "hull.obj": obj,
    "two.msh": msh2,
    "four.msh": msh4,
    "hull.nemoh": nemoh,
    "hull.dat": nemoh,
    "hull.hst": hydrostar,
    "hull.pnl": hams,
    "ascii.stl": stl,
    "binary.STL": binary_stl,
}
"""By the name of a file."""


def _triangles(panels: Panels) -> np.ndarray:
    """Those (n, 3, 3) [m] with an area."""
    triangles = panels.triangles
    return triangles[[len({tuple(p) for p in t}) == 3 for t in triangles.tolist()]]


def _numbered(panels: Panels) -> list[str]:
    return [f"{k} {x:.9g} {y:.9g} {z:.9g}" for k, (x, y, z) in enumerate(panels.vertices, 1)]


def _distinct(face: object) -> list[int]:
    return list(dict.fromkeys(map(int, face)))  # pyrefly: ignore[bad-argument-type]


def _sections(head: str, nodes: list[str], elements: list[str], *, other: bool = False) -> str:
    parts = ["$MeshFormat", head, "$EndMeshFormat"]
    if other:
        parts += ["$PhysicalNames", "1", '2 1 "hull"', "$EndPhysicalNames"]
    parts += ["$Nodes", *nodes, "$EndNodes", "$Elements", *elements, "$EndElements"]
    return "\n".join(parts) + "\n"
