"""`compare_cells`: two files with numbers over dimensions, as of studies, cell by cell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_fmi.analysis.comparison.measures import limit_problems, normalised
from m4e_fmi.errors import InputError, Problem, unknown_names
from m4e_fmi.files.file_kinds import as_path
from m4e_fmi.results.gridded_file import Grid, GriddedFile, is_gridded, read_gridded
from m4e_fmi.shown import listing
from m4e_fmi.units import parse_unit

SAME = 1e-9
"""Part of the largest magnitude within which two values of a dimension are the same."""

WALL_TIME = "wall_time"
"""Variable of studies that no two runs have in common: it is compared only where it is named."""


@dataclass(frozen=True)
class CellDifference:
    """A variable beside its reference in the cells of both, in `unit`, over `dimensions`.

    `values` and `reference` (…,) have the shape of the common cells; `left_out` counts those in
    which one of them is nan, `lacking` cells of the reference that have a number and, here, none or
    no place. `largest_at` is the cell of the `largest` difference by the values of its dimensions.
    `scale` is the divisor of shares.
    """

    name: str
    unit: str
    dimensions: tuple[str, ...]
    values: np.ndarray = field(repr=False)
    reference: np.ndarray = field(repr=False)
    left_out: int
    lacking: int
    rms: float
    largest: float
    largest_at: Mapping[str, str | float]
    scale: float

    @property
    def difference(self) -> np.ndarray:
        """Values minus reference, (…,) in the unit of the variable."""
        return self.values - self.reference

    @property
    def rms_share(self) -> float:
        """Root of the mean square difference over `scale` [1]."""
        return float(normalised(np.array([self.rms]), self.scale)[0])

    @property
    def largest_share(self) -> float:
        """Largest difference over `scale` [1]; nan without common cells."""
        return float(normalised(np.array([self.largest]), self.scale)[0])

    def __repr__(self) -> str:
        return (
            f"CellDifference of {self.name} [{self.unit}]: rms {self.rms:.4g}, largest "
            f"{self.largest:.4g}, {self.values.size} cells"
        )


@dataclass(frozen=True)
class CellComparison:
    """Differences by variable of one file, `path`, from the `reference`, as `Comparison`."""

    path: Path
    reference: Path
    differences: Mapping[str, CellDifference]
    relative_to: str
    tolerance: float | None
    only_here: tuple[str, ...]
    only_there: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def beyond(self) -> tuple[str, ...]:
        """Variables that are beyond the tolerance, or lack values; none without a tolerance."""
        if self.tolerance is None:
            return ()
        limit = self.tolerance
        return tuple(
            n for n, d in self.differences.items() if d.lacking or not d.largest_share <= limit
        )

    @property
    def is_within(self) -> bool:
        """True if all differences are within the tolerance, or there is none."""
        return not self.beyond

    def __getitem__(self, name: str) -> CellDifference:
        return self.differences[name]

    def __repr__(self) -> str:
        return listing(
            f"CellComparison of {self.path.name!r} with {self.reference.name!r}",
            differences=[
                f"{d.name}: largest {100 * d.largest_share:.2g} %"
                for d in self.differences.values()
            ],
            beyond=self.beyond,
        )


def compare_cells(
    one: str | Path,
    reference: str | Path,
    *,
    variables: Sequence[str] | None = None,
    tolerance: float | None = None,
    relative_to: str = "range",
) -> CellComparison:
    """Differences of variables of the same name over the same dimensions, cell by cell.

    Both files are netCDF-4. Cells are the same where all their dimensions have the same values;
    dimensions without values must be of one size. `variables`, `tolerance` and `relative_to` as
    `compare`; an amplitude is √2 standard deviations of the cells. By default variables without a
    number in either file, and the wall time of runs, are left out, which notes tell. InputError for
    files, names and numbers that are wrong, units that do not fit, and without common cells.
    """
    paths = as_path(one), as_path(reference)
    wrong = limit_problems(relative_to, tolerance=tolerance)
    wrong += [
        Problem("is no netCDF file with numbers over dimensions", "", str(path))
        for path in paths
        if not is_gridded(path)
    ]
    if wrong:
        raise InputError(wrong)
    a, b = map(read_gridded, paths)
    common = [name for name in a.grids if name in b.grids]
    problems = unknown_names(variables or (), common, "not in both files:", "variables")
    if not common:
        problems.append(Problem(f"{a.path.name} and {b.path.name} have no variable in common"))
    if problems:
        raise InputError(problems)
    notes, found = dict[str, None](), dict[str, CellDifference]()
    wanted = [*common] if variables is None else [*dict.fromkeys(variables)]
    left = {name: why for name in wanted if (why := _left_out(a, b, name))}
    if variables is None:
        notes |= {f"{name}: {why}": None for name, why in left.items()}
        wanted = [name for name in wanted if name not in left]
    if not wanted:
        raise InputError.single(f"{a.path.name} and {b.path.name} have no numbers in common")
    for name in wanted:
        try:
            found[name] = _difference(a, b, name, relative_to, notes)
        except ValueError as error:
            problems.append(Problem(f"{name}: {error}"))
    if problems:
        raise InputError(problems)
    return CellComparison(
        path=a.path, reference=b.path, differences=found, relative_to=relative_to,
        tolerance=tolerance, notes=tuple(notes),
        only_here=tuple(n for n in a.grids if n not in b.grids),
        only_there=tuple(n for n in b.grids if n not in a.grids),
    )  # fmt: skip


def _left_out(a: GriddedFile, b: GriddedFile, name: str) -> str:
    """The reason why a variable is compared only if it is named; empty if there is none."""
    if name == WALL_TIME:
        return "depends on the machine, not compared"
    numbers = any(np.isfinite(file.grids[name].values).any() for file in (a, b))
    return "" if numbers else "no numbers in either file"


def _difference(
    a: GriddedFile, b: GriddedFile, name: str, relative_to: str, notes: dict[str, None]
) -> CellDifference:
    """The difference of a variable; ValueError if it cannot be compared."""
    one, other = a.grids[name], b.grids[name]
    if one.dimensions != other.dimensions:
        raise ValueError(f"over {_listed(one)} here, over {_listed(other)} in the reference")
    mine, theirs = parse_unit(one.unit), parse_unit(other.unit)
    if not mine.same_dimension(theirs):
        raise ValueError(f"{one.unit} and {other.unit} are of different dimension")
    factor = theirs.factor / mine.factor
    values, reference, places = _common(a, b, one, other, notes)
    reference = factor * reference
    known = np.isfinite(values) & np.isfinite(reference)
    if not known.any():
        raise ValueError("no cell has a number in both files")
    size = np.where(known, np.abs(values - reference), -1.0)
    worst = np.unravel_index(int(np.argmax(size)), size.shape)
    at = {
        dimension: _plain(place[k])
        for dimension, place, k in zip(one.dimensions, places, worst, strict=True)
    }
    difference, numbers = size[known], reference[known]
    scale = {
        "range": float(np.ptp(numbers)),
        "amplitude": math.sqrt(2.0) * float(np.std(numbers)),
        "value": float(np.max(np.abs(numbers))),
    }[relative_to]
    return CellDifference(
        name=name, unit=one.unit, dimensions=one.dimensions, values=values, reference=reference,
        left_out=int(np.sum(~known)), lacking=int(np.isfinite(other.values).sum() - known.sum()),
        rms=float(np.sqrt(np.mean(difference**2))),
        largest=float(difference.max()), largest_at=at, scale=scale,
    )  # fmt: skip


def _common(
    a: GriddedFile, b: GriddedFile, one: Grid, other: Grid, notes: dict[str, None]
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Values of both in their common cells, and the values of the dimensions there."""
    values, reference = one.values, other.values
    places: list[np.ndarray] = []
    for axis, dimension in enumerate(one.dimensions):
        sizes = values.shape[axis], reference.shape[axis]
        here, there = _same(a, b, dimension, *sizes)
        if len(here) < max(sizes):
            text = f"{len(here)} values are in both files, of {sizes[0]} and {sizes[1]}"
            notes[f"{dimension}: {text}"] = None
        values = np.take(values, here, axis)
        reference = np.take(reference, there, axis)
        places.append(a.coordinates.get(dimension, np.arange(sizes[0]))[here])
    return values, reference, places


def _listed(grid: Grid) -> str:
    return " × ".join(grid.dimensions) or "no dimension"


def _plain(value: object) -> str | float:
    return float(value) if isinstance(value, np.number) else str(value)


def _same(
    a: GriddedFile, b: GriddedFile, dimension: str, size: int, other_size: int
) -> tuple[np.ndarray, np.ndarray]:
    """Places (k,) [1] of the values of a dimension that both files have."""
    if dimension not in a.coordinates or dimension not in b.coordinates:
        if size != other_size:
            raise ValueError(f"{dimension} has {size} places here, {other_size} in the reference")
        return np.arange(size), np.arange(size)
    mine, theirs = a.coordinates[dimension], b.coordinates[dimension]
    if mine.dtype.kind == "f" and theirs.dtype.kind == "f":
        limit = SAME * max(np.max(np.abs(mine), initial=0.0), np.max(np.abs(theirs), initial=0.0))
    else:
        mine, theirs, limit = mine.astype(str), theirs.astype(str), 0.0
    pairs = _pairs(mine, theirs, limit)
    if not pairs:
        raise ValueError(f"the files have no value of {dimension} in common")
    here, there = np.array(sorted(pairs)).T
    return here, there


def _pairs(mine: np.ndarray, theirs: np.ndarray, limit: float) -> list[tuple[int, int]]:
    """Places of equal values, or of numbers within a `limit` in their unit; each in one pair.

    `mine` (n,) and `theirs` (m,) are numbers or texts. Of values that are there several times, the
    first belongs to the first.
    """
    left, right = (np.argsort(one, kind="stable").tolist() for one in (mine, theirs))
    found, i, j = list[tuple[int, int]](), 0, 0
    while i < len(left) and j < len(right):
        x, y = mine[left[i]], theirs[right[j]]
        if x == y or (limit and abs(x - y) <= limit):
            found.append((left[i], right[j]))
            i, j = i + 1, j + 1
        elif x < y:
            i += 1
        else:
            j += 1
    return found
