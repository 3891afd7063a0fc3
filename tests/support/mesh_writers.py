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
