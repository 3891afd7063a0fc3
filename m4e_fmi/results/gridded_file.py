"""Numbers over dimensions other than time alone (netCDF): responses to waves, studies."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.errors import is_file
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    from netCDF4 import Dataset

_HDF5 = b"\x89HDF"


def is_gridded(path: Path) -> bool:
    """True for a netCDF-4 file with a variable that is not over time alone."""
    return any(dimensions != ("time",) for dimensions in dimensions_of(path).values())


def dimensions_of(path: Path) -> dict[str, tuple[str, ...]]:
    """Dimensions of all variables of a netCDF-4 file, by name; those of groups as ``group.name``.

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


def _groups(file: Dataset) -> dict[str, Dataset]:
    """The file and its groups, by what is before the names of their variables."""
    return {"": file, **{f"{name}.": group for name, group in file.groups.items()}}
