"""Programs as text, and whether two of them are equal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from m4e_fmi.program.tape import COMMUTATIVE, Operation, Tape

if TYPE_CHECKING:
    from m4e_fmi.program.program import Program

GROUPS = ("parameters", "inputs", "states", "outputs", "calculated")
_SIGNS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}


def listing(program: Program) -> str:
    """Every operation of `program` on a line of its own, in order; then what comes out."""
    tape = program.tape
    names: dict[int, str] = {}
    operations: list[str] = []
    for k in tape.reachable(node for _, node in results(program)):
        names[k] = _operation(tape, k, names)
        if tape.arguments(k):
            operations.append(f"  v{len(operations) + 1} = {names[k]}")
            names[k] = f"v{len(operations)}"
    outcome = [f"  {name} = {names[node]}" for name, node in results(program)]
    return "\n".join([str(program), "operations", *operations, "results", *outcome])


def results(program: Program) -> Iterator[tuple[str, int]]:
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
    named = dict(results(program))
    for k in program.tape.reachable(named.values()):
        kind, *operands = program.tape.operations[k]
        if program.tape.arguments(k):
            operands = [numbers[a] for a in operands]
            if kind in COMMUTATIVE:
                operands.sort()
        numbers[k] = table.setdefault((kind, *operands), len(table))
    return {name: numbers[node] for name, node in named.items()}


def _operation(tape: Tape, k: int, names: dict[int, str]) -> str:
    kind, *operands = tape.operations[k]
    if not tape.arguments(k):
        return f"{operands[0]:.17g}" if kind == "constant" else operands[0]
    texts = [names[a] for a in operands]
    if kind in _SIGNS:
        return f"({texts[0]} {_SIGNS[kind]} {texts[1]})"
    return f"(-{texts[0]})" if kind == "neg" else f"{kind}({', '.join(texts)})"
