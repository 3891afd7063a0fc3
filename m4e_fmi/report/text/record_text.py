"""Records as text and as JSON: a fitted free decay, and a comparison of two files."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from m4e_fmi.analysis.comparison.measures import SCALES
from m4e_fmi.analysis.decay.notes import decay_notes
from m4e_fmi.shown import columns, first_of, one_line

if TYPE_CHECKING:
    from m4e_fmi.analysis.comparison import Comparison, Difference
    from m4e_fmi.analysis.decay import Decay, Estimate
    from m4e_fmi.results.compared_file import Measured

MOST_DECREMENTS = 12
_LINEAR = {"m": "N.s/m", "rad": "N.m.s/rad"}
_QUADRATIC = {"m": "N.s2/m2", "rad": "N.m.s2/rad2"}
_MASS = {"m": "kg", "rad": "kg.m2"}
_STIFFNESS = {"m": "N/m", "rad": "N.m/rad"}

Row = tuple[str, str, "Estimate", str]
"""Key in JSON, name in the text, value, unit."""


def decay_text(decay: Decay, motion: Measured, *, mass: float, stiffness: float) -> str:
    """Table of the values, decrements, notes; `mass` [kg, kg.m2] and
    `stiffness` [N/m, N.m/rad] are 0 where they are not known."""
    unit, window = motion.unit, decay.window
    lines = [
        f"{motion.path.name}, {motion.name} [{unit}]: free decay from {window.start:.6g} to "
        f"{window.end:.6g} s, {window.reason}",
        "",
        *columns(
            "<>><",
            ("", "value", "standard error", ""),
            *(
                (name, f"{found.value:.6g}", f"{found.error:.2g}", of)
                for _, name, found, of in _rows(decay, unit, mass, stiffness)
            ),
        ),
        "",
        f"residual (root mean square): {100 * decay.residual_share:.3g} % of the release of "
        f"{decay.release:.4g} {unit}",
        *_decrements(decay, unit),
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
    measured = list(zip(peaks.between.tolist(), peaks.ratios.tolist(), strict=True))
    yield from columns(
        ">>>",
        (f"amplitude [{unit}]", "damping ratio", "as fitted"),
        *(
            (f"{amplitude:.5g}", f"{ratio:.5f}", f"{decay.equivalent_ratio(amplitude).value:.5f}")
            for amplitude, ratio in measured[:MOST_DECREMENTS]
        ),
    )
    if (more := len(peaks.between) - MOST_DECREMENTS) > 0:
        yield f"  and {more} of smaller amplitudes"


MOST_ROWS = 40
MOST_NAMES = 8
NO_SHIFT = 1e-6
"""Part of a period that is shown as 0."""
LONGEST_NAME = 40
"""Characters of a name in the table."""


def difference_text(found: Comparison) -> str:
    """Table of differences, the largest first, with notes and the verdict."""
    times = [one.time for one in found.differences.values() if len(one.time)]
    start = min((float(t[0]) for t in times), default=math.nan)
    stop = max((float(t[-1]) for t in times), default=math.nan)
    share = f"of {found.relative_to}"
    heads = ["", "RMS", share, "largest", share, "at", "Eq. (10)", "amplitude", "later by"]
    heads += ["first beyond"] if found.tolerance is not None else []
    rows = [_cells(one, found) for one in found.worst[:MOST_ROWS]]
    lines = [
        f"{found.path.name} beside {found.reference.name} (the reference), {start:g} to {stop:g} s",
        "",
        *columns(f"<{'>' * (len(heads) - 1)}<", [*heads, ""], *rows),
    ]
    if (more := len(found.differences) - MOST_ROWS) > 0:
        lines.append(f"  and {more} with smaller differences: --json has them")
    notes = [*found.notes]
    for names, where in ((found.only_here, found.path), (found.only_there, found.reference)):
        if names:
            notes.append(f"only in {where.name}: {first_of(names, MOST_NAMES)}")
    lines += ["", *(f"note: {one_line(note)}" for note in notes)] if notes else []
    lines += ["", _verdict(found)] if found.tolerance is not None else []
    return "\n".join(lines)


def _cells(one: Difference, found: Comparison) -> list[str]:
    """A row of the table."""
    name, phase = one_line(one.name), one.phase
    shift = 0.0 if abs(phase.time_shift) < NO_SHIFT * phase.period else phase.time_shift
    cells = [
        name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…",
        f"{one.rms:.4g}",
        _percent(one.rms_share),
        f"{one.largest:.4g}",
        _percent(one.largest_share),
        f"{one.largest_at:.5g} s",
        f"{one.nrmse:.3g}",
        "" if math.isnan(phase.amplitude_ratio) else f"{phase.amplitude_ratio:.5g}",
        "" if math.isnan(shift) else f"{shift:.3g} s",
    ]
    if found.tolerance is not None:
        since = one.first_beyond(found.tolerance)
        cells.append("" if since is None else f"{since:.5g} s")
    return [*cells, one.unit]


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %" if math.isfinite(share) else str(share)


def _verdict(found: Comparison) -> str:
    limit = f"{100.0 * (found.tolerance or 0.0):g} % of the {found.relative_to}"
    count, whole = len(found.beyond), len(found.differences)
    told = f"{count} of {whole} variables beyond {limit}"
    if not count:
        told = f"all {whole} variables are within {limit}"
    if not found.lacking:
        return told
    parts = " and ".join(f"{start:g} to {stop:g} s" for start, stop in found.lacking)
    return (
        f"not within: {found.path.name} lacks {parts} of the reference\n"
        f"  in the times of both, {told}\n"
        "  to compare only these, give --start-time or --stop-time"
    )


def difference_json(found: Comparison) -> dict[str, object]:
    """All numbers; null for those that are not defined."""
    return {
        "file": str(found.path),
        "reference": str(found.reference),
        "relative_to": found.relative_to,
        "tolerance": found.tolerance,
        "within": found.is_within if found.tolerance is not None else None,
        "variables": {name: _values(one, found) for name, one in found.differences.items()},
        "only_here": list(found.only_here),
        "only_there": list(found.only_there),
        "lacking": [list(span) for span in found.lacking],
        "notes": list(found.notes),
    }


def _values(one: Difference, found: Comparison) -> dict[str, object]:
    limit = found.tolerance
    numbers = {
        "rms": one.rms,
        "offset": one.offset,
        "rms_beside_offset": one.rms_beside_offset,
        "largest": one.largest,
        "largest_at": one.largest_at,
        "rms_share": one.rms_share,
        "largest_share": one.largest_share,
        **{name: getattr(one.sizes, name) for name in SCALES},
        **{f"rms_of_{name}": one.over(one.rms, name) for name in SCALES},
        **{f"largest_of_{name}": one.over(one.largest, name) for name in SCALES},
        "nrmse": one.nrmse,
        "period": one.phase.period,
        "amplitude_ratio": one.phase.amplitude_ratio,
        "time_shift": one.phase.time_shift,
        "share_at_period": one.phase.share,
        "interpolation_error": one.interpolation_error,
    }
    return {
        "reference_name": one.reference_name,
        "unit": one.unit,
        "rows": len(one.time),
        "left_out": one.left_out,
        "lacking": one.lacking,
        "interpolated": one.interpolated or None,
        **{key: value if math.isfinite(value) else None for key, value in numbers.items()},
        "no_phase_because": one.phase.reason or None,
        "within": None if limit is None else one.is_within(limit),
        "first_beyond": None if limit is None else one.first_beyond(limit),
    }
