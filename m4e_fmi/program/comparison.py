"""Equality of two programs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from m4e_fmi.program.tape import COMMUTATIVE, Operation

if TYPE_CHECKING:
    from m4e_fmi.program.program import Program

GROUPS = ("parameters", "inputs", "states", "outputs", "calculated")


def _results(program: Program) -> Iterator[tuple[str, int]]:
    """Name and node of each result: rates as der(x), outputs, calculated parameters."""
    for state, node in zip(program.states, program.rates, strict=True):
        yield f"der({state.name})", node
    for output, node in zip(program.outputs, program.results, strict=True):
        yield output.name, node
    for parameter, node in zip(program.calculated, program.constants, strict=True):
        yield parameter.name, node


def are_equal(one: Program, other: Program) -> bool:
    """True if two programs have the same variables, in the same order, and do the same with them.

    To the bit they give the same results then, on whatever tapes they are.
    """
    table: dict[Operation, int] = {}
    return all(
        getattr(one, field) == getattr(other, field) for field in ("name", "description", *GROUPS)
    ) and _identities(one, table) == _identities(other, table)


def _identities(program: Program, table: dict[Operation, int]) -> dict[str, int]:
    """For each result a number that is the same for the same operations; `table` is shared."""
    numbers: dict[int, int] = {}
    named = dict(_results(program))
    for k in program.tape.reachable(named.values()):
        kind, *operands = program.tape.operations[k]
        if program.tape.arguments(k):
            operands = [numbers[a] for a in operands]
            if kind in COMMUTATIVE:
                operands.sort()
        numbers[k] = table.setdefault((kind, *operands), len(table))
    return {name: numbers[node] for name, node in named.items()}
