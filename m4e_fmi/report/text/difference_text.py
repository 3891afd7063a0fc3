"""A comparison of two files of results as text and as JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from m4e_fmi.analysis.comparison.measures import SCALES
from m4e_fmi.shown import one_line

if TYPE_CHECKING:
    from m4e_fmi.analysis.comparison import Comparison, Difference
    from m4e_fmi.analysis.comparison.measures import Phase

MOST_ROWS = 40
MOST_NAMES = 8
NO_SHIFT = 1e-6
"""Part of a period that is shown as 0."""
LONGEST_NAME = 40
"""Characters of a name in the table."""


def difference_text(found: Comparison) -> str:
    """Table of differences, the largest first, with notes and the verdict."""
    start, stop = _span(found)
    shown = found.worst[:MOST_ROWS]
    width = min(LONGEST_NAME, max(len(one.name) for one in shown))
    lines = [
        f"{found.path.name} beside {found.reference.name} (the reference), {start:g} to {stop:g} s",
        "",
        _head(found, width),
        *(_row(one, found, width) for one in shown),
    ]
    if (more := len(found.differences) - MOST_ROWS) > 0:
        lines.append(f"  and {more} with smaller differences: --json has them")
    notes = [*found.notes]
    for names, where in ((found.only_here, found.path), (found.only_there, found.reference)):
        if names:
            rest = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
            notes.append(f"only in {where.name}: {', '.join(names[:MOST_NAMES])}{rest}")
    lines += ["", *(f"note: {one_line(note)}" for note in notes)] if notes else []
    lines += ["", _verdict(found)] if found.tolerance is not None else []
    return "\n".join(lines)


def _span(found: Comparison) -> tuple[float, float]:
    times = [one.time for one in found.differences.values() if len(one.time)]
    if not times:
        return math.nan, math.nan
    return min(float(t[0]) for t in times), max(float(t[-1]) for t in times)


def _head(found: Comparison, width: int) -> str:
    share = f"of {found.relative_to}"
    first = f"{'first beyond':>13}" if found.tolerance is not None else ""
    return (
        f"  {'':<{width}} {'RMS':>11} {share:>12} {'largest':>11} {share:>12} {'at':>9} "
        f"{'Eq. (10)':>10} {'amplitude':>10} {'later by':>10}{first}"
    )


def _row(one: Difference, found: Comparison, width: int) -> str:
    name = one_line(one.name)
    name = name if len(name) <= width else f"{name[: width - 1]}…"
    ratio = _number(one.phase.amplitude_ratio, "10.5g", 10)
    later = _number(_rounded(one.phase), "8.3g", 8)
    first = ""
    if found.tolerance is not None:
        since = one.first_beyond(found.tolerance)
        first = f"{'' if since is None else f'{since:.5g} s':>13}"
    return (
        f"  {name:<{width}} {one.rms:11.4g} {_percent(one.rms_share):>12} "
        f"{one.largest:11.4g} {_percent(one.largest_share):>12} {one.largest_at:7.5g} s "
        f"{one.nrmse:10.3g} {ratio} {later}{' s' if later.strip() else '  '}{first}  {one.unit}"
    )


def _rounded(phase: Phase) -> float:
    """The time shift [s], 0 below a millionth of the period."""
    return 0.0 if abs(phase.time_shift) < NO_SHIFT * phase.period else phase.time_shift


def _number(value: float, form: str, width: int) -> str:
    return " " * width if math.isnan(value) else f"{value:{form}}"


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
