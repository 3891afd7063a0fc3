"""Algebraic loops of connected programs, solved on the tape where they are linear.

The unknowns z of a loop are inputs that need themselves: z = f(z). Where ∂f/∂z does not depend on
z, f is linear, and elimination gives z = (1 − ∂f/∂z)⁻¹ f(0) as straight-line code. Its pivots are
chosen on the diagonal, for the start values: 1 − ∂f/∂z is the identity less what the loop feeds
back, and units of the unknowns then do not matter. A pivot is compared with the terms it is the
difference of: what is left of these is the condition of the loop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from m4e_fmi.program.derivatives import slopes
from m4e_fmi.program.evaluation import evaluated
from m4e_fmi.program.tape import Scalar

LEAST_PIVOT = 1e-10
"""Least pivot over the terms that it is the difference of: fewer than six digits are left below."""


class LoopError(ValueError):
    """A loop that cannot be solved as a linear one: `reason` says why."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


@dataclass(frozen=True)
class LinearLoop:
    """z = f(z): the symbols that stand for z, f(z) recorded on them, and f(0), all of length n."""

    unknowns: Sequence[Scalar]
    values: Sequence[Scalar]
    constants: Sequence[Scalar]

    def solved(self, start: Mapping[str, float]) -> list[Scalar]:
        """The unknowns, without the symbols that stood for them.

        `start` has start values of all other symbols, by name; they choose the order of pivots.
        LoopError if f is not linear, or the loop is singular at the start.
        """
        tape = self.unknowns[0].tape
        one, zero = tape.constant(1.0), tape.constant(0.0)
        seeds = {z.index: {j: one} for j, z in enumerate(self.unknowns)}
        rows = slopes(tape, [f.index for f in self.values], seeds)
        own = {tape.operations[z.index][1] for z in self.unknowns}
        entries = [slope.index for row in rows for slope in row.values()]
        if any(names & own for names in tape.symbols_of_each(entries).values()):
            raise LoopError("it is not linear in its inputs")
        size = range(len(rows))
        matrix = [[(one if i == j else zero) - rows[i].get(j, zero) for j in size] for i in size]
        numbers = evaluated(tape, [e.index for row in matrix for e in row], start)
        table = [[numbers[e.index] for e in row] for row in matrix]
        return _eliminated(matrix, list(self.constants), _Pivots(table))


class _Pivots:
    """The elimination in numbers, which chooses the pivots."""

    def __init__(self, table: list[list[float]]) -> None:
        self._table = table
        self._terms = [[abs(value) for value in row] for row in table]
        for k, row in enumerate(table):  # 1 − J: both are terms
            self._terms[k][k] = 1.0 + abs(1.0 - row[k])
        self._left = list(range(len(table)))

    def next(self) -> int:
        """The next pivot, eliminated; LoopError if none is left that is not rounding."""

        def share(k: int) -> float:
            value = abs(self._table[k][k]) / self._terms[k][k]
            return value if math.isfinite(value) else 0.0

        best = max(self._left, key=lambda k: (share(k), -k))
        if share(best) < LEAST_PIVOT:
            raise LoopError("it is singular at the start: its equations have no single solution")
        self._left.remove(best)
        for i in self._left:
            factor = self._table[i][best] / self._table[best][best]
            for j in self._left:
                product = factor * self._table[best][j]
                self._table[i][j] -= product
                self._terms[i][j] += abs(product)
        return best


def _eliminated(matrix: list[list[Scalar]], right: list[Scalar], pivots: _Pivots) -> list[Scalar]:
    """Solution of matrix · z = right by elimination on the diagonal, in the order of the pivots."""
    size = len(matrix)
    order: list[int] = []
    for _ in range(size):
        k = pivots.next()
        order.append(k)
        rest = [i for i in range(size) if i not in order]
        for i in rest:
            factor = matrix[i][k] / matrix[k][k]
            for j in rest:
                matrix[i][j] = matrix[i][j] - factor * matrix[k][j]
            right[i] = right[i] - factor * right[k]
    solution: dict[int, Scalar] = {}
    for k in reversed(order):
        total = right[k]
        for j, value in solution.items():
            total = total - matrix[k][j] * value
        solution[k] = total / matrix[k][k]
    return [solution[k] for k in range(size)]
