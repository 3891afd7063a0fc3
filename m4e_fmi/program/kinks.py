"""Times at which a program has a kink or a jump, known before it runs.

Such times come from operations with corners (abs, sign, min, max) on what depends on time and on
parameters alone: rows of tables, ramps, switches. Corners of what moves are events of the run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.program.program import TIME, Program
from m4e_fmi.program.tape import Tape, evaluated

Floats = NDArray[np.float64]

CORNERS = frozenset({"abs", "sign", "min", "max"})
JUMPS = frozenset({"sign"})
BESIDE_JUMP = 0.5e-9
"""How far before and after a jump a step ends [s]: half a nanosecond, in which time is counted."""
BISECTIONS = 60
ROUNDING = 2
"""Units in the last place by which one corner may be found at two times."""
MOST_INNER = 2000
"""Inner corners of an operation, above which its own are not looked for."""
ARRAY_FUNCTIONS = {
    "neg": np.negative,
    "abs": np.abs,
    "sign": np.sign,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "tanh": np.tanh,
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "pow": np.power,
    "atan2": np.arctan2,
    "min": np.minimum,
    "max": np.maximum,
}


def kinks(program: Program, stop_time: float) -> list[float]:
    """The times [s] between 0 and `stop_time` that a step should end at, ascending.

    A kink is one time, a jump two: just before and just after it. Parameters have their start
    values. Between the corners of its own arguments, each corner is expected to be passed once.
    """
    found: set[float] = set()
    for node, times in _corner_times(program, stop_time).items():
        jumps = program.tape.operations[node][0] in JUMPS
        for time in times:
            width = max(BESIDE_JUMP, 4.0 * math.ulp(time))
            found |= {time - width, time + width} if jumps else {time}
    apart: list[float] = []
    for time in sorted(time for time in found if 0.0 < time < stop_time):
        if not apart or time - apart[-1] > ROUNDING * math.ulp(time):
            apart.append(time)
    return apart


def _corner_times(program: Program, stop_time: float) -> dict[int, list[float]]:
    """Operations with corners on nothing but time and parameters → the times [s] of these corners.

    They are roots of the difference of the arguments, from one corner within these to the next.
    """
    tape, fixed = program.tape, {v.name: v.start for v in program.parameters}
    found: dict[int, list[float]] = {}
    for node in _timely_corners(program, fixed):
        arguments = tape.arguments(node)
        inner = {time for k in tape.reachable(arguments) for time in found.get(k, ())}
        found[node] = []
        if len(inner) > MOST_INNER:
            continue
        lead = partial(_lead, tape, arguments, fixed)
        ends = np.array([0.0, *sorted(inner), stop_time])
        width = np.maximum(BESIDE_JUMP, 4.0 * np.spacing(ends))
        begin, end = ends[:-1] + width[:-1], ends[1:] - width[1:]
        before, after = lead(begin), lead(end)
        for k in np.flatnonzero((before * after < 0.0) & (begin < end)):
            found[node].append(_root(lead, begin[k], end[k], before[k], after[k]))
    return found


def _root(
    lead: Callable[[Floats], Floats], low: float, high: float, before: float, after: float
) -> float:
    """The root between two times of different signs: exact where the lead is a line."""
    guess = low - before * (high - low) / (after - before)
    scale = max(abs(before), abs(after))
    if abs(lead(np.array([guess]))[0]) <= 1e-12 * scale:
        return float(guess)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if lead(np.array([middle]))[0] * before > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _lead(tape: Tape, nodes: Sequence[int], fixed: Mapping[str, float], times: Floats) -> Floats:
    """The first of one or two nodes of time and parameters, less the second, at `times` (n,)."""
    with np.errstate(all="ignore"):
        found = evaluated(tape, nodes, {**fixed, TIME: times}, functions=ARRAY_FUNCTIONS)
    first, *others = (found[k] for k in nodes)
    return np.asarray(first - others[0] if others else first)


def _timely_corners(program: Program, fixed: Iterable[str]) -> list[int]:
    """The operations with corners that depend on time, and else on parameters only, ascending."""
    tape = program.tape
    needed = tape.reachable([*program.rates, *program.results])
    names = tape.symbols_of_each(k for k in needed if tape.operations[k][0] in CORNERS)
    return sorted(k for k, on in names.items() if TIME in on and on <= {TIME, *fixed})
