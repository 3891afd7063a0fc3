"""Common subexpressions under names of their own, which make long equations readable."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import count
from typing import TYPE_CHECKING

from m4e_fmi.program import AnyScalar

if TYPE_CHECKING:
    import sympy

Shared = list[tuple["sympy.Symbol", "sympy.Expr"]]


def intermediates(
    expressions: Sequence[AnyScalar],
    coordinates: Sequence[sympy.Symbol],
    taken: Collection[str] = (),
) -> tuple[Shared, list[sympy.Expr]]:
    """Lines to compute first, in order, and the expressions in terms of them.

    Sine and cosine of coordinate k are `s<k>` and `c<k>`, all else that occurs more than once is
    `w1`, `w2`, …, unless it is a multiple of one symbol. Names in `taken`, or of symbols in the
    expressions, are left out. Nothing is expanded or simplified.
    """
    import sympy

    placeholders = sympy.numbered_symbols("shared", cls=sympy.Dummy)
    cse: AnyScalar = sympy.cse
    found, reduced = cse(expressions, symbols=placeholders, order="none", list=True)
    # of the lines: a walk over the expressions would meet what they share again and again
    lines = [*(line for _, line in found), *reduced]
    symbols = {s for line in lines for s in line.free_symbols if not isinstance(s, sympy.Dummy)}
    used = {*taken, *(s.name for s in symbols if isinstance(s, sympy.Symbol))}
    numbered = (name for k in count(1) if (name := f"w{k}") not in used)
    new: dict[sympy.Basic, sympy.Basic] = {}
    shared: Shared = []
    for placeholder, expression in found:
        value = expression.xreplace(new)
        _, rest = value.as_coeff_Mul()
        if rest.is_Symbol:
            new[placeholder] = value
            continue
        name = _of_angle(value, coordinates)
        symbol = sympy.Symbol(next(numbered) if name is None or name in used else name, real=True)
        used.add(symbol.name)
        new[placeholder] = symbol
        shared.append((symbol, value))
    return shared, [expression.xreplace(new) for expression in reduced]


def terms(expressions: Sequence[AnyScalar]) -> int:
    """Numbers and symbols in all of `expressions` as they are written out in full.

    Exact at any size: each expression that others share is counted once and then multiplied.
    """
    import sympy

    counts: dict[sympy.Basic, int] = {}
    waiting = [sympy.sympify(expression, strict=True) for expression in expressions]
    wanted = list(waiting)
    while waiting:
        expression = waiting[-1]
        missing = [part for part in expression.args if part not in counts]
        if missing:
            waiting += missing
        else:
            counts[expression] = sum(counts[part] for part in expression.args) or 1
            waiting.pop()
    return sum(counts[expression] for expression in wanted)


def _of_angle(value: sympy.Expr, coordinates: Sequence[sympy.Symbol]) -> str | None:
    """The name of the sine or cosine of a coordinate, None for anything else."""
    import sympy

    if isinstance(value, sympy.sin | sympy.cos):
        angle = value.args[0]
        if isinstance(angle, sympy.Symbol) and angle in coordinates:
            letter = "s" if isinstance(value, sympy.sin) else "c"
            return letter + angle.name.rpartition("_")[2]
    return None
