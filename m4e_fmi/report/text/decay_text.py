"""A fitted free decay as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from m4e_fmi.analysis.decay.notes import decay_notes

if TYPE_CHECKING:
    from m4e_fmi.analysis.decay import Decay, Estimate
    from m4e_fmi.results.compared_file import Measured

MOST_DECREMENTS = 12
TWO = 2.0
"""Standard errors within which a value counts as 0."""
NEGLIGIBLE = 1e-6
"""Damping ratio at the release that counts as 0."""
_LINEAR = {"m": "N.s/m", "rad": "N.m.s/rad"}
_QUADRATIC = {"m": "N.s2/m2", "rad": "N.m.s2/rad2"}
_MASS = {"m": "kg", "rad": "kg.m2"}
_STIFFNESS = {"m": "N/m", "rad": "N.m/rad"}

Row = tuple[str, str, "Estimate", str]
"""Key in JSON, name in the text, value, unit."""


def decay_text(decay: Decay, motion: Measured, *, mass: float, stiffness: float) -> str:
    """Table of the values, decrements, the line for a model, notes; `mass` [kg, kg.m2] and
    `stiffness` [N/m, N.m/rad] are 0 where they are not known."""
    unit, window = motion.unit, decay.window
    lines = [
        f"{motion.path.name}, {motion.name} [{unit}]: free decay from {window.start:.6g} to "
        f"{window.end:.6g} s, {window.reason}",
        "",
        f"  {'':<42} {'value':>13} {'standard error':>15}",
    ]
    for _, name, found, of in _rows(decay, unit, mass, stiffness):
        lines.append(f"  {name:<42} {found.value:13.6g} {found.error:15.2g}  {of}")
    lines += [
        "",
        f"residual (root mean square): {100 * decay.residual_share:.3g} % of the release of "
        f"{decay.release:.4g} {unit}",
        *_decrements(decay, unit),
        *_for_model(decay, motion, mass, stiffness),
    ]
    notes = [f"note: {note}" for note in (*motion.notes, *decay_notes(decay))]
    return "\n".join([*lines, *([""] if notes else []), *notes])


def decay_json(
    decay: Decay, motion: Measured, *, mass: float, stiffness: float
) -> dict[str, object]:
    """All numbers; arguments as `decay_text`."""
    rows = _rows(decay, motion.unit, mass, stiffness)
    return {
        "file": str(motion.path),
        "name": motion.name,
        "motion": motion.motion or None,
        "from": decay.window.start,
        "to": decay.window.end,
        "window": decay.window.reason,
        "values": {
            key: {"value": found.value, "standard_error": found.error, "unit": of}
            for key, _, found, of in rows
        },
        "release": decay.release,
        "residual_share": decay.residual_share,
        "correlation": decay.correlation,
        "trend": {"value": decay.trend.value, "standard_error": decay.trend.error},
        "amplitudes": decay.peaks.amplitudes.tolist(),
        "decrements": {
            "amplitude": decay.peaks.between.tolist(),
            "half_period": decay.peaks.decrements.tolist(),
        },
        "notes": [*motion.notes, *decay_notes(decay)],
    }


def _rows(decay: Decay, unit: str, mass: float, stiffness: float) -> Iterator[Row]:
    yield "period", "undamped period", decay.period, "s"
    yield "damped_period", "damped period, small motions", decay.damped_period, "s"
    yield "damping_ratio", "linear damping ratio", decay.damping_ratio, "1"
    yield "quadratic", "quadratic damping over inertia", decay.quadratic, f"1/{unit}"
    yield "rest", "motion at rest", decay.rest, unit
    surest = decay.surest_amplitude
    if surest > 0.0:
        name = f"equivalent damping ratio at {surest:.3g} {unit}"
        yield "equivalent_ratio", name, decay.equivalent_ratio(surest), "1"
    if mass or stiffness:
        given = f"of {mass:g} {_MASS[unit]}" if mass else f"on {stiffness:g} {_STIFFNESS[unit]}"
        of = {"mass": mass, "stiffness": stiffness}
        yield (
            "linear_coefficient",
            f"linear damping {given}",
            decay.linear_coefficient(**of),
            _LINEAR[unit],
        )
        yield (
            "quadratic_coefficient",
            f"quadratic damping {given}",
            decay.quadratic_coefficient(**of),
            _QUADRATIC[unit],
        )


def _decrements(decay: Decay, unit: str) -> Iterator[str]:
    """Logarithmic decrements of half a period by amplitude, measured and as fitted."""
    peaks = decay.peaks
    if len(peaks.between) == 0:
        return
    yield ""
    yield f"  {f'amplitude [{unit}]':>16} {'damping ratio':>15} {'as fitted':>12}"
    measured = peaks.ratios.tolist()
    for amplitude, ratio in list(zip(peaks.between.tolist(), measured, strict=True))[
        :MOST_DECREMENTS
    ]:
        fitted = decay.equivalent_ratio(amplitude).value
        yield f"  {amplitude:16.5g} {ratio:15.5f} {fitted:12.5f}"
    if (more := len(peaks.between) - MOST_DECREMENTS) > 0:
        yield f"  and {more} of smaller amplitudes"


def _for_model(decay: Decay, motion: Measured, mass: float, stiffness: float) -> Iterator[str]:
    """The key of `kind: hydrodynamics` that has the quadratic damping."""
    if not (mass or stiffness):
        return
    found = decay.quadratic_coefficient(mass=mass, stiffness=stiffness)
    highest = max(0.0, found.value + TWO * found.error)
    name = motion.motion or ("heave" if motion.unit == "m" else "pitch")
    yield ""
    of_release = decay.equivalent_ratio(decay.release).value - decay.damping_ratio.value
    if found.value < TWO * found.error or of_release < NEGLIGIBLE:
        yield (
            "for a body of kind: hydrodynamics: no drag, as quadratic damping is 0 within two "
            f"standard errors; at most {{{name}: {highest:.3g}}}"
        )
    else:
        yield f"for a body of kind: hydrodynamics:  drag: {{{name}: {found.value:.6g}}}"
