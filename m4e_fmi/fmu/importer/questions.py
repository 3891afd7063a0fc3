"""Questions to an FMU that is tried, the master's before a run and validation's alike.

What depends on what is seen by moving one value at a time; whether an FMU goes back, by making the
same steps again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

Values = TypeVar("Values")
Row = TypeVar("Row")
_In = TypeVar("_In", contravariant=True)
_Out = TypeVar("_Out", covariant=True)


class SteppedFmu(Protocol[_In, _Out]):
    """An instance that is tried: its inputs can be set, its outputs be read."""

    def set(self, values: _In, /) -> None:
        """All inputs."""
        ...

    def read(self) -> _Out:
        """The outputs."""
        ...

    def step(self, size: float, /) -> None:
        """A step of `size` [s]."""
        ...


def moved(
    evaluate: Callable[[Values], Row], values: Values, moves: Iterable[Values]
) -> Iterator[tuple[Row, Row, Row]]:
    """The outputs at `values` before each of the `moves` away from there, with it, and after it."""
    still = evaluate(values)
    for other in moves:
        there = evaluate(other)
        yield still, there, evaluate(values)


def trajectory(
    subject: SteppedFmu[Values, Row], inputs: Iterable[Values | None], size: float
) -> list[Row]:
    """The outputs after each of some steps of `size` [s].

    Before each, the inputs are set to their values for it, unless that is None.
    """
    found: list[Row] = []
    for values in inputs:
        if values is not None:
            subject.set(values)
        subject.step(size)
        found.append(subject.read())
    return found
