"""The `Solution` of a program, of use where the program is part of another one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from m4e_fmi.program.copying import TapeCopy
from m4e_fmi.program.program import Solution
from m4e_fmi.program.tape import Scalar, Tape


class MovedSolution:
    """A solution on the tape that `copy` copies to; `solution` is the original on `tape`.

    The response to a drive is recorded once on the original tape, for symbols, and copied for each
    drive: what has no effect folds away.
    """

    def __init__(self, solution: Solution, tape: Tape, copy: TapeCopy) -> None:
        self._solution, self._tape, self._copy = solution, tape, copy

    @property
    def unknowns(self) -> Sequence[Scalar]:
        """The scalars that are solved for."""
        return [self._copy(s.index) for s in self._solution.unknowns]

    def balance(self) -> Sequence[Scalar]:
        """Scalars that the unknowns depend on."""
        return [self._copy(s.index) for s in self._balance]

    @cached_property
    def _balance(self) -> Sequence[Scalar]:
        return self._solution.balance()

    @cached_property
    def _response(self) -> Sequence[Scalar | int]:
        """The response to a change of all of the balance, on the original tape."""
        changes = {k: self._tape.symbol(_change(k)) for k in range(len(self._balance))}
        return self._solution.response(self._solution.drive(changes))

    def drive(self, change: Mapping[int, Scalar]) -> Mapping[int, Scalar]:
        """The change itself: it becomes a drive in `response`."""
        return change

    def response(self, drive: Mapping[int, Scalar]) -> Sequence[Scalar | int]:
        """Change of the unknowns for a `drive`."""
        copy, zero = self._copy.fork(), self._copy.target.constant(0.0)
        for k in range(len(self._balance)):
            copy.give(_change(k), drive.get(k, zero))
        return [copy(s.index) if isinstance(s, Scalar) else s for s in self._response]


def _change(place: int) -> str:
    return f"change of balance {place}"
