"""A seabed that is not flat: its depth on a grid, and MoorDyn's file of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.csv_columns import column_names, read_columns

FILE = "bathymetry.txt"
"""Name of MoorDyn's file, beside its input."""


@dataclass(frozen=True)
class Bathymetry:
    """Depth (m, n) [m] of the seabed where `x` (m,) and `y` (n,) [m] of a grid cross, ascending.

    Bilinear within the cells, constant beyond the grid.
    """

    x: np.ndarray
    y: np.ndarray
    depth: np.ndarray

    def at(self, x: float, y: float) -> float:
        """Depth [m] at a place [m]."""
        return float(np.interp(y, self.y, [np.interp(x, self.x, row) for row in self.depth.T]))

    @property
    def file(self) -> bytes:
        """MoorDyn's file: numbers and places of the grid's lines, then z at each crossing."""
        x, y = self.x.tolist(), self.y.tolist()
        lines = [[len(x), len(y)], x, y]
        lines += [[a, b, -self.at(a, b)] for a in x for b in y]
        return "".join(f"{' '.join(map(repr, line))}\n" for line in lines).encode()


def bathymetry(given: str | list[tuple[float, ...]], *, folder: Path) -> Bathymetry:
    """The seabed of rows (x, depth) or (x, y, depth) [m], or of a CSV file with such columns.

    InputError if the rows are not those of a grid, each crossing once.
    """
    if isinstance(given, str):
        axes = ["x", "y"] if "y" in column_names(folder / given) else ["x"]
        columns = read_columns(folder / given, [(name, "m") for name in (*axes, "depth")])
        rows = list(zip(*columns.values, strict=True))
    else:
        rows = given
    if {len(row) for row in rows} == {2}:  # the same for all y
        rows = [(row[0], y, row[1]) for row in rows for y in (-1.0, 1.0)]
    found = {row[:2]: row[2] for row in rows if len(row) == 3}
    x, y = (sorted({place[k] for place in found}) for k in (0, 1))
    if len(found) < len(rows) or len(found) != len(x) * len(y) or min(len(x), len(y)) < 2:
        text = f"the {len(rows)} rows of the bathymetry are not those of a grid"
        remedy = "write [x, depth], or [x, y, depth] once for each x with each y, two of both"
        raise InputError([Problem(text, remedy, keys=("seabed", "bathymetry"))])
    depth = np.array([[found[a, b] for b in y] for a in x])
    return Bathymetry(np.array(x), np.array(y), depth)
