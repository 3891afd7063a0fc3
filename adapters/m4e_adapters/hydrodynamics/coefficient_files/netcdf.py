"""netCDF and HDF5 files as trees of arrays, read from their bytes."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.file_data import refused
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_COEFFICIENTS
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    import netCDF4


@contextmanager
def opened_netcdf(path: Path) -> Generator[Tree]:
    """The content of a file; InputError if it cannot be read."""
    import netCDF4

    try:
        content = read_bytes(path, largest=LARGEST_COEFFICIENTS)
    except (TooLongError, OSError) as error:
        raise refused(f"{path} cannot be read: {error}") from None
    with PROCESS:
        try:
            file = netCDF4.Dataset(path.name, memory=content)
        except OSError:
            text = f"{path} is damaged or cut off, or neither netCDF nor HDF5"
            raise refused(text, "copy it again, or write it anew") from None
        try:
            yield Tree(path, file)
        finally:
            file.close()


class Tree:
    """Variables of a file by path, as ``body1/properties/cg``."""

    def __init__(self, path: Path, file: netCDF4.Dataset) -> None:
        self.path = path
        self._file = file

    def has(self, name: str) -> bool:
        """True if there is a variable of that path."""
        return self._variable(name) is not None

    def groups(self) -> list[str]:
        """Names of the groups on top."""
        return list(self._file.groups)

    def dimensions(self, name: str) -> tuple[str, ...]:
        """Names of the dimensions of a variable."""
        variable = self._variable(name)
        return () if variable is None else tuple(variable.dimensions)

    def array(self, name: str) -> np.ndarray:
        """Numbers with the shape of a variable, in the units of the file, NaN where it has none.

        InputError if it is not there, cannot be read, or is no number.
        """
        values = self._values(name)
        try:
            return np.ma.filled(np.ma.asarray(values).astype(float), np.nan)
        except (TypeError, ValueError):
            raise refused(f"{self.path}: {name} is not of numbers") from None

    def number(self, name: str) -> float:
        """The only number of a variable."""
        values = self.array(name).ravel()
        if len(values) != 1:
            raise refused(f"{self.path}: {name} has {len(values)} values, expected one")
        return float(values[0])

    def texts(self, name: str) -> list[str]:
        """The words of a variable."""
        values = np.asarray(self._values(name))
        if values.dtype.kind == "S" and values.dtype.itemsize == 1 and values.ndim:
            import netCDF4

            values = netCDF4.chartostring(values)
        flat = [v.decode() if isinstance(v, bytes) else str(v) for v in values.ravel().tolist()]
        return [text.strip("\0 ") for text in flat]

    def _values(self, name: str) -> object:
        variable = self._variable(name)
        if variable is None:
            raise refused(f"{self.path}: there is no {name}", "it is cut off, or of another format")
        try:
            return variable[...]
        except (OSError, RuntimeError, IndexError) as error:
            text = f"{self.path} is damaged: {name} cannot be read ({error})"
            raise refused(text, "copy it again, or write it anew") from None

    def _variable(self, name: str) -> netCDF4.Variable[object] | None:
        try:
            return self._file[name]
        except LookupError:
            return None
