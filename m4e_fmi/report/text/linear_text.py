"""Linear equations and their modes, as text and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.analysis.rest_notes import growth
from m4e_fmi.report.text.equilibrium_text import without_rounding

if TYPE_CHECKING:
    from m4e_fmi.analysis import Linearization, Modes
    from m4e_fmi.program import Variable

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
    name = f"  {'mostly':<32}" if has_others else ""
    lines = [
        "",
        f"  {'mode':>4} {'frequency':>12} {'period':>12} {'damping':>9} {name}  eigenvalue [1/s]",
        f"  {'':>4} {'[Hz]':>12} {'[s]':>12} {'ratio':>9}",
    ]
    parts = modes.participation[:n] + modes.participation[n : 2 * n]
    least = ROUNDING * np.max(modes.frequencies, initial=0.0)
    left_out = 0
    for k, eigenvalue in enumerate(modes.eigenvalues, start=1):
        if has_others:
            share = parts[:, k - 1]
            if share.sum() < LEAST_PART and not eigenvalue.real > 0:
                left_out += 1
                continue
            name = f"  {linear.coordinates[int(np.argmax(share))].name:<32}"
        if abs(eigenvalue.real) <= least:
            eigenvalue = complex(0.0, eigenvalue.imag)
        hertz = abs(eigenvalue) / (2 * np.pi)
        oscillates = eigenvalue.imag != 0
        frequency = f"{hertz:12.6g}" if oscillates else f"{'–':>12}"
        period = f"{1 / hertz:12.6g}" if oscillates else f"{'–':>12}"
        ratio = 0.0 - eigenvalue.real / abs(eigenvalue) if eigenvalue else np.nan
        shown = f"{ratio:9.5f}" if np.isfinite(ratio) else f"{'–':>9}"
        lines.append(f"  {k:>4} {frequency} {period} {shown} {name}  {_complex(eigenvalue)}")
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


def _complex(value: complex) -> str:
    if value.imag == 0:
        return f"{value.real:.6g}"
    return f"{value.real:.6g} ± {value.imag:.6g}i"
