"""`Work`: the runs of a study, of a system or of a program, as `run` needs them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field

from m4e_fmi.report.run_report.record import InputFile
from m4e_fmi.study.dataset import Labels
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.record import Record

Batch = Mapping[int, Record]
Make = Callable[[Sequence[int]], Generator[Batch]]


@dataclass(frozen=True)
class Work:
    """The runs of a `study`: the `keys` of what each follows from, and how they are made.

    Both have an entry for each point of the grid, "" and nan for those that are not run. `start_up`
    (n_points,) [s] is the time from which on rows count. `inputs` are files as they are before the
    first run. `records` makes the runs of some numbers.
    `rows` tells which rows statistics are of.
    """

    study: Study
    keys: Sequence[str] = field(repr=False)
    start_up: Sequence[float] = field(repr=False)
    labels: Labels = field(repr=False)
    inputs: Sequence[InputFile] = field(repr=False)
    warnings: Mapping[str, int]
    notes: Sequence[str]
    records: Make = field(repr=False)
    rows: str


def rows_text(intervals: Sequence[float | None]) -> str:
    """Where the rows of runs are, which have these intervals [s] between them (None: none)."""
    known = [one for one in intervals if one is not None]
    if not known:
        return "at all communication points"
    low, high = min(known), max(known)
    return f"every {low:g} s" if low == high else f"every {low:g} to {high:g} s"
