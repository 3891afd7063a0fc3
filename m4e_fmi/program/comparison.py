"""Programs as text, and the differences between two of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import TYPE_CHECKING

from m4e_fmi.program.tape import COMMUTATIVE, Operation, Tape

if TYPE_CHECKING:
    from m4e_fmi.program.program import Program, Variable

GROUPS = ("parameters", "inputs", "states", "outputs", "calculated")
LONGEST_FORMULA = 160
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


def differences(old: Program, new: Program) -> list[str]:
    """Differences of `new` from `old`, one line each; none for equal programs.

    Programs are equal if their variables are, in the same order, and if they do the same
    operations on them: to the bit the same results, on whatever tapes they are.
    """
    lines = [
        f"{field}: {getattr(old, field)!r} -> {getattr(new, field)!r}"
        for field in ("name", "description")
        if getattr(old, field) != getattr(new, field)
    ]
    for group in GROUPS:
        lines += _changed_variables(group, getattr(old, group), getattr(new, group))
    table: dict[Operation, int] = {}
    before, after = _identities(old, table), _identities(new, table)
    old_nodes, new_nodes = dict(results(old)), dict(results(new))
    for name in (name for name in before if name in after and before[name] != after[name]):
        lines.append(f"{name}:")
        lines.append(f"  - {formula(old.tape, old_nodes[name])}")
        lines.append(f"  + {formula(new.tape, new_nodes[name])}")
    return lines


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


def _changed_variables(
    group: str, old: tuple[Variable, ...], new: tuple[Variable, ...]
) -> Iterator[str]:
    before, after = ({v.name: v for v in variables} for variables in (old, new))
    yield from (f"{group}: - {name}" for name in before if name not in after)
    yield from (f"{group}: + {name}" for name in after if name not in before)
    for name in (name for name in before if name in after):
        for field in fields(before[name]):
            was, now = (getattr(v[name], field.name) for v in (before, after))
            if was != now:
                yield f"{group}: {name}.{field.name}: {was!r} -> {now!r}"
    if set(before) == set(after) and list(before) != list(after):
        yield f"{group}: in another order"


def formula(tape: Tape, node: int) -> str:
    """A node written out, down to where it gets too long."""
    shortest = ""
    for depth in range(1, 20):
        text = _nested(tape, node, depth)
        if len(text) > LONGEST_FORMULA or text == shortest:
            break
        shortest = text
    return shortest or _nested(tape, node, 1)


def _nested(tape: Tape, node: int, depth: int) -> str:
    names = {a: "…" if depth == 1 else _nested(tape, a, depth - 1) for a in tape.arguments(node)}
    return _operation(tape, node, names)


def _operation(tape: Tape, k: int, names: dict[int, str]) -> str:
    kind, *operands = tape.operations[k]
    if not tape.arguments(k):
        return f"{operands[0]:.17g}" if kind == "constant" else operands[0]
    texts = [names[a] for a in operands]
    if kind in _SIGNS:
        return f"({texts[0]} {_SIGNS[kind]} {texts[1]})"
    return f"(-{texts[0]})" if kind == "neg" else f"{kind}({', '.join(texts)})"
