"""Mesh files: panels as they are drawn. STL is read here, other formats by Capytaine."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.panels import Panels
from m4e_fmi.files_read import read_bytes

FORMATS = (
    "formats: gdf (WAMIT), nemoh, hst (Hydrostar), pnl (HAMS), stl; all of a mesh must be in one "
    "file"
)
_HEADER, _FACET = 84, np.dtype([("numbers", "<f4", 12), ("attribute", "<u2")])


def read_mesh(path: Path) -> Panels:
    """The panels of a mesh file, coincident vertices made one.

    It is read as a copy, away from files beside it: they would not count as what the FMU is of.
    Raises whatever a reader raises, ValueError for an STL file that is none.
    """
    content = read_bytes(path)
    if path.suffix.lower() == ".stl":
        return stl_panels(content)
    capytaine = import_capytaine()
    with tempfile.TemporaryDirectory(prefix="m4e_fmi_") as alone:
        copy = Path(alone, path.name)
        copy.write_bytes(content)
        mesh = capytaine.load_mesh(copy).merged()
    return Panels(np.asarray(mesh.vertices), np.asarray(mesh.faces)).merged()


def stl_panels(content: bytes) -> Panels:
    """The triangles of an STL file, binary or ASCII; the order of their corners is kept.

    A binary file is known by its length, 84 + 50 n bytes: many begin with "solid", too.
    """
    count = int.from_bytes(content[80:_HEADER], "little")
    if len(content) >= _HEADER and len(content) == _HEADER + count * _FACET.itemsize:
        facets = np.frombuffer(content, _FACET, offset=_HEADER)["numbers"]
        corners = facets.reshape(-1, 4, 3)[:, 1:]  # the first is the normal
    else:
        words = content.decode("ascii").split()
        if words[:1] != ["solid"]:
            raise ValueError("neither an ASCII nor a whole binary STL file")
        at = [k for k, word in enumerate(words) if word == "vertex"]
        corners = np.array([words[k + 1 : k + 4] for k in at], dtype=float).reshape(-1, 3, 3)
    if not np.all(np.isfinite(corners)):
        raise ValueError("coordinates that are not finite")
    index = np.arange(corners.size // 3).reshape(-1, 3)
    return Panels(corners.reshape(-1, 3).astype(float), index[:, [0, 1, 2, 2]]).merged()
