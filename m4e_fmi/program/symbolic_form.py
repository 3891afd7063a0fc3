"""The SymPy form of a program: explicit expressions, to read or to compare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from m4e_fmi.program.program import Program

if TYPE_CHECKING:
    import sympy


@dataclass(frozen=True)
class SymbolicForm:
    """`symbols` maps a variable's name to its symbol; the lists are in the program's order."""

    symbols: dict[str, sympy.Symbol]
    rates: list[sympy.Expr]
    outputs: list[sympy.Expr]
    calculated: list[sympy.Expr]


def to_sympy(program: Program) -> SymbolicForm:
    """`program` as explicit SymPy expressions in real symbols named like its variables.

    Shared subexpressions are written out: meant for programs of a few hundred operations.
    """
    import sympy

    functions = {
        "neg": lambda a: -a,
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "div": lambda a, b: a / b,
        "pow": lambda a, b: a**b,
        "abs": sympy.Abs,
        "min": sympy.Min,
        "max": sympy.Max,
    }
    roots = [*program.rates, *program.results, *program.constants]
    symbols: dict[str, sympy.Symbol] = {}
    expressions: dict[int, sympy.Expr] = {}
    for k in program.tape.reachable(roots):
        kind, *arguments = program.tape.operations[k]
        if kind == "constant":
            value = arguments[0]
            expressions[k] = sympy.Integer(value) if value == int(value) else sympy.Float(value)
        elif kind == "symbol":
            name = arguments[0]
            symbols[name] = expressions[k] = sympy.Symbol(name, real=True)
        else:
            function = functions.get(kind) or getattr(sympy, kind)
            expressions[k] = function(*(expressions[a] for a in arguments))
    return SymbolicForm(
        symbols=symbols,
        rates=[expressions[k] for k in program.rates],
        outputs=[expressions[k] for k in program.results],
        calculated=[expressions[k] for k in program.constants],
    )
