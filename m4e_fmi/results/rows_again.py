"""Rows of a results file as a run had them in memory, so that it can go on behind them."""

from __future__ import annotations

import hashlib
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.results.recorded import Recorded
from m4e_fmi.results.row_file import READ, is_row_file, leading_rows
from m4e_fmi.results.row_header import TIME, Section
from m4e_fmi.threads import PROCESS

_REMEDY = "the results and the checkpoint of one run belong together: give those, or run again"
Place = Callable[[bytes], int]
"""Gives the place of a text."""


def rows_again(
    path: Path, sections: Sequence[Section], count: int, place: Place
) -> Iterator[list[np.ndarray]]:
    """Blocks of rows: an array (n_rows, n_columns) for each section, in the variables' units.

    They are the first `count` of the results at `path`; a block has the times before the arrays of
    `sections`. Of other types than Real there are cells, in which a text is its `place`. InputError
    if the file is not there, has fewer rows, or other variables.
    """
    sections = (TIME, *sections)
    try:
        if is_row_file(path):
            yield from leading_rows(path, sections, count)
        else:
            yield from _of_netcdf(path, sections, count, place)
    except FileNotFoundError:
        raise InputError.single("no such file of results", _REMEDY, str(path)) from None
    except (OSError, RuntimeError, ValueError, KeyError, IndexError) as error:
        message = f"its rows cannot be read again: {error}"
        raise InputError.single(message, _REMEDY, str(path)) from error


def digest_of(row: Sequence[np.ndarray]) -> str:
    """SHA-256 of a row, of arrays (1, n_columns) in the variables' units, or cells."""
    digest = hashlib.sha256()
    for part in row:
        digest.update(part.astype(part.dtype.newbyteorder("<")).tobytes())
    return digest.hexdigest()


def _of_netcdf(
    path: Path, sections: Sequence[Section], count: int, place: Place
) -> Iterator[list[np.ndarray]]:
    from netCDF4 import Dataset

    with PROCESS, Dataset(path) as file:
        file.set_auto_mask(False)
        file.set_auto_scale(False)
        if count > len(file.dimensions["time"]):
            raise ValueError(f"{count} rows, and it has {len(file.dimensions['time'])}")
        groups = [file[s.component] if s.component else file for s in sections]
        found = [
            [(c.recorded, g.variables[unicodedata.normalize("NFC", c.name)]) for c in s.columns]
            for s, g in zip(sections, groups, strict=True)
        ]
        width = max(1, sum(map(len, found)))
        most = max(1, READ // (8 * width))
        for first in range(0, count, most):
            rows = slice(first, min(first + most, count))
            yield [
                _block(section, [(one, variable[rows]) for one, variable in columns], rows, place)
                for section, columns in zip(sections, found, strict=True)
            ]


def _block(
    section: Section, columns: Sequence[tuple[Recorded, np.ndarray]], rows: slice, place: Place
) -> np.ndarray:
    block = np.zeros((rows.stop - rows.start, len(columns)), section.kind)
    for k, (recorded, values) in enumerate(columns):
        if recorded.is_text:
            known = {text: place(text.encode()) for text in set(values.tolist())}
            block[:, k] = [known[text] for text in values.tolist()]
        else:
            block[:, k] = values if recorded.is_real else values.astype(np.int64)
    return block
