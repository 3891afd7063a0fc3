"""An equilibrium as text and as values by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from m4e_fmi.analysis.attitudes import attitudes
from m4e_fmi.analysis.points import Evaluation, motion
from m4e_fmi.joints import ATTITUDE
from m4e_fmi.program import TIME

if TYPE_CHECKING:
    from m4e_fmi.analysis import OperatingPoint

NOISE = 1e-9
"""Share of the largest value of its unit, or of 1, below which a value is rounding."""


def equilibrium_values(point: OperatingPoint) -> dict[str, float]:
    """All states, inputs, parameters and outputs at `point` by name, in their units."""
    outputs = Evaluation(point.program).at(point).tolist()
    names = [v.name for v in point.program.outputs]
    return {**point.values, **dict(zip(names, outputs, strict=True))}


def note_lines(notes: Sequence[str]) -> list[str]:
    """An empty line, and a line for each note; nothing without notes."""
    return ["", *(f"note: {note}" for note in notes)] if notes else []


def equilibrium_text(
    point: OperatingPoint, *, varied: Sequence[str] = (), notes: Sequence[str] = ()
) -> str:
    """The pose, other states, and the outputs that are not zero, a line each; then `notes`.

    `varied` names parameters and inputs that were found for it.
    """
    program, values = point.program, equilibrium_values(point)
    free = attitudes(program)
    turned = {f"{a.owner}.{angle}" for a in free for angle in ATTITUDE}
    passed = {k for _, k in motion(program)}.union(*((*a.quaternion, *a.turning) for a in free))
    states = [v for k, v in enumerate(program.states) if not v.local and k not in passed]
    states += [v for v in program.outputs if v.name in turned]
    known = {v.name for v in program.states} | turned
    # rates are zero at rest
    outputs = [v for v in program.outputs if not (v.local or v.name in known or v.derivative_of)]
    largest: dict[str, float] = {}
    for v in (*states, *outputs):
        largest[v.unit] = max(largest.get(v.unit, 1.0), abs(values[v.name]))
    lines = [f"{program.name}: equilibrium, t = {point.time:g} s"]
    if any(TIME in program.dependencies(node) for node in program.rates):
        lines[0] += " (its loads depend on time: it is their balance at that time)"
    units = {v.name: v.unit for v in (*program.parameters, *program.inputs)}
    lines += [f"  {name:<40} {values[name]: .9g} {units[name]} (found)" for name in varied]
    for v in states:
        value = values[v.name]
        shown = 0.0 if abs(value) <= NOISE * largest[v.unit] else value
        lines.append(f"  {v.name:<40} {shown: .9g} {v.unit}")
    acting = [v for v in outputs if abs(values[v.name]) > NOISE * largest[v.unit]]
    if acting:
        lines.append("outputs that are not zero:")
        lines += [f"  {v.name:<40} {values[v.name]: .6g} {v.unit}" for v in acting]
    return "\n".join([*lines, *note_lines(notes)])
