"""Sheets of linear equations and modes."""

from __future__ import annotations

import numpy as np

from m4e_fmi.analysis import Linearization, Modes
from m4e_fmi.notebook.sheet import Sheet
from m4e_fmi.program import Variable

MOST_STATES = 12
"""Of a matrix that is shown."""


def linearization_sheet(linear: Linearization) -> Sheet:
    """The matrix A, and the names of states, inputs and outputs."""
    program = linear.point.program
    sizes = ", ".join(
        f"{name} {'×'.join(map(str, getattr(linear, name).shape))}" for name in "ABCD"
    )
    sheet = Sheet(f"Linear equations of {program.name}", f"t = {linear.point.time:g} s", sizes)
    names = [v.name for v in linear.states]
    if len(names) <= MOST_STATES:
        rows = [(name, *(float(x) for x in row)) for name, row in zip(names, linear.A, strict=True)]
        sheet.table(("A", *names), rows)
    for title in ("states", "inputs", "outputs"):
        variables: tuple[Variable, ...] = getattr(linear, title)
        rows = [(v.name, v.unit, v.description) for v in variables]
        sheet.table((f"{title} ({len(rows)})", "unit", "description"), rows)
    return sheet


def modes_sheet(modes: Modes) -> Sheet:
    """Frequency, period, damping ratio and main coordinate of each mode."""
    sheet = Sheet("Modes", "no motion grows" if modes.stable else "a motion grows")
    rows = []
    for k, value in enumerate(modes.eigenvalues.tolist()):
        hertz, ratio = abs(value) / (2 * np.pi), float(modes.damping_ratios[k])
        swings = value.imag != 0
        main = ""
        if modes.coordinates:
            main = modes.coordinates[int(np.abs(modes.shapes[:, k]).argmax())].name
        rows.append((
            str(k + 1), hertz if swings else None, 1 / hertz if swings else None,
            ratio if np.isfinite(ratio) else None, float(value.real), main,
        ))  # fmt: skip
    heads = ("mode", "frequency [Hz]", "period [s]", "damping ratio [1]", "growth [1/s]", "mostly")
    sheet.table(heads, rows)
    return sheet
