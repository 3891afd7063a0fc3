"""Values of a tape in any arithmetic: 50 digits of mpmath, or whatever the functions given do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import mpmath

from m4e_fmi.program import Program, Tape


def tape_values(
    tape: Tape, roots: Iterable[int], symbols: Mapping[str, Any], *, number: Any, functions: Any
) -> list[Any]:
    """`roots` for values of the symbols; `functions` has sin, cos, … as attributes."""
    binary = {
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "div": lambda a, b: a / b,
        "pow": lambda a, b: a**b,
        "min": min,
        "max": max,
    }
    unary = {"neg": lambda a: -a, "abs": abs}
    roots = list(roots)
    values: dict[int, Any] = {}
    for k in tape.reachable(roots):
        kind, *arguments = tape.operations[k]
        if kind == "constant":
            values[k] = number(arguments[0])
        elif kind == "symbol":
            values[k] = symbols[arguments[0]]
        else:
            function = binary.get(kind) or unary.get(kind) or getattr(functions, kind)
            values[k] = function(*(values[a] for a in arguments))
    return [values[k] for k in roots]


def exact_values(program: Program, roots: Iterable[int], values: Mapping[str, Any]) -> list[Any]:
    """`roots` in mpmath's present precision; what is not named has its start value."""
    groups = (program.parameters, program.inputs, program.states)
    symbols = {v.name: mpmath.mpf(v.start) for group in groups for v in group}
    symbols |= {"time": mpmath.mpf(0)} | {k: mpmath.mpf(v) for k, v in values.items()}
    return tape_values(program.tape, roots, symbols, number=mpmath.mpf, functions=mpmath)
