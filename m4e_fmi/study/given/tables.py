"""Cases from tables: a row each, or a scatter diagram of two quantities."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError, Problem, is_file, missing_file
from m4e_fmi.files.csv_columns import column_names, read_columns, unit_of_column
from m4e_fmi.files.document import Document, Location
from m4e_fmi.statistics.marine import SUM_ROUNDING
from m4e_fmi.study.given.sections import ScatterSection, TableSection


def table(
    folder: Path, given: TableSection, document: Document
) -> tuple[tuple[tuple[float, ...], ...], tuple[float, ...] | None, tuple[str, ...]]:
    """Rows of numbers, in the order of `columns`, their weights, scaled to a sum of 1, and units.

    InputError for a file or columns that are not there, units that are none, and weights that are
    none. A column has the unit "" if its name has none.
    """
    path = _file(folder, given.file, document, ("table", "file"))
    names = [*given.columns.values(), *([given.weight] if given.weight else [])]
    read = read_columns(path, names)
    columns = np.array(read.values).T
    if not len(columns):
        raise InputError.single("has no rows", "write one for each case", str(path))
    units, unclear = list[str](), list[Problem]()
    for name, column in given.columns.items():
        try:
            units.append(unit_of_column(column))
        except ValueError as error:
            at = ("table", "columns", name, "@value")
            remedy = "write a unit as in 'mass [kg]', or none"
            unclear.append(document.problem(at, f"column {column!r}: {error}", remedy))
    if unclear:
        raise InputError(unclear)
    if given.weight is None:
        return tuple(map(tuple, columns.tolist())), None, tuple(units)
    wrong = [
        read.problem(k, f"weight {weight:g} is below 0")
        for k, weight in enumerate(columns[:, -1].tolist())
        if weight < 0.0
    ]
    if wrong:
        raise InputError(wrong)
    shares = tuple(_shares(columns[:, -1], path).tolist())
    return tuple(map(tuple, columns[:, :-1].tolist())), shares, tuple(units)


def scatter(
    folder: Path, given: ScatterSection, document: Document
) -> tuple[tuple[float, ...], tuple[float, ...], np.ndarray, str]:
    """Values of the rows (n,) and columns (m,), probabilities (n, m) [1], what they cover in words.

    The sum of the probabilities is 1, or that of the entries over `total`. InputError for a file
    that is not there, entries that are no numbers or below 0, and more of them than `total`.
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
    if problems:
        raise InputError(problems)
    read = read_columns(path, list(range(len(heads))))
    values = np.array(read.values).T
    wrong = [
        read.problem(int(k), "an entry is below 0")
        for k in np.flatnonzero((values[:, 1:] < 0.0).any(axis=1))
    ]
    if wrong:
        raise InputError(wrong)
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
    return tuple(values[:, 0].tolist()), tuple(columns), shares, covered


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
