"""Results files in memory: what runs and simulations have written (netCDF-4), and other forms.

The dimension and the variable `time` are at the root; each group holds the variables of one
component, or of the one model that was simulated. CSV and Parquet have one column for each
variable, ``component.variable``; in CSV its unit follows in brackets.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Named
from m4e_fmi.series import Series
from m4e_fmi.shown import listing, span
from m4e_fmi.writing import check_suffix, written

NETCDF, CSV, PARQUET = ".nc", ".csv", ".parquet"


@dataclass(frozen=True)
class Results:
    """A results file in memory: `time` [s], `components[component][variable]`, the attributes.

    UnknownNameError, which is a KeyError, where there is no such component or variable.
    """

    path: Path
    time: np.ndarray
    components: dict[str, dict[str, Series]]
    attributes: dict[str, str]

    def __getitem__(self, name: str) -> Series:
        """The series ``component.variable``."""
        return self.series[name]

    @property
    def series(self) -> dict[str, Series]:
        """All series by ``component.variable``."""
        return Named(
            f"{self.path.name} has no variable",
            {
                f"{component}.{name}": one
                for component, members in self.components.items()
                for name, one in members.items()
            },
        )

    def __repr__(self) -> str:
        return listing(
            f"Results of {str(self.path)!r}: {span(self.time)}",
            **{name: tuple(members) for name, members in self.components.items()},
        )


def load(path: str | Path) -> Results:
    """The results in a file that a run has written."""
    from netCDF4 import Dataset

    with Dataset(Path(path)) as file:
        file.set_auto_mask(False)
        components = Named(
            "there are no results of a component",
            {
                component: Named(
                    f"{component} has no variable",
                    {
                        name: Series(name, variable.units, variable.long_name, variable[:])
                        for name, variable in group.variables.items()
                    },
                )
                for component, group in file.groups.items()
            },
        )
        attributes = {name: str(file.getncattr(name)) for name in file.ncattrs()}
        return Results(Path(path), file["time"][:], components, attributes)


def stream_of(path: str | Path) -> Path:
    """The netCDF file that is written first if results are to be in `path`."""
    path = Path(path)
    return path.with_suffix(NETCDF) if path.suffix.lower() in (CSV, PARQUET) else path


def check_export(path: str | Path) -> None:
    """InputError unless the suffix of `path` names a form in which results can be written."""
    check_suffix(path, (NETCDF, CSV, PARQUET), "results")
    if Path(path).suffix.lower() == PARQUET and find_spec("pyarrow") is None:
        remedy = "install it with: pip install 'm4e_fmi[parquet]'; or write .nc or .csv"
        raise InputError.single("Parquet needs the package pyarrow", remedy, str(path))


def export(results: Path, path: Path) -> None:
    """Write the results in the netCDF file `results` to `path`, CSV or Parquet by its suffix."""
    suffix = path.suffix.lower()
    if suffix == CSV:
        _write_csv(load(results), path)
    elif suffix == PARQUET:
        _write_parquet(load(results), path)


def _write_csv(results: Results, path: Path) -> None:
    series = results.series
    rows = np.column_stack([results.time, *(one.values for one in series.values())])
    with written(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        units = (f"{name} [{one.unit}]" for name, one in series.items())
        writer.writerow(["time [s]", *units])
        writer.writerows(rows.tolist())  # all digits of each number


def _write_parquet(results: Results, path: Path) -> None:
    import pyarrow  # pyright: ignore[reportMissingImports]  an extra
    import pyarrow.parquet  # pyright: ignore[reportMissingImports]

    columns = {"time": Series("time", "s", "simulated time", results.time), **results.series}
    fields = [
        pyarrow.field(name, pyarrow.float64(), metadata={"unit": s.unit, "long_name": s.long_name})
        for name, s in columns.items()
    ]
    schema = pyarrow.schema(fields, metadata=results.attributes)
    arrays = [pyarrow.array(one.values) for one in columns.values()]
    with written(path) as part:
        pyarrow.parquet.write_table(pyarrow.table(arrays, schema=schema), part)
