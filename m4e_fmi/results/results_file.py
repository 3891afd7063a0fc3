"""Results files: reading netCDF, and writing a result as netCDF or CSV.

Whole files are netCDF-4: the dimension and the variable `time` are at the root; each group holds
the variables of one component, or of the one model that was simulated. A run that goes on, or was
killed, has rows in netCDF's classic form: see `row_file`. CSV has one column for each variable,
``component.variable``, whose unit follows in brackets.
"""

from __future__ import annotations

import codecs
import csv
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from m4e_fmi.errors import InputError, Named, is_other
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.files.writing import check_suffix, netcdf, written
from m4e_fmi.results.dataset import as_dataset
from m4e_fmi.results.recorded import recorded_as
from m4e_fmi.results.row_file import SMALLER, check_size, is_row_file, read_rows
from m4e_fmi.results.row_header import MAGIC, TIME, Numbered, Section
from m4e_fmi.results.series import Series
from m4e_fmi.shown import Animated, Displayed, listing, span, views
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

NETCDF, CSV = ".nc", ".csv"
FORMAT = "m4e_fmi_format"
"""The attribute that has the number of a file's form."""
FORMAT_NUMBER = 1
"""That of files which are written now; earlier ones have none."""
WRITTEN = "give what `m4e-fmi run` or `m4e-fmi simulate` has written"
AT_STOP = "at the stop time"
"""How a run has ended that was complete."""
OF_A_STUDY = "it is the result of a study: `xarray.open_dataset` reads it"
_HDF5 = b"\x89HDF"
_OTHERS = {
    b"PAR1": "Parquet",
    b"PK": "a ZIP archive, as an FMU and a system's package (.ssp) are",
    b"\x89PNG": "a picture (PNG)",
}
"""First bytes of files of other kinds."""
_LOOKED_AT, _SHOWN = 4096, 60
"""Bytes of a file and characters of its first line by which its kind is told."""


@dataclass(frozen=True)
class Results(Displayed):
    """A results file in memory: `time` [s], `components[component][variable]`, the attributes.

    UnknownNameError, which is a KeyError, where there is no such component or variable.
    """

    path: Path
    time: np.ndarray
    components: dict[str, dict[str, Series]]
    attributes: dict[str, str]

    def __post_init__(self) -> None:
        named = {c: Named(f"{c} has no variable", one) for c, one in self.components.items()}
        components = Named(f"{self.path.name} has no component", named)
        object.__setattr__(self, "components", components)

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

    def to_xarray(self) -> xarray.Dataset:
        """All series as a dataset over `time`, by ``component.variable``, with their units."""
        return as_dataset(self.time, self.series, self.attributes)

    def plot(self, *names: str) -> Figure:
        """A figure of the variables ``component.variable``; without names, of the main ones.

        InputError for a name that is not there.
        """
        return views().figure(self, names)

    def animate(self) -> Animated:
        """The animation of a run; it is shown by a notebook, and written by its `save`.

        InputError for results without a scene.
        """
        return views().animation(self)

    def __repr__(self) -> str:
        changed = self.attributes.get("changed", "").splitlines()
        return listing(
            f"Results of {str(self.path)!r}: {span(self.time)}",
            **{name: tuple(members) for name, members in self.components.items()},
            **{"not as in the system's file": changed},
        )


def load(path: str | Path) -> Results:
    """The results in a file that a run or a simulation has written.

    Of a run that goes on or was killed: all rows that had reached the disk, each of them complete.
    InputError for a file that is not there, empty, damaged, too large, of another kind or of a
    newer form.
    """
    with PROCESS:
        return _loaded(as_path(path))


def _loaded(path: Path) -> Results:
    if not path.is_file():
        other = "a folder" if path.is_dir() else "a pipe or a device" if is_other(path) else ""
        what = f"is {other}, not a file of results" if other else "no such file"
        raise InputError.single(what, "", str(path))
    if not path.stat().st_size:
        raise InputError.single("is empty: it has no results", "run again", str(path))
    with path.open("rb") as file:
        head = file.read(_LOOKED_AT)
    rows = is_row_file(path)
    if not (rows or head.startswith((_HDF5, MAGIC))):  # others are not given to the netCDF library
        message = f"is not a file of results (netCDF), but {_kind(head)}"
        raise InputError.single(message, _instead(path), str(path))
    said = ""
    try:
        if rows:
            return _of_rows(path)
        if head.startswith(_HDF5):
            return _of_netcdf(path)
    except (OSError, RuntimeError) as error:
        said = f": {error}"
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        said = f": {error}" if type(error) is ValueError else ""
    except MemoryError:
        raise InputError.single("takes more memory than there is", SMALLER, str(path)) from None
    message, remedy = f"is cut off or damaged{said}", "copy it again, or run again"
    raise InputError.single(message, remedy, str(path))


def _kind(head: bytes) -> str:
    """The kind of a file that begins with `head`, as far as it can be told."""
    for magic, kind in _OTHERS.items():
        if head.startswith(magic):
            return kind
    try:
        text = codecs.getincrementaldecoder("utf-8-sig")().decode(head)  # it may end in a character
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        return "data of a kind that is not known here"
    first = text.partition("\n")[0].strip()
    kind = "a table (CSV)" if "," in first else "text"
    return f"{kind} with the first line {first[:_SHOWN]!r}"


def _instead(path: Path) -> str:
    """Remedy for loading a file that is not netCDF."""
    beside = path.with_suffix(NETCDF)
    if beside.name != path.name and beside.is_file():
        return f"load {beside.name}, which is beside it"
    if path.suffix.lower() == CSV:
        return f"load the {NETCDF} file that was written with it; pandas reads this one"
    if path.suffix.lower() in (".yaml", ".yml"):
        return "load_model, load_system or load_study reads it"
    return WRITTEN


def _of_rows(path: Path) -> Results:
    attributes, variables = read_rows(path)
    _check_format(path, attributes)
    components: dict[str, dict[str, Series]] = {}
    for column, values in variables[1:]:
        component, _, name = column.name.partition(".")
        one = column.recorded
        series = Series(name, column.unit, column.long_name, one.values(values), one)
        components.setdefault(component, {})[name] = series
    told = {name: str(value) for name, value in attributes.items()}
    return Results(path, _increasing(variables[0][1]), components, told)


def _of_netcdf(path: Path) -> Results:
    from netCDF4 import Dataset

    with PROCESS, Dataset(path) as file:
        file.set_auto_mask(False)
        attributes = {name: file.getncattr(name) for name in file.ncattrs()}
        _check_format(path, attributes)
        if strange := _strange(file):
            remedy = OF_A_STUDY if "study" in attributes else WRITTEN
            raise InputError.single(f"is netCDF, but not results: {strange}", remedy, str(path))
        columns = sum(len(group.variables) for group in (file, *file.groups.values()))
        check_size(path, file["time"].size, columns)
        time = _increasing(file["time"][:])
        components = {
            component: {name: _series(variable) for name, variable in group.variables.items()}
            for component, group in file.groups.items()
        }
        told = {name: str(value) for name, value in attributes.items()}
        return Results(path, time, components, told)


def _strange(file: Any) -> str:
    """The first difference of a netCDF-4 file from those of `write_netcdf`; empty if none."""
    if "time" not in file.variables:
        return "it has no variable `time`"
    if FORMAT not in file.ncattrs() and not file.groups:
        return f"it has no attribute `{FORMAT}`, and no groups"
    for group in (file, *file.groups.values()):
        place = "at its root" if group is file else f"in {group.name!r}"
        if group is not file and group.groups:
            return f"it has groups {place}"
        for name, variable in group.variables.items():
            if (group is file and name != "time") or variable.shape != file["time"].shape:
                return f"it has the variable {name!r}, of shape {variable.shape}, {place}"
    return "" if file["time"].ndim == 1 else "its `time` has no dimension, or several"


def _increasing(time: np.ndarray) -> np.ndarray:
    """`time` (n,) [s]; ValueError unless it is finite and increases."""
    if not (np.isfinite(time).all() and (np.diff(time) > 0.0).all()):
        raise ValueError("its times do not increase, or are not finite")
    return time


def _series(variable: Any) -> Series:
    told = {name: variable.getncattr(name) for name in variable.ncattrs()}
    one = recorded_as(variable.dtype, told)
    return Series(variable.name, told["units"], told["long_name"], one.values(variable[:]), one)


def _check_format(path: Path, attributes: Mapping[str, object]) -> None:
    number = int(str(attributes.get(FORMAT, 0)))
    if number > FORMAT_NUMBER:
        message = f"is of format {number}, and this m4e_fmi reads formats up to {FORMAT_NUMBER}"
        raise InputError.single(message, "update m4e_fmi", str(path))


def write_netcdf(
    path: Path,
    sections: Sequence[Section],
    attributes: Mapping[str, str],
    count: int,
    blocks: Iterable[Sequence[np.ndarray]],
    texts: Numbered = (),
) -> None:
    """Write `count` rows as netCDF-4 to `path`, which appears whole or not at all.

    Each of `blocks` holds further rows: the times (n_rows, 1) [s], then an array (n_rows,
    n_columns), in the variables' units, for each of `sections`; other types than Real are cells,
    Strings by their places among `texts`.
    RunError if the file cannot be written.
    """
    with written(path) as part:
        with netcdf(part) as file:
            file.set_fill_off()  # every value is written
            file.setncatts({FORMAT: FORMAT_NUMBER, **attributes})
            file.createDimension("time", count)
            variables = []
            for section in (TIME, *sections):
                group = file.createGroup(section.component) if section.component else file
                if section.component:
                    group.setncatts(section.attributes)
                variables.append([])
                for column in section.columns:
                    one = column.recorded
                    variable = group.createVariable(column.name, one.file_type, ("time",))
                    told = {"units": column.unit, "long_name": column.long_name}
                    variable.setncatts({**told, **one.attributes})
                    variables[-1].append((variable, one))
            file.set_auto_maskandscale(False)  # nothing is missing, nothing is packed
            first = 0
            for block in blocks:  # after all declarations: half the time
                last = first + len(block[0])
                for members, values in zip(variables, block, strict=True):
                    for (variable, one), column in zip(members, values.T, strict=True):
                        variable[first:last] = one.stored(column, texts.__getitem__)
                first = last
        with part.open("rb+") as whole:
            os.fsync(whole.fileno())


def stream_of(path: str | Path) -> Path:
    """The netCDF file that is written first if results are to be in `path`."""
    path = Path(path)
    return path.with_suffix(NETCDF) if path.suffix.lower() == CSV else path


def as_given(given: Path, file: Path) -> Path:
    """`given` if it leads to the folder of `file`, else `file`: one may have been renamed since."""
    try:
        return given if given.parent.samefile(file.parent) else file
    except OSError:
        return file


def check_export(path: str | Path) -> None:
    """InputError unless the suffix of `path` names a form in which results can be written."""
    check_suffix(path, (NETCDF, CSV), "results")
    if is_other(Path(path)):  # a device would be replaced by a file
        raise InputError.single("results replace no device or pipe", "name a file", str(path))


def export(results: Path, path: Path) -> None:
    """Write the results in the netCDF file `results` to `path` if that is CSV."""
    if path.suffix.lower() == CSV:
        _write_csv(load(results), path)


def _write_csv(results: Results, path: Path) -> None:
    series = results.series
    columns = [results.time.tolist(), *(_plain(one) for one in series.values())]
    with written(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        heads = (f"{name} [{one.unit}]" if one.unit else name for name, one in series.items())
        writer.writerow(["time [s]", *heads])
        writer.writerows(zip(*columns, strict=True))


def _plain(series: Series) -> list:
    """The values as they stand in CSV: all digits of numbers, 0 or 1 for Booleans, texts."""
    values = series.values
    return (values.astype(np.int8) if values.dtype == bool else values).tolist()
