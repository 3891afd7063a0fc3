"""Results files: reading netCDF, and writing a result as netCDF or CSV.

Whole files are netCDF-4: the dimension and the variable `time` are at the root; each group holds
the variables of one component, or of the one model that was simulated. Attributes of the root say
what ran, with which settings, and how it ended. A run that goes on, or was killed, has rows in
netCDF's classic form: see `row_file`. CSV has one column for each variable,
``component.variable``, whose unit follows in brackets.
"""

from __future__ import annotations

import csv
import hashlib
import json
import os
import unicodedata
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from m4e_fmi.errors import InputError, Named, is_file, is_other
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.files.files_read import opened
from m4e_fmi.files.limits import MOST_RESULTS
from m4e_fmi.files.writing import check_suffix, netcdf, written
from m4e_fmi.results.row_file import (
    CELLS,
    CLOSING,
    ENDED,
    MAGIC,
    ROWS_BEGIN,
    TEXTS,
    TIME,
    Numbered,
    ResultColumn,
    RowSection,
    blocks_of_rows,
)
from m4e_fmi.results.series import Series, as_dataset, recorded_as
from m4e_fmi.shown import listing, span, views
from m4e_fmi.threads import PROCESS

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure
    from netCDF4 import Dataset, Variable

NETCDF, CSV = ".nc", ".csv"
HEIGHT = 620
"""Of the frame of an animation, in pixels."""
FORMAT = "m4e_fmi_format"
"""The attribute that has the number of a file's form."""
FORMAT_NUMBER = 1
"""That of files which are written now; earlier ones have none."""
WRITTEN = "give what `m4e-fmi run` or `m4e-fmi simulate` has written"
AT_STOP = "at the stop time"
"""How a run has ended that was complete."""
OF_A_STUDY = "it is the result of a study: `m4e_fmi.load` reads it"
_READ = 2**28
"""Bytes that are read at once of a netCDF-4 file, about."""
_SMALLER = "read parts of it with netCDF4 or xarray, or record less: output_interval, --variables"
_BELONG = "the results and the checkpoint of one run belong together: give those, or run again"
_DAMAGED = (OSError, RuntimeError, ValueError, LookupError, TypeError, AttributeError)
"""Errors of reading a file that is damaged."""
_HDF5 = b"\x89HDF"


@dataclass(frozen=True, repr=False)
class Animation:
    """The page of an animation of the results in the file `source`; it loads nothing.

    The frame of a notebook keeps its scripts apart from those of the notebook.
    """

    source: str
    page: str

    def save(self, path: str | Path) -> Path:
        """Write the page to `path` (.html)."""
        check_suffix(path, (".html",), "an animation")
        with written(path) as part:
            part.write_text(self.page, encoding="utf-8")
        return Path(path)

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="animation" sandbox="allow-scripts" width="100%" height="{HEIGHT}" '
            f'style="border:0;background:#fff" srcdoc="{escape(self.page, quote=True)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Animation of {self.source!r}: {len(self.page) / 1e3:.0f} kB of HTML"


@dataclass(frozen=True)
class Results:
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

    def animate(self) -> Animation:
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


def load(path: str | Path) -> Results | xarray.Dataset:
    """The results in a file of a run or a simulation (`load_results`), or a study's dataset."""
    if not is_of_study(as_path(path)):
        return load_results(path)
    import xarray

    with PROCESS:
        return xarray.load_dataset(path, engine="netcdf4", decode_timedelta=False)


def load_results(path: str | Path) -> Results:
    """The results in a file that a run or a simulation has written.

    Of a run that goes on or was killed: all rows that had reached the disk, each of them complete.
    InputError for a file that is not there, empty, damaged, too large, of another kind or of a
    newer form.
    """
    with PROCESS:  # paths are found while the working folder is the user's
        return _load(as_path(path))


def _load(path: Path) -> Results:
    if not path.is_file():
        other = "a folder" if path.is_dir() else "a pipe or a device" if is_other(path) else ""
        what = f"is {other}, not a file of results" if other else "no such file"
        raise InputError.single(what, "", str(path))
    if not path.stat().st_size:
        raise InputError.single("is empty: it has no results", "run again", str(path))
    with path.open("rb") as file:
        head = file.read(len(MAGIC))
    if not head.startswith((_HDF5, MAGIC)):  # others are not given to the netCDF library
        raise InputError.single("is not a file of results (netCDF)", WRITTEN, str(path))
    try:
        with _stored(path) as stored:
            return _results_of(path, stored)
    except MemoryError:
        raise InputError.single("takes more memory than there is", _SMALLER, str(path)) from None
    except _DAMAGED as error:
        clear = isinstance(error, OSError | RuntimeError) or type(error) is ValueError
        said = f": {error}" if clear else ""
    message, remedy = f"is cut off or damaged{said}", "copy it again, or run again"
    raise InputError.single(message, remedy, str(path))


def is_of_study(path: Path) -> bool:
    """True for a netCDF-4 file with the result of a study; False if it cannot be read."""
    if not is_file(path):
        return False
    with path.open("rb") as head:
        if head.read(len(_HDF5)) != _HDF5:
            return False
    from netCDF4 import Dataset

    try:
        with PROCESS, Dataset(path) as file:
            return "study" in file.ncattrs()
    except (OSError, RuntimeError):
        return False


@dataclass(frozen=True)
class _Stored:
    """An open file of results: its attributes, its variables, and the `count` of its rows.

    `columns` are the variables with their components. `blocks(count)` gives the leading rows,
    block by block: an array (n_rows,) for each of the columns, in its unit.
    """

    attributes: dict[str, str | int]
    columns: list[tuple[str, ResultColumn]]
    count: int
    blocks: Callable[[int], Iterator[list[np.ndarray]]]


@contextmanager
def _stored(path: Path) -> Generator[_Stored]:
    """The file at `path`, which is open during the block.

    InputError if it is of another kind or a newer form, or cut off; errors of netCDF's library,
    ValueError, LookupError, TypeError or AttributeError if it is damaged.
    """
    from netCDF4 import Dataset

    with PROCESS, opened(path) as rows, Dataset(path) as file:
        file.set_auto_mask(False)
        attributes = {name: file.getncattr(name) for name in file.ncattrs()}
        if (number := int(attributes.get(FORMAT, 0))) > FORMAT_NUMBER:
            message = f"is of format {number}, and this m4e_fmi reads formats up to {FORMAT_NUMBER}"
            raise InputError.single(message, "update m4e_fmi", str(path))
        if ROWS_BEGIN in attributes:
            yield _of_rows(path, rows, file.variables, attributes)
            return
        if strange := _strange(file):
            remedy = OF_A_STUDY if "study" in attributes else WRITTEN
            raise InputError.single(f"is netCDF, but not results: {strange}", remedy, str(path))
        yield _of_groups(file, attributes)


def _of_rows(
    path: Path,
    file: BinaryIO,
    variables: Mapping[str, Variable[object]],
    attributes: dict[str, str | int],
) -> _Stored:
    """The rows of a RowFile, whose header netCDF's library has read."""
    begin, count = int(attributes.pop(ROWS_BEGIN)), variables["time"].size
    kinds = [one.dtype.str[1:] for one in variables.values()]
    if {*kinds} - {"f8", CELLS} or any(one.ndim != 1 for one in variables.values()):
        raise ValueError("its header is damaged")
    row = np.dtype([(f"_{k}", f">{kind}") for k, kind in enumerate(kinds)])
    length = begin + count * row.itemsize
    if (there := path.stat().st_size) < length:
        message = f"is cut off: it has {there} bytes of {length}"
        raise InputError.single(message, "copy it again, or run again", str(path))
    lines = str(attributes.pop(TEXTS, "")).split("\n")[:-1]  # one that broke off is in no row
    texts = [json.loads(line) for line in lines]
    ended = str(attributes.pop(ENDED)).rstrip()
    attributes |= {ENDED: ended, **json.loads(str(attributes.pop(CLOSING)))}
    columns = []
    for name, one in variables.items():
        component, _, rest = name.partition(".")
        columns.append((component, _column(one, rest)) if rest else ("", _column(one, name)))

    def blocks(most: int) -> Iterator[list[np.ndarray]]:
        for rows in blocks_of_rows(file, row, begin, most):
            yield [
                column.recorded.stored(rows[f"_{k}"].astype(kinds[k]), texts.__getitem__)
                for k, (_, column) in enumerate(columns)
            ]

    return _Stored(attributes, columns, count, blocks)


def _of_groups(file: Dataset, attributes: dict[str, str | int]) -> _Stored:
    """A netCDF-4 file, with a group for each component."""
    groups = [("", file), *file.groups.items()]
    variables = [(name, one) for name, group in groups for one in group.variables.values()]
    columns = [(component, _column(one, one.name)) for component, one in variables]

    def blocks(most: int) -> Iterator[list[np.ndarray]]:
        length = max(1, _READ // (8 * len(variables)))
        for first in range(0, most, length):
            yield [one[first : min(first + length, most)] for _, one in variables]

    return _Stored(attributes, columns, file["time"].size, blocks)


def _column(variable: Variable[object], name: str) -> ResultColumn:
    told = {key: variable.getncattr(key) for key in variable.ncattrs()}
    one = recorded_as(variable.dtype, told)
    return ResultColumn(name, told.get("units", "s"), told.get("long_name", ""), one)


def _strange(file: Dataset) -> str:
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


def _results_of(path: Path, stored: _Stored) -> Results:
    """All rows; ValueError unless the times are finite and increase, InputError beyond limits."""
    count, columns = stored.count, stored.columns
    if count * len(columns) > MOST_RESULTS:
        message = (
            f"has {count} rows of {len(columns)} values; {MOST_RESULTS:,} values are read at most"
        )
        raise InputError.single(message, _SMALLER, str(path))
    values = [
        np.empty(count, object if c.recorded.is_text else c.recorded.kind) for _, c in columns
    ]
    first = 0
    for block in stored.blocks(count):
        last = first + len(block[0])
        if last - first == count:
            values = block
            break
        for into, part in zip(values, block, strict=True):
            into[first:last] = part
        first = last
    time, *values = values
    if not (np.isfinite(time).all() and (np.diff(time) > 0.0).all()):
        raise ValueError("its times do not increase, or are not finite")
    components: dict[str, dict[str, Series]] = {}
    for (component, column), part in zip(columns[1:], values, strict=True):
        one = column.recorded
        series = Series(column.name, column.unit, column.long_name, one.values(part), one)
        components.setdefault(component, {})[column.name] = series
    told = {name: str(value) for name, value in stored.attributes.items()}
    return Results(path, time, components, told)


def rows_of(
    path: Path, sections: Sequence[RowSection], count: int, place: Callable[[bytes], int]
) -> Iterator[list[np.ndarray]]:
    """Blocks of rows: an array (n_rows, n_columns) for each section, in the variables' units.

    They are the first `count` of the results at `path`; a block has the times before the arrays of
    `sections`. Of other types than Real there are cells, in which a text is its `place`. InputError
    if the file is not there, has fewer rows, or other variables.
    """
    sections = (TIME, *sections)
    wanted = [
        (s.component, unicodedata.normalize("NFC", c.name)) for s in sections for c in s.columns
    ]
    try:
        with _stored(path) as stored:
            if wanted != [(component, column.name) for component, column in stored.columns]:
                raise ValueError("it has other variables")
            if stored.count < count:
                raise ValueError(f"{count} rows, and it has {stored.count}")
            for block in stored.blocks(count):
                columns = iter(block)
                yield [_cells(one, columns, len(block[0]), place) for one in sections]
    except FileNotFoundError:
        raise InputError.single("no such file of results", _BELONG, str(path)) from None
    except _DAMAGED as error:
        message = f"its rows cannot be read again: {error}"
        raise InputError.single(message, _BELONG, str(path)) from error


def _cells(
    section: RowSection, columns: Iterator[np.ndarray], count: int, place: Callable[[bytes], int]
) -> np.ndarray:
    """The next of the `columns` (count,) in one array (count, n_columns) of a section."""
    found = np.zeros((count, len(section.columns)), section.kind)
    for k, column in enumerate(section.columns):
        values = next(columns)
        is_text = column.recorded.is_text
        found[:, k] = [place(text.encode()) for text in values] if is_text else values
    return found


def digest_of(row: Sequence[np.ndarray]) -> str:
    """SHA-256 of a row, of arrays (1, n_columns) in the variables' units, or cells."""
    digest = hashlib.sha256()
    for part in row:
        digest.update(part.astype(part.dtype.newbyteorder("<")).tobytes())
    return digest.hexdigest()


def write_netcdf(
    path: Path,
    sections: Sequence[RowSection],
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
                    kind = str if one.is_text else one.kind
                    variable = group.createVariable(column.name, kind, ("time",))
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
    """Write the results in the netCDF file `results` to `path` if that is CSV.

    Numbers have all digits, Booleans are 0 or 1.
    """
    if path.suffix.lower() != CSV:
        return
    loaded = load(results)
    heads, columns = ["time [s]"], [loaded.time.tolist()]
    for name, one in loaded.series.items():
        heads.append(f"{name} [{one.unit}]" if one.unit else name)
        values = one.values.astype(np.int8) if one.values.dtype == bool else one.values
        columns.append(values.tolist())
    with written(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(heads)
        writer.writerows(zip(*columns, strict=True))
