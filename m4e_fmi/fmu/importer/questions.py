"""Trials of an FMU, for the master before a run.

Dependencies are found by moving one value at a time; rollback is checked by repeating the same
steps.
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

    Before each, the inputs are set to their values for it (None: not set). The `subject` is the
    instance on trial: it has the methods `set` (all inputs), `step` (a size) and `read` (the
    outputs).
    """
    found = []
    for values in inputs:
        if values is not None:
            subject.set(values)
        subject.step(size)
        found.append(subject.read())
    return found
