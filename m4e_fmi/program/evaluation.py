"""The values of single nodes of a tape, in plain Python."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from m4e_fmi.program.tape import BINARY, UNARY, Tape


def evaluated(tape: Tape, nodes: Sequence[int], values: Mapping[str, float]) -> dict[int, float]:
    """The values of `nodes` for those of the symbols they need; nan where there is none."""
    found: dict[int, float] = {}
    for k in tape.reachable(nodes):
        kind, *arguments = tape.operations[k]
        if kind == "constant":
            found[k] = arguments[0]
        elif kind == "symbol":
            found[k] = values[arguments[0]]
        else:
            try:
                function = UNARY[kind] if len(arguments) == 1 else BINARY[kind]
                found[k] = function(*(found[a] for a in arguments))
            except (ValueError, ZeroDivisionError, OverflowError):
                found[k] = math.nan
    return {k: found[k] for k in nodes}
