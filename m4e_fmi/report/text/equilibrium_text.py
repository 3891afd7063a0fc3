"""An equilibrium as text and as values by name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from m4e_fmi.analysis.attitudes import attitudes
from m4e_fmi.analysis.points import Evaluation, motion
from m4e_fmi.joints import ATTITUDE
from m4e_fmi.program import TIME

if TYPE_CHECKING:
    from m4e_fmi.analysis import OperatingPoint
    from m4e_fmi.program import Variable

NOISE = 1e-9
"""Share of the largest value of its unit, or of 1, below which a value is rounding."""
FOLDED = 4
"""Elements from which on an array of outputs has one line."""
ELEMENT = re.compile(r"\[[\d, ]+\]$")


def equilibrium_values(point: OperatingPoint) -> dict[str, float]:
    """All states, inputs, parameters and outputs at `point` by name, in their units."""
    outputs = Evaluation(point.program).at(point).tolist()
    names = [v.name for v in point.program.outputs]
    return {**point.values, **dict(zip(names, outputs, strict=True))}


def without_rounding(
    variables: Sequence[Variable], values: Mapping[str, float]
) -> dict[str, float]:
    """The `values` of `variables` by name, in their units; 0 for those that are rounding."""
    largest: dict[str, float] = {}
    for v in variables:
        largest[v.unit] = max(largest.get(v.unit, 1.0), abs(values[v.name]))
    found = {v.name: (values[v.name], NOISE * largest[v.unit]) for v in variables}
    return {name: value if abs(value) > least else 0.0 for name, (value, least) in found.items()}


def note_lines(notes: Sequence[str]) -> list[str]:
    """An empty line, and a line for each note; nothing without notes."""
    return ["", *(f"note: {note}" for note in notes)] if notes else []


def equilibrium_text(
    point: OperatingPoint, *, varied: Sequence[str] = (), notes: Sequence[str] = ()
) -> str:
    """The pose, other states, and the outputs that are not zero, a line each; then `notes`.

    An array of outputs, such as the nodes of a mooring line, has one line, of its range.
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
    given = {v.name: v for v in (*program.parameters, *program.inputs)}
    found = [given[name] for name in varied]
    shown = without_rounding((*states, *outputs, *found), values)
    lines = [f"{program.name}: equilibrium, t = {point.time:g} s"]
    if any(TIME in program.dependencies(node) for node in program.rates):
        lines[0] += " (its loads depend on time: it is their balance at that time)"
    lines += [f"  {v.name:<40} {shown[v.name]: .9g} {v.unit} (found)" for v in found]
    lines += [f"  {v.name:<40} {shown[v.name]: .9g} {v.unit}" for v in states]
    acting = [v for v in outputs if shown[v.name]]
    if acting:
        lines.append("outputs that are not zero:")
        lines += _output_lines(acting, values)
    return "\n".join([*lines, *note_lines(notes)])


def _output_lines(acting: Sequence[Variable], values: Mapping[str, float]) -> list[str]:
    """A line for each output, in its unit; of an array for its smallest and largest value."""
    arrays: dict[tuple[str, str], list[Variable]] = {}
    for v in acting:
        arrays.setdefault((ELEMENT.sub("", v.name), v.unit), []).append(v)
    lines, folded = [], 0
    for (name, unit), members in arrays.items():
        if len(members) < FOLDED:
            lines += [f"  {v.name:<40} {values[v.name]: .6g} {v.unit}" for v in members]
            continue
        folded += len(members)
        among = [values[v.name] for v in members]
        title = f"{name}[…]"
        lines.append(
            f"  {title:<40} {min(among): .6g} to {max(among):.6g} {unit} ({len(among)} values)"
        )
    if folded:
        lines.append(f"  the {folded} values of arrays: --json")
    return lines
