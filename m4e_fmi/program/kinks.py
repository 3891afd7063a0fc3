"""Times at which a program has a kink or a jump, known before it runs.

Such times come from operations with corners (abs, sign, min, max) on what depends on time and on
parameters alone: rows of tables, ramps, switches. Corners of what moves are events of the run.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.program.program import TIME, Program

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
FUNCTIONS = {
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
    corners = _Corners(program, stop_time)
    found: set[float] = set()
    for node in corners.nodes:
        jumps = program.tape.operations[node][0] in JUMPS
        for time in corners.of(node):
            width = max(BESIDE_JUMP, 4.0 * math.ulp(time))
            found |= {time - width, time + width} if jumps else {time}
    return _apart(time for time in sorted(found) if 0.0 < time < stop_time)


def _apart(times: Iterable[float]) -> list[float]:
    """Ascending `times` without those that differ from the one before by rounding only."""
    kept: list[float] = []
    for time in times:
        if not kept or time - kept[-1] > ROUNDING * math.ulp(time):
            kept.append(time)
    return kept


class _Corners:
    """Operations with corners on nothing but time and parameters, and the times of these corners.

    `nodes` are these operations, in the order of the tape.
    """

    def __init__(self, program: Program, stop_time: float) -> None:
        self._tape, self._stop = program.tape, stop_time
        self._fixed: Mapping[str, float] = {v.name: v.start for v in program.parameters}
        self.nodes = _timely_corners(program, self._fixed)
        self._times: dict[int, list[float]] = {}
        for node in self.nodes:
            self._times[node] = self._found(node)

    def of(self, node: int) -> list[float]:
        """The times [s] at which an operation of `nodes` has its corner."""
        return self._times[node]

    def _found(self, node: int) -> list[float]:
        """Roots of the difference of the arguments, from one inner corner to the next."""
        inner = self._inner(node)
        if len(inner) > MOST_INNER:
            return []
        ends = np.array([0.0, *inner, self._stop])
        width = np.maximum(BESIDE_JUMP, 4.0 * np.spacing(ends))
        begin, end = ends[:-1] + width[:-1], ends[1:] - width[1:]
        before, after = self._lead(node, begin), self._lead(node, end)
        changed = np.flatnonzero((before * after < 0.0) & (begin < end))
        return [self._root(node, begin[k], end[k], before[k], after[k]) for k in changed]

    def _inner(self, node: int) -> list[float]:
        """Times of the corners within the arguments of `node`."""
        reached = self._tape.reachable(self._tape.arguments(node))
        return sorted({time for k in reached for time in self._times.get(k, ())})

    def _root(self, node: int, low: float, high: float, before: float, after: float) -> float:
        """The root between two times of different signs: exact where the lead is a line."""
        guess = low - before * (high - low) / (after - before)
        scale = max(abs(before), abs(after))
        if abs(self._lead(node, np.array([guess]))[0]) <= 1e-12 * scale:
            return float(guess)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            if self._lead(node, np.array([middle]))[0] * before > 0.0:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def _lead(self, node: int, times: Floats) -> Floats:
        """The first argument less the second, if there is one, at `times` (n,)."""
        arguments = self._tape.arguments(node)
        values = self._values(arguments, times)
        return values[0] - values[1] if len(values) > 1 else values[0]

    def _values(self, nodes: Sequence[int], times: Floats) -> list[Floats]:
        """Values of nodes of time and parameters at `times` (n,)."""
        found: dict[int, Floats] = {}
        with np.errstate(all="ignore"):
            for k in self._tape.reachable(nodes):
                kind, *arguments = self._tape.operations[k]
                if kind == "constant":
                    found[k] = np.full(len(times), arguments[0])
                elif kind == "symbol":
                    name = arguments[0]
                    value = times if name == TIME else np.full(len(times), self._fixed[name])
                    found[k] = value
                else:
                    found[k] = FUNCTIONS[kind](*(found[a] for a in arguments))
        return [found[k] for k in nodes]


def _timely_corners(program: Program, fixed: Mapping[str, float]) -> list[int]:
    """The operations with corners that depend on time, and else on parameters only, ascending."""
    operations = program.tape.operations
    how = bytearray(len(operations))  # nodes depend on what is: fixed 0, timely 1, moving 2
    found = []
    for k, operation in enumerate(operations):
        kind = operation[0]
        if kind == "symbol":
            name = operation[1]
            how[k] = 0 if name in fixed else 1 if name == TIME else 2
        elif kind != "constant":
            first, last = how[operation[1]], how[operation[-1]]
            how[k] = first if first > last else last
            if kind in CORNERS and how[k] == 1:
                found.append(k)
    if not found:
        return []
    needed = set(program.tape.reachable([*program.rates, *program.results]))
    return [k for k in found if k in needed]
