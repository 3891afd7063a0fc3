"""Questions to an FMU that is tried, the master's before a run and validation's alike.

What depends on what is seen by moving one value at a time; whether an FMU goes back, by making the
same steps again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

Values = TypeVar("Values")
Row = TypeVar("Row")


def moved(
    evaluate: Callable[[Values], Row], values: Values, moves: Iterable[Values]
) -> Iterator[tuple[Row, Row, Row]]:
    """The outputs at `values` before each of the `moves` away from there, with it, and after it."""
    still = evaluate(values)
    for other in moves:
        there = evaluate(other)
        yield still, there, evaluate(values)


def trajectory(subject: Any, inputs: Iterable[Any], size: float) -> list[Any]:
    """The outputs after each of some steps of `size` [s].

    Before each, the inputs are set to their values for it, unless that is None. The `subject` is an
    instance that is tried: it has the methods `set` (all inputs), `step` (a size) and `read` (the
    outputs).
    """
    found = []
    for values in inputs:
        if values is not None:
            subject.set(values)
        subject.step(size)
        found.append(subject.read())
    return found
