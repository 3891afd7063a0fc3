"""How results depend on parameters, inputs and states: FMI 2.0's kinds, read off the tape.

A result that is c·v + (anything without v) depends on v as a "constant" if c is a number, "fixed"
if c is made of parameters, "tunable" if one of these may change between steps; otherwise it is
"dependent" on v. Found in one pass over the operations, without any derivative: products with
variables, and functions, count as "dependent" even where terms happen to cancel.
"""

from __future__ import annotations

from collections.abc import Iterable

from m4e_fmi.program.program import Program

KINDS = ("constant", "fixed", "tunable", "dependent")
CONSTANT, FIXED, TUNABLE, DEPENDENT = range(4)

_Levels = tuple[int, int, int, int]
"""Bits of the symbols that a node depends on, of those as `fixed` or more, and so on."""


def kinds(program: Program, roots: Iterable[int]) -> dict[int, dict[str, str]]:
    """For each tape node of `roots`: symbol (parameter, input, state, `time`) → one of KINDS.

    A parameter itself is a known like others: what it is multiplied with decides.
    """
    roots = set(roots)
    tape = program.tape
    variability = {v.name: TUNABLE if v.tunable else FIXED for v in program.parameters}
    names: list[str] = []
    found: dict[int, tuple[_Levels, int]] = {}  # what a node depends on; how it varies itself
    for k in tape.reachable(roots):
        operation = tape.operations[k]
        kind = operation[0]
        if kind == "constant":
            found[k] = (0, 0, 0, 0), CONSTANT
        elif kind == "symbol":
            found[k] = (1 << len(names), 0, 0, 0), variability.get(operation[1], DEPENDENT)
            names.append(operation[1])
        else:
            first, last = found[operation[1]], found[operation[-1]]
            found[k] = _levels(kind, first, last), max(first[1], last[1])
    return {k: _named(names, found[k][0]) for k in roots}


def _levels(kind: str, a: tuple[_Levels, int], b: tuple[_Levels, int]) -> _Levels:
    match kind:
        case "neg":
            return a[0]
        case "add" | "sub":
            return _union(a[0], b[0])
        case "mul":
            return _union(_scaled(a[0], b[1]), _scaled(b[0], a[1]))
        case "div":
            return _union(_scaled(a[0], b[1]), _scaled(b[0], DEPENDENT))
        case _:
            return _union(_scaled(a[0], DEPENDENT), _scaled(b[0], DEPENDENT))


def _scaled(levels: _Levels, variability: int) -> _Levels:
    """The levels of a product with a factor that varies so."""
    every, fixed, tunable, dependent = levels
    return (
        every,
        every if variability >= FIXED else fixed,
        every if variability >= TUNABLE else tunable,
        every if variability >= DEPENDENT else dependent,
    )


def _union(a: _Levels, b: _Levels) -> _Levels:
    return a[0] | b[0], a[1] | b[1], a[2] | b[2], a[3] | b[3]


def _named(names: list[str], levels: _Levels) -> dict[str, str]:
    every, *higher = levels
    found = {}
    while every:
        bit = every & -every
        every -= bit
        level = sum(1 for bits in higher if bits & bit)
        found[names[bit.bit_length() - 1]] = KINDS[level]
    return found
