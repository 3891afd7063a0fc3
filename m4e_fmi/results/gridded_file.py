"""Numbers over dimensions other than time alone (netCDF): responses to waves, studies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.errors import InputError, is_file
from m4e_fmi.results.row_file import check_size
from m4e_fmi.shown import listing
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    from netCDF4 import Dataset, Variable

_HDF5 = b"\x89HDF"


@dataclass(frozen=True)
class Grid:
    """`values` of a variable over its `dimensions`, in `unit`; nan where there are none."""

    name: str
    unit: str
    dimensions: tuple[str, ...]
    values: np.ndarray = field(repr=False)


@dataclass(frozen=True)
class GriddedFile:
    """Variables by name, and the values of dimensions that have any."""

    path: Path
    grids: Mapping[str, Grid]
    coordinates: Mapping[str, np.ndarray] = field(repr=False)

    def __repr__(self) -> str:
        return listing(f"GriddedFile of {str(self.path)!r}", variables=tuple(self.grids))


def is_gridded(path: Path) -> bool:
    """True for a netCDF-4 file with a variable that is not over time alone."""
    return any(dimensions != ("time",) for dimensions in dimensions_of(path).values())


def dimensions_of(path: Path) -> dict[str, tuple[str, ...]]:
    """Dimensions of all variables of a netCDF-4 file, by name as in `GriddedFile`.

    Empty for any other file, and for one that cannot be read.
    """
    if not is_file(path):
        return {}
    with path.open("rb") as file:
        if file.read(len(_HDF5)) != _HDF5:
            return {}
    try:
        from netCDF4 import Dataset

        with PROCESS, Dataset(path) as file:
            return {
                prefix + name: variable.dimensions
                for prefix, group in _groups(file).items()
                for name, variable in group.variables.items()
            }
    except (OSError, RuntimeError):
        return {}


def read_gridded(path: Path) -> GriddedFile:
    """All variables of a netCDF-4 file that are numbers; those of groups as ``group.name``.

    InputError for a damaged file.
    """
    from netCDF4 import Dataset

    try:
        with PROCESS, Dataset(path) as file:
            grids, coordinates = dict[str, Grid](), dict[str, np.ndarray]()
            for prefix, group in _groups(file).items():
                for name, variable in group.variables.items():
                    check_size(path, variable.size, 1)
                    values = _numbers(variable)
                    if variable.dimensions == (name,):
                        coordinates.setdefault(name, values)
                    elif values.dtype.kind == "f":
                        unit = str(getattr(variable, "units", "1"))
                        grids[prefix + name] = Grid(
                            prefix + name, unit, variable.dimensions, values
                        )
    except (OSError, RuntimeError) as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
    return GriddedFile(path, grids, coordinates)


def _groups(file: Dataset) -> dict[str, Dataset]:
    """The file and its groups, by what is before the names of their variables."""
    return {"": file, **{f"{name}.": group for name, group in file.groups.items()}}


def _numbers(variable: Variable) -> np.ndarray:
    """Numbers as floats, nan where the file has none; texts as they are."""
    values = np.ma.asarray(variable[...])
    return np.ma.filled(values.astype(float), np.nan) if values.dtype.kind in "fiub" else values
