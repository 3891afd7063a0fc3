"""Keys of a time table in a system file, and its numbers, from there or from a CSV file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import (
    BeforeValidator,
    Field,
    StrictFloat,
    StringConstraints,
    field_validator,
    model_validator,
)

from m4e_fmi.errors import InputError
from m4e_fmi.files.csv_columns import MOST_PROBLEMS, Asked, read_columns, shortened
from m4e_fmi.files.document import Section, rejected
from m4e_fmus.units import KnownUnit

NEXT_EVENT_TIME = "next_event_time"
MOST_ROWS = 10_000

SignalName = Annotated[
    str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*(\.[A-Za-z][A-Za-z0-9_]*)*$")
]
Number = Annotated[StrictFloat, Field(allow_inf_nan=False)]


class Signal(Section):
    """One output: its `unit`, and its `values` or the `column` of the file that holds them."""

    unit: KnownUnit = "1"
    column: str | None = None
    values: tuple[Number, ...] | None = None
    description: str = ""


def _of_unit(written: object) -> object:
    return {"unit": written} if isinstance(written, str) else written


class Config(Section):
    """The keys of a component of `kind: table`, without `kind` and `start`.

    signals: the outputs by name; a text is short for {unit: text}. Numbers are in a CSV `file`, in
    its column `time` [s] (the first, if unsaid) and for each signal in its `column` (of the
    signal's name, if unsaid), or here, as `times` [s] and each signal's `values`.
    between: values between two rows, 'linear', or 'held' as the row before. beyond: values before
    the first row and after the last, an 'error', or 'held' as that row.
    """

    signals: dict[SignalName, Annotated[Signal, BeforeValidator(_of_unit)]] = Field(min_length=1)
    file: str | None = None
    time: str | None = None
    times: tuple[Number, ...] | None = None
    between: Literal["linear", "held"] = "linear"
    beyond: Literal["error", "held"] = "error"

    @field_validator("times")
    @classmethod
    def _in_order(cls, times: Sequence[float] | None) -> Sequence[float] | None:
        found = [f"row {row + 1}: {message}" for row, message in disorder(times or ())]
        if times is not None and found:
            raise rejected("; ".join(found[:MOST_PROBLEMS]), ORDER)
        return times

    @field_validator("signals")
    @classmethod
    def _not_the_announcement(cls, signals: dict[str, Signal]) -> dict[str, Signal]:
        taken = {NEXT_EVENT_TIME, "time"} & signals.keys()
        if taken:
            message = f"a signal cannot be called {' or '.join(sorted(taken))}"
            raise rejected(message, "rename it, and give its 'column'")
        return signals

    @model_validator(mode="after")
    def _numbers_once(self) -> Config:
        here = [name for name, signal in self.signals.items() if signal.values is not None]
        if self.file is not None and (self.times is not None or here):
            raise rejected(
                "numbers both in a file and here", "give 'file', or 'times' and 'values'"
            )
        if self.file is not None:
            return self
        if self.times is None:
            raise rejected("a table without numbers", "give a 'file', or 'times' and 'values'")
        wrong = [
            f"{name!r} has {len(signal.values or ())} values for {len(self.times)} times"
            for name, signal in self.signals.items()
            if len(signal.values or ()) != len(self.times)
        ]
        if wrong:
            raise rejected("; ".join(wrong), "give each signal one value for each time")
        return self


ORDER = "times must ascend; two rows at the same time make a jump"


def disorder(times: Sequence[float]) -> Iterator[tuple[int, str]]:
    """Index and fault of the rows that are not in order; the last index where rows are too few."""
    if not 2 <= len(times) <= MOST_ROWS:
        yield max(0, len(times) - 1), f"expected 2 to {MOST_ROWS} rows, got {len(times)}"
    for row in range(1, len(times)):
        before, time = times[row - 1], times[row]
        if time < before:
            yield row, f"time {time:g} is before {before:g}"
        elif row > 1 and time == before == times[row - 2]:
            yield row, f"a third row at time {time:g}"


@dataclass(frozen=True)
class Rows:
    """`times` [s], which do not descend, and the values of each signal at them, in its unit."""

    times: tuple[float, ...]
    values: dict[str, tuple[float, ...]]


def _asked(config: Config) -> dict[str, Asked]:
    """By the name of a column, who asks for it."""
    found = {
        signal.column or name: Asked(
            f"which the system file asks for as the signal {name!r}",
            f"mend the name in one of the two, or give {name!r} its 'column' in the system file",
        )
        for name, signal in config.signals.items()
    }
    if config.time:
        found[config.time] = Asked(
            "which the system file asks for under 'time'",
            "mend the name in one of the two; without 'time', the first column is taken",
        )
    return found


def read_rows(config: Config, folder: Path) -> Rows:
    """The rows of the table; InputError with all problems of its file, which is in `folder`."""
    if config.file is None:
        given = {name: signal.values or () for name, signal in config.signals.items()}
        return Rows(config.times or (), given)
    path = folder / config.file
    columns = [(signal.column or name, signal.unit) for name, signal in config.signals.items()]
    found = read_columns(path, [(config.time or 0, "s"), *columns], _asked(config))
    if not found.lines:
        raise InputError.single("has no rows below its first", "", str(path))
    times, *values = found.values
    problems = [found.problem(row, message, ORDER) for row, message in disorder(times)]
    if problems:
        raise InputError(shortened(problems))
    return Rows(tuple(times), dict(zip(config.signals, map(tuple, values), strict=True)))
