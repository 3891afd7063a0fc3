"""Cases from tables: a row each, or a scatter diagram of two quantities."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem, is_file, missing_file
from m4e_fmi.files.csv_columns import column_names, heading, is_unit, read_columns
from m4e_fmi.files.document import Document, Location
from m4e_fmi.study.given.grid import Axis, Varied
from m4e_fmi.study.given.sections import ScatterSection, TableSection

SUM_ROUNDING = 1e-6
"""By how much entries of a table that was rounded may add up to more than their total."""
_WITH_UNIT = re.compile(r"[^\[\]()]*(?:\[[^\[\]]*\]|\([^()]*\))")
"""A part of a heading up to the end of brackets."""


def table(
    folder: Path, given: TableSection, document: Document
) -> tuple[tuple[tuple[float, ...], ...], tuple[float, ...] | None, tuple[str, ...]]:
    """Rows of numbers, in the order of `columns`, their weights, scaled to a sum of 1, and units.

    InputError for a file or columns that are not there, unknown units, and weights below 0. A
    column has the unit "" if its name has none; the unit of weights has no effect.
    """
    path = _file(folder, given.file, document, ("table", "file"))
    names = [*given.columns.values(), *([given.weight] if given.weight else [])]
    read = read_columns(path, [(name, None) for name in names])
    columns = np.array(read.values).T
    if not len(columns):
        raise InputError.single("has no rows", "write one for each case", str(path))
    units = tuple(heading(name)[1] or "" for name in read.names[: len(given.columns)])
    if given.weight is None:
        return tuple(map(tuple, columns.tolist())), None, units
    wrong = [
        read.problem(k, f"weight {weight:g} is below 0")
        for k, weight in enumerate(columns[:, -1].tolist())
        if weight < 0.0
    ]
    InputError.raise_for(wrong)
    shares = tuple(_shares(columns[:, -1], path).tolist())
    return tuple(map(tuple, columns[:, :-1].tolist())), shares, units


def scatter(
    folder: Path, given: ScatterSection, document: Document
) -> tuple[tuple[Axis, Axis], np.ndarray, str]:
    """Dimensions of the n rows and m columns, probabilities (n, m) [1], what they cover in words.

    The sum of the probabilities is 1, or that of the entries over `total`. Units are those of the
    first entry. InputError for a file that is not there, entries that are no numbers or below 0,
    more of them than `total`, and units that are unknown or not clear.
    """
    path = _file(folder, given.file, document, ("scatter", "file"))
    heads = column_names(path)
    columns, problems = list[float](), list[Problem]()
    for head in heads[1:]:
        try:
            columns.append(float(head))
        except ValueError:
            message = f"the first row has {head!r}, expected a value of {given.columns}"
            problems.append(Problem(message, "write numbers behind the first entry", str(path), 1))
    InputError.raise_for(problems)
    read = read_columns(path, [(0, None), *((place, "1") for place in range(1, len(heads)))])
    values = np.array(read.values).T
    wrong = [
        read.problem(int(k), "an entry is below 0")
        for k in np.flatnonzero((values[:, 1:] < 0.0).any(axis=1))
    ]
    InputError.raise_for(wrong)
    shares, counted = _shares(values[:, 1:], path), float(values[:, 1:].sum())
    covered = ""
    if given.total is not None:
        if counted > given.total * (1.0 + SUM_ROUNDING):
            message = f"the entries add up to {counted:.6g}, more than the total {given.total:g}"
            remedy = "give what they add up to if they cover all the time, as 8766 of hours"
            raise InputError([document.problem(("scatter", "total"), message, remedy)])
        shares = shares * (counted / given.total)
        covered = (
            f"the sea states of {given.file} cover {100 * counted / given.total:.4g} % of time"
        )
    elif abs(counted - 1.0) > SUM_ROUNDING:
        covered = (
            f"the entries of {given.file} add up to {counted:.6g}, which counts as all the time; "
            "if that is more, as a year with calms, give 'total' of the scatter diagram"
        )
    head = read.names[0]
    units = _units(head, path)
    rows = _axis(given.rows, "rows", values[:, 0].tolist(), head, units[0])
    return (rows, _axis(given.columns, "columns", columns, head, units[1])), shares, covered


def _axis(name: str, key: str, values: Sequence[float], head: str, unit: str) -> Axis:
    """The dimension of a scatter diagram's `values` (n,), in a `unit` of its first entry `head`."""
    varied = Varied(name, (name,), ("scatter", key), head, unit)
    return Axis(name, (varied,), tuple((value,) for value in values))


def _units(head: str, path: Path) -> tuple[str, str]:
    """Units of rows and columns in the first entry of a scatter diagram, "" where it has none."""
    units = [unit for part in _WITH_UNIT.findall(head) if (unit := heading(part)[1])]
    one_of_two = len(units) == 1 and re.search(r"[/\\|]", heading(head)[0])
    if len(units) > 2 or one_of_two or not all(map(is_unit, units)):
        message = f"the first row has {head!r}: the units of rows and of columns are not clear"
        remedy = "write both, that of the rows first, as 'Hs [m] / Tp [s]'; or none"
        raise InputError([Problem(message, remedy, str(path), 1)])
    rows, columns = [*units, "", ""][:2]
    return rows, columns


def _shares(values: np.ndarray, path: Path) -> np.ndarray:
    """`values` (…), occurrences or probabilities, over their sum [1]."""
    total = float(values.sum())
    if not (math.isfinite(total) and total > 0.0):
        raise InputError.single("all occurrences are 0", "", str(path))
    return values / total


def _file(folder: Path, name: str, document: Document, at: Location) -> Path:
    path = folder / name
    if not is_file(path):
        raise InputError([document.problem(at, *missing_file(path))])
    return path
