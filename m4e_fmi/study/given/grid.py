"""`Grid`: the dimensions of a study, and which of their points are run."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, reduce

import numpy as np

from m4e_fmi.files.document import Location
from m4e_fmi.study.given.sections import Scalar


@dataclass(frozen=True)
class Varied:
    """One varied quantity: its short `name`, what it is in the file (`targets`), and its place.

    `unit` is what the name of its `column` in a table says, if it is from one and says any.
    """

    name: str
    targets: tuple[str, ...]
    location: Location = field(default=(), compare=False)
    column: str = ""
    unit: str = ""


@dataclass(frozen=True)
class Axis:
    """A dimension `name`; each of its `points` has one value for each of the `varied` quantities.

    `repeats` are runs of one design, with other seeds.
    """

    name: str
    varied: tuple[Varied, ...]
    points: tuple[tuple[Scalar, ...], ...] = field(repr=False)
    repeats: bool = False

    def __len__(self) -> int:
        return len(self.points)

    @property
    def labels(self) -> list[str]:
        """Texts of the points: values, or numbers from 1 of points of several quantities."""
        if len(self.varied) > 1:
            return [str(k + 1) for k in range(len(self))]
        return [f"{x:.6g}" if isinstance(x, float) else str(x) for (x,) in self.points]

    @property
    def is_numbers(self) -> bool:
        """True if it is one quantity, whose values are numbers: they are the coordinate."""
        return len(self.varied) == 1 and all(
            isinstance(point[0], int | float) and not isinstance(point[0], bool)
            for point in self.points
        )


@dataclass(frozen=True)
class Shares:
    """Shares of time `values` (…) [1] of the points of the dimensions `names`.

    Points of 0 are run only if `run_all`; `key` is the section of the file that says so.
    """

    names: tuple[str, ...]
    values: np.ndarray = field(repr=False)
    key: str = ""
    run_all: bool = False

    @property
    def text(self) -> str:
        """A note on points that are not run; "" if there are none."""
        count = 0 if self.run_all else int(np.sum(self.values == 0.0))
        points = f"{count} of {self.values.size} points of {', '.join(self.names)}"
        remedy = f"{self.key}: {{run_all: true}} runs them"
        return f"without a share of time, and not run: {points} ({remedy})" if count else ""


@dataclass(frozen=True)
class Grid:
    """All dimensions, and the shares of time of the points of a scatter diagram, of a table.

    `covered` tells how much of the time the diagram stands for, where its entries do not say so.
    Runs have the numbers of their points, from 0, the last dimension first; those without a share
    of time are none.
    """

    axes: tuple[Axis, ...]
    shares: tuple[Shares, ...] = ()
    covered: str = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points of each dimension."""
        return tuple(map(len, self.axes))

    @property
    def size(self) -> int:
        """Number of points, those which are not run among them."""
        return math.prod(self.shape)

    @property
    def places(self) -> dict[str, Location]:
        """Places in the file of all varied targets, by name."""
        varied = (one for axis in self.axes for one in axis.varied)
        return {target: one.location for one in varied for target in one.targets}

    @cached_property
    def is_run(self) -> np.ndarray:
        """1 of the points that are run, else 0: truth values (…) [1] in the shape of the grid."""
        found = np.ones(self.shape, dtype=bool)
        names = [axis.name for axis in self.axes]
        for one in self.shares:
            order = np.argsort([names.index(name) for name in one.names])
            shape = [len(axis) if axis.name in one.names else 1 for axis in self.axes]
            found &= one.run_all | (one.values > 0.0).transpose(order).reshape(shape)
        return found

    @property
    def probability(self) -> tuple[tuple[str, ...], np.ndarray] | None:
        """Dimensions, and the probabilities (n, …) [1] of their points; None without shares."""
        if not self.shares:
            return None
        names = tuple(name for one in self.shares for name in one.names)
        return names, reduce(np.multiply.outer, [one.values for one in self.shares])

    @cached_property
    def runs(self) -> list[int]:
        """Numbers of the points that are run, ascending."""
        return np.flatnonzero(self.is_run).tolist()

    @property
    def count(self) -> int:
        """Number of runs."""
        return len(self.runs)

    def values(self, run: int) -> dict[str, Scalar]:
        """Value of each target in run number `run`, from 0."""
        found: dict[str, Scalar] = {}
        for axis, k in zip(self.axes, self.place(run), strict=True):
            for varied, value in zip(axis.varied, axis.points[k], strict=True):
                found.update(dict.fromkeys(varied.targets, value))
        return found

    def place(self, run: int) -> tuple[int, ...]:
        """Indices of run number `run`, from 0."""
        return tuple(int(k) for k in np.unravel_index(run, self.shape)) if self.axes else ()

    def label(self, run: int) -> str:
        """The run in words, as ``peak_period 7.5, seed 2``."""
        parts = list[str]()
        for axis, k in zip(self.axes, self.place(run), strict=True):
            if len(axis.varied) == 1:
                value = axis.points[k][0]
                shown = f"{value:g}" if isinstance(value, float) else str(value)
                parts.append(f"{axis.name} {shown}")
            else:
                parts.append(f"{axis.name} {k + 1}")
        return ", ".join(parts) or "the run"
