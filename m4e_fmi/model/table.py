"""Tables: values at certain times, linear in between."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real

from m4e_fmi.program import AnyScalar, maximum, minimum
from m4e_fmi.shown import short
from m4e_fmi.units import parse_unit

MOST_ROWS = 10_000


class TableError(ValueError):
    """A fault of a table, and its remedy."""

    def __init__(self, message: str, remedy: str = "") -> None:
        self.remedy = remedy
        super().__init__(message)


@short
@dataclass(frozen=True)
class Table:
    """`values` in `unit` at `times` [s], linear in between, constant before and after.

    In loads a table's name is its value at the time t, in SI units.
    """

    times: Sequence[float]
    values: Sequence[float]
    unit: str = "1"
    description: str = ""

    def at(self, time: AnyScalar) -> AnyScalar:
        """The value at `time` over any scalar that knows min and max.

        It is a sum over the intervals: slope times the part of the interval that has passed. Five
        operations for each.
        """
        factor = parse_unit(self.unit).factor
        values = [factor * value for value in self.values]
        total: AnyScalar = values[0]
        for k in range(1, len(values)):
            start, end = self.times[k - 1], self.times[k]
            rise = values[k] - values[k - 1]
            if rise != 0:
                passed = minimum(maximum(time, start), end) - start
                total = total + rise / (end - start) * passed
        return total

    def check(self) -> None:
        """TableError if there is no line through times and values."""
        for name, column in (("times", self.times), ("values", self.values)):
            for row, value in enumerate(column, start=1):
                if not isinstance(value, Real) or not math.isfinite(value):
                    message = f"row {row} of {name}: expected a finite number, got {value!r}"
                    raise TableError(message)
        if len(self.times) != len(self.values):
            message = f"{len(self.times)} times, but {len(self.values)} values"
            raise TableError(message, "give one value for each time")
        if not 2 <= len(self.times) <= MOST_ROWS:
            message = f"expected 2 to {MOST_ROWS} rows, got {len(self.times)}"
            remedy = "every row costs time in each step: leave out rows on a straight line"
            if len(self.times) < 2:
                remedy = "a value that does not change is a parameter"
            raise TableError(message, remedy)
        for row in range(1, len(self.times)):
            if not self.times[row] > self.times[row - 1]:
                last, time = self.times[row - 1], self.times[row]
                message = f"row {row + 1}: time {time} is not after {last}"
                remedy = "times must ascend; write a jump as two rows a short time apart"
                raise TableError(message, remedy)
