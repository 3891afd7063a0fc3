"""The time table FMU: signals given at certain times; what it computes is said in README.md.

`config` is what a system file says, and the numbers of it, from there or from a CSV file. Imports
m4e_fmi's columns, document, errors, program and units.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from m4e_fmi.fmu import FmuKind
from m4e_fmi.program import Program, Recorder, Scalar, Variable, sign
from m4e_fmus.table.config import NEXT_EVENT_TIME, Config, Rows, read_rows

NANOSECOND = 1e-9


def _build(config: Config, *, name: str, folder: Path, **_: object) -> Program:
    """The program of the table called `name`: outputs that depend on time only.

    Its file is relative to `folder`; InputError with all problems of the file. Times are rounded to
    nanoseconds. A row counts as reached from half a nanosecond before its time on, so that it does
    not matter how that time was added up.
    """
    rows = read_rows(config, folder)
    r = Recorder(name, f"time table of {', '.join(config.signals)}")
    times = [round(time, 9) for time in rows.times]
    reached = [0.5 * sign(r.time - (time - NANOSECOND / 2)) + 0.5 for time in times]
    inside = reached[0] - (0.5 * sign(r.time - (times[-1] + NANOSECOND / 2)) + 0.5)
    for signal, values in rows.values.items():
        value = _value(r.time, times, values, reached, held=config.between == "held")
        if config.beyond == "error":
            value = value / inside  # the same inside, infinite or nan outside
        r.output(_output(signal, config, times), value)
    jumps = _jumps(times, rows, held=config.between == "held")
    if jumps:
        text = "time of the next jump, or of the last if there are no more"
        r.output(Variable(NEXT_EVENT_TIME, "s", text, local=True), _next(jumps, times, reached))
    return r.program()


def _output(signal: str, config: Config, times: Sequence[float]) -> Variable:
    section = config.signals[signal]
    text = section.description or f"{section.column or signal} of the table"
    if config.beyond == "error":
        text += f", known from {times[0]:g} s to {times[-1]:g} s (beyond: error)"
    return Variable(signal, section.unit, text)


def _value(
    time: Scalar,
    times: Sequence[float],
    values: Sequence[float],
    reached: Sequence[Scalar],
    *,
    held: bool,
) -> Scalar:
    """The value of a signal: a sum over the intervals, all but one of which are multiplied by 0."""
    total = (1.0 - reached[0]) * values[0] + reached[-1] * values[-1]
    for k in range(len(times) - 1):
        span, rise = times[k + 1] - times[k], values[k + 1] - values[k]
        if span == 0.0:
            continue
        here = time.tape.constant(values[k])
        if not held and rise != 0.0:
            here = here + rise / span * (time - times[k])
        total = total + (reached[k] - reached[k + 1]) * here
    return total


def _jumps(times: Sequence[float], rows: Rows, *, held: bool) -> list[int]:
    """The rows before which, without time passing, a signal changes."""
    return [
        k
        for k in range(1, len(times))
        if (held or times[k] == times[k - 1])
        and any(values[k] != values[k - 1] for values in rows.values.values())
    ]


def _next(jumps: Sequence[int], times: Sequence[float], reached: Sequence[Scalar]) -> Scalar:
    """The time of the first of the jumps that is not reached, or of the last."""
    total = (1.0 - reached[jumps[0]]) * times[jumps[0]]
    for last, k in pairwise(jumps):
        total = total + (reached[last] - reached[k]) * times[k]
    return total + reached[jumps[-1]] * times[jumps[-1]]


KIND = FmuKind(Config, build=_build)
