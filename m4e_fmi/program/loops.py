"""Algebraic loops of connected programs, solved on the tape where they are linear.

The unknowns z of a loop are inputs that need themselves: z = f(z). Where ∂f/∂z does not depend on
z, f is linear, and elimination gives z = (1 − ∂f/∂z)⁻¹ f(0) as straight-line code. Its pivots are
chosen for the start values, on the diagonal unless others are much larger, in a scale in which
units of the unknowns do not matter. A pivot is a difference of terms; the remaining share of these
is the condition of the loop. The shares are recorded, too: a later share of zero means that the
loop has no single solution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from m4e_fmi.program.derivatives import slopes
from m4e_fmi.program.program import Program
from m4e_fmi.program.tape import Scalar, evaluated

LEAST_PIVOT = 1e-10
"""Least pivot over the terms that it is the difference of: fewer than six digits are left below."""
MUCH_LARGER = 10.0
"""By which a pivot off the diagonal must be larger than those on it to be taken."""
SWEEPS = 60
"""Of the scaling of rows and columns, each of which halves the decades between them."""


class LoopError(ValueError):
    """A loop that cannot be solved as a linear one: `reason` says why.

    One that `is_singular` has no single solution at the start, in whatever way it is solved.
    """

    def __init__(self, reason: str, *, is_singular: bool = False) -> None:
        self.reason, self.is_singular = reason, is_singular
        super().__init__(reason)


def solved_loop(
    unknowns: Sequence[Scalar],
    values: Sequence[Scalar],
    constants: Sequence[Scalar],
    start: Mapping[str, float],
) -> tuple[list[Scalar], list[Scalar]]:
    """Solution of z = f(z), and the shares [1]: each pivot over the sum of its terms' sizes.

    `unknowns` are the symbols that stand for z, `values` is f(z) recorded on them, `constants`
    f(0), all of length n. `start` has start values of all other symbols, by name; they choose the
    order of pivots. LoopError if f is not linear, or the loop is singular at the start.
    """
    tape = unknowns[0].tape
    one, zero = tape.constant(1.0), tape.constant(0.0)
    seeds = {z.index: {j: one} for j, z in enumerate(unknowns)}
    rows = slopes(tape, [f.index for f in values], seeds)
    own = {tape.operations[z.index][1] for z in unknowns}
    entries = [slope.index for row in rows for slope in row.values()]
    if any(names & own for names in tape.symbols_of_each(entries).values()):
        raise LoopError("it is not linear in its inputs")
    size = range(len(rows))
    matrix = [[(one if i == j else zero) - rows[i].get(j, zero) for j in size] for i in size]
    numbers = evaluated(tape, [e.index for row in matrix for e in row], start)
    order = _pivots([[numbers[e.index] for e in row] for row in matrix])
    return _eliminated(matrix, list(constants), order)


def singular_loop(
    program: Program, values: Mapping[str, float], *, least: float = LEAST_PIVOT
) -> str:
    """The inputs of an algebraic loop that is singular at these values of all symbols; else "".

    Singular is what has a pivot of which less than `least` of its terms is left.
    """
    for loop in program.loops:
        found = evaluated(program.tape, loop.shares, values)
        if not all(abs(share) >= least for share in found.values()):
            return ", ".join(loop.inputs)
    return ""


def is_singular(table: list[list[float]], *, least: float) -> bool:
    """True for a loop whose 1 − ∂f/∂z, a `table` of n rows in any units, is singular.

    It is if less than `least` of the terms of a pivot is left.
    """
    try:
        _pivots(table, least)
    except LoopError:
        return True
    return False


def _pivots(table: list[list[float]], least: float = LEAST_PIVOT) -> list[tuple[int, int]]:
    """Row and column of each pivot of an elimination; LoopError if all that is left is rounding."""
    table = [[v if math.isfinite(v) else 0.0 for v in row] for row in table]
    terms = [[abs(v) for v in row] for row in table]
    for k, row in enumerate(table):  # 1 − J: both are terms
        terms[k][k] = 1.0 + abs(1.0 - row[k])
    tall, wide = _scales(terms)
    rows, columns, order = list(range(len(table))), list(range(len(table))), []
    while rows:
        sizes: dict[tuple[int, int], float] = {}
        for i in rows:
            for j in columns:
                value = abs(table[i][j])
                scaled = value * (tall[i] * wide[j])
                # no rounding, neither of its own terms nor of others
                if value > 0.0 and value >= least * terms[i][j] and (i == j or scaled >= least):
                    favour = MUCH_LARGER if i == j else 1.0
                    sizes[i, j] = value * tall[i] * wide[j] * favour
        if not sizes:
            reason = "it is singular at the start: its equations have no single solution"
            raise LoopError(reason, is_singular=True)
        row, column = max(sizes, key=lambda place: (sizes[place], -place[0], -place[1]))
        order.append((row, column))
        rows.remove(row)
        columns.remove(column)
        for i in rows:
            factor = table[i][column] / table[row][column]
            for j in columns:
                product = factor * table[row][j]
                table[i][j] -= product
                terms[i][j] += abs(product)
    return order


def _scales(terms: list[list[float]]) -> tuple[list[float], list[float]]:
    """Factors of rows and of columns by which the largest of each of them is 1 (Ruiz's method)."""
    size = range(len(terms))
    rows, columns = [1.0 for _ in size], [1.0 for _ in size]
    for _ in range(SWEEPS):
        tall = [max(rows[i] * terms[i][j] * columns[j] for j in size) for i in size]
        wide = [max(rows[i] * terms[i][j] * columns[j] for i in size) for j in size]
        rows = [r / math.sqrt(most) for r, most in zip(rows, tall, strict=True)]
        columns = [c / math.sqrt(most) for c, most in zip(columns, wide, strict=True)]
    return rows, columns


def _eliminated(
    matrix: list[list[Scalar]], right: list[Scalar], order: Sequence[tuple[int, int]]
) -> tuple[list[Scalar], list[Scalar]]:
    """Solution of matrix · z = right by elimination in the order of the pivots, and the shares."""
    size, terms = range(len(matrix)), [[abs(v) for v in row] for row in matrix]
    for k, row in enumerate(matrix):
        terms[k][k] = 1.0 + abs(1.0 - row[k])
    for number, (row, column) in enumerate(order):
        left = order[number + 1 :]
        for i in sorted(i for i, _ in left):
            factor = matrix[i][column] / matrix[row][column]
            for j in sorted(j for _, j in left):
                product = factor * matrix[row][j]
                matrix[i][j] = matrix[i][j] - product
                terms[i][j] = terms[i][j] + abs(product)
            right[i] = right[i] - factor * right[row]
    solution: dict[int, Scalar] = {}
    for row, column in reversed(order):
        total = right[row]
        for j, value in solution.items():
            total = total - matrix[row][j] * value
        solution[column] = total / matrix[row][column]
    shares = [matrix[row][column] / terms[row][column] for row, column in order]
    return [solution[k] for k in size], shares
