"""Algebraic loops of a simulated program, which may become singular while it runs.

What is left of the pivots of each loop is computed beside the outputs. Where it passes through zero
the solution has a pole: methods with error control do not pass it, one of fixed steps would.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.program import LEAST_PIVOT, TIME, Program, Variable, singular_loop

CLOSE = 0.01
"""Share of a pivot's terms that is told as the cause of a failure."""
REMEDY = "look at the gains around the loop: their product reaches 1"


def with_shares(program: Program) -> tuple[Program, int]:
    """The program with the shares of its loops as last outputs, and how many these are."""
    nodes = tuple(node for loop in program.loops for node in loop.shares)
    shares = tuple(
        Variable(f"loop.{k}.share", "1", "What is left of a pivot of an algebraic loop", local=True)
        for k in range(len(nodes))
    )
    outputs, results = (*program.outputs, *shares), (*program.results, *nodes)
    return replace(program, outputs=outputs, results=results), len(nodes)


def check_start(program: Program) -> None:
    """RunError if a loop is singular at the start values."""
    groups = (program.parameters, program.inputs, program.states)
    values = {v.name: v.start for group in groups for v in group}
    if names := singular_loop(program, {**values, TIME: 0.0}):
        raise RunError(_singular_message(program, names, "the start"), REMEDY)


def singular_row(
    program: Program, times: np.ndarray, shares: np.ndarray, *, fixed: bool
) -> tuple[int, RunError] | None:
    """The first row in which a loop is singular, from 0, and the error that tells of it.

    `shares` (n, m) are at `times` (n,) [s]. Of a method of `fixed` steps also where a loop was
    singular between two rows: a share has changed its sign there.
    """
    wrong = ~(np.abs(shares) >= LEAST_PIVOT)
    if fixed:
        wrong[1:] |= np.sign(shares[1:]) != np.sign(shares[:-1])
    if not wrong.any():
        return None
    row, column = np.argwhere(wrong)[0]
    owners = [", ".join(loop.inputs) for loop in program.loops for _ in loop.shares]
    when = f"t = {times[row]:.9g} s"
    crossed = abs(shares[row, column]) >= LEAST_PIVOT
    told = _singular_message(program, owners[column], f"a time before {when}" if crossed else when)
    return int(row), RunError(told, REMEDY)


def explained(program: Program, values: dict[str, float]) -> str:
    """The loop that is close to singular at values of all symbols; "" if there is none."""
    names = singular_loop(program, values, least=CLOSE)
    return f"the algebraic loop of {names} is close to singular there" if names else ""


def _singular_message(program: Program, names: str, when: str) -> str:
    return f"{program.name}: the algebraic loop of {names} is singular at {when}"
