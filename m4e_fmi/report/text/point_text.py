"""Equilibria, linear equations and their modes, as text and as JSON."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.analysis.attitudes import attitudes
from m4e_fmi.analysis.points import Evaluation, motion
from m4e_fmi.analysis.rest_notes import growth
from m4e_fmi.joints import ATTITUDE
from m4e_fmi.program import TIME
from m4e_fmi.shown import columns

if TYPE_CHECKING:
    from m4e_fmi.analysis import Linearization, Modes, OperatingPoint
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
    point: OperatingPoint,
    *,
    varied: Sequence[str] = (),
    notes: Sequence[str] = (),
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


LEAST_PART = 0.3
"""Part of coordinates and their velocities in a mode, from which on it counts as a motion."""
ROUNDING = 1e-12
"""Growth and decay below this part of the largest frequency, to which eigenvalues are found."""


def linear_text(linear: Linearization, modes: Modes, *, title: str) -> str:
    """The point, and a table of its modes; `title` says what point it is."""
    point = linear.point
    states = point.program.states
    values = without_rounding(states, point.values)
    coordinates = {v.name for v in linear.coordinates}
    lines = [f"{point.program.name}: {title}, t = {point.time:g} s"]
    lines += [
        f"  {v.name:<32} {values[v.name]: .9g} {v.unit}"
        for v in states
        if v.name in coordinates or v.unit == "1" or (values[v.name] and not v.local)
    ]
    lines += _table(linear, modes)
    found = growth(linear)
    unstable = "" if found is None or found.within else "UNSTABLE: "
    lines += ["", f"{unstable}{found or 'no motion grows'}"]
    return "\n".join(lines)


def _table(linear: Linearization, modes: Modes) -> list[str]:
    """The table of the modes; of a system with other states, of those that are motions."""
    n = linear.degrees_of_freedom
    has_others = len(linear.states) > 2 * n > 0
    rows = [["mode", "frequency", "period", "damping"], ["", "[Hz]", "[s]", "ratio"]]
    rows[0] += ["mostly"] if has_others else []
    rows[1] += [""] if has_others else []
    parts = modes.participation[:n] + modes.participation[n : 2 * n]
    least = ROUNDING * np.max(modes.frequencies, initial=0.0)
    for k, eigenvalue in enumerate(modes.eigenvalues, start=1):
        share = parts[:, k - 1]
        if has_others and share.sum() < LEAST_PART and not eigenvalue.real > 0:
            continue
        if abs(eigenvalue.real) <= least:
            eigenvalue = complex(0.0, eigenvalue.imag)
        hertz, oscillates = abs(eigenvalue) / (2 * np.pi), eigenvalue.imag != 0
        rows.append([
            str(k),
            f"{hertz:.6g}" if oscillates else "–",
            f"{1 / hertz:.6g}" if oscillates else "–",
            f"{0.0 - eigenvalue.real / abs(eigenvalue):.5f}" if eigenvalue else "–",
            *([linear.coordinates[int(np.argmax(share))].name] if has_others else []),
            f"{eigenvalue.real:.6g}" + (f" ± {eigenvalue.imag:.6g}i" if oscillates else ""),
        ])  # fmt: skip
    left_out = len(modes.eigenvalues) - (len(rows) - 2)
    rows[0].append("eigenvalue [1/s]")
    rows[1].append("")
    lines = ["", *columns(">>>><<" if has_others else ">>>><", *rows)]
    if left_out:
        lines.append(
            f"  and {left_out} in which other states, as the memory of water, have most part"
        )
    return lines


def linear_json(linear: Linearization, modes: Modes) -> dict[str, object]:
    """Everything as numbers, lists and texts; complex numbers as (real, imaginary), nan as null."""
    point, mechanical, found = linear.point, linear.mechanical, growth(linear)
    result: dict[str, object] = {
        "model": point.program.name,
        "time": point.time,
        "point": point.values,
        "rates": linear.rates.tolist(),
        "stable": modes.stable,
        "neutral": bool(found and found.within),
        "modes": [
            {
                "eigenvalue": [value.real, value.imag],
                "frequency_hz": abs(value) / (2 * np.pi),
                "damping_ratio": ratio if np.isfinite(ratio) else None,
                "shape": {
                    v.name: [entry.real, entry.imag]
                    for v, entry in zip(modes.coordinates, shape, strict=True)
                },
            }
            for value, ratio, shape in zip(
                modes.eigenvalues.tolist(),
                modes.damping_ratios.tolist(),
                modes.shapes.T.tolist(),
                strict=True,
            )
        ],
    }
    for name in ("states", "inputs", "outputs"):
        group: tuple[Variable, ...] = getattr(linear, name)
        result[name] = [{"name": v.name, "unit": v.unit} for v in group]
    result |= {name: getattr(linear, name).tolist() for name in "ABCD"}
    if mechanical is not None:
        names = ("M", "C", "K", "F", "S")
        result["mechanical"] = {name: getattr(mechanical, name).tolist() for name in names}
    return result
