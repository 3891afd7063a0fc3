"""`compare`: two files of results, variable by variable."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_fmi.analysis.comparison.alignment import aligned
from m4e_fmi.analysis.comparison.differences import Comparison, Difference, Span
from m4e_fmi.analysis.comparison.matching import Pair, matched
from m4e_fmi.analysis.comparison.measures import (
    SCALES,
    Phase,
    Scales,
    normalised,
    phase,
    scales,
)
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.results.compared_file import ComparedFile, check_marks, read_compared
from m4e_fmi.results.results_file import Results
from m4e_fmi.shown import first_of

SMALL_PART = 0.05
"""Part of a reference that may be lacking, if that is less than two of its steps."""
_MOST_NAMED = 5


def compare(
    one: str | Path | Results,
    reference: str | Path | Results,
    *,
    variables: Sequence[str] | None = None,
    mapping: Mapping[str, str] | None = None,
    time_shift: float = 0.0,
    start_time: float | None = None,
    stop_time: float | None = None,
    tolerance: float | None = None,
    relative_to: str = "range",
    floor: float = 0.0,
) -> Comparison:
    """Differences of the variables of `one` file from those of a `reference`, at common times.

    Files are netCDF (ours), CSV of any tool, results in memory are accepted. `mapping`
    leads from names in the reference to names of `one`; others belong together by their names. A
    name in the reference may be followed by a factor and an offset, ``heave * -1 + 0.5``, of the
    value in our unit, and by ``, units ignored``. `time_shift` [s] is added to the times of the
    reference.
    `variables` are the names of `one` to compare, by default all; `start_time` and `stop_time` [s]
    narrow the interval. Differences are divided by the `relative_to` of the reference: its range,
    amplitude (√2 standard deviations) or value (largest magnitude); `tolerance` [1] is the largest
    share that is accepted; times of the reference that `one` lacks are not within any, unless the
    interval leaves them out. `floor` is the least divisor in Eq. (9) and (10) of S. Sabet and A.
    Diaz-Flores Caminero, "Multibody for Everybody", in the unit of each variable. InputError for
    files, names, units and numbers that are wrong, and without a common time.
    """
    _check(tolerance, relative_to, floor, start_time, stop_time, time_shift)
    a = read_compared(one)
    b = read_compared(reference)
    if time_shift:
        notes = (*b.notes, f"{time_shift:g} s added to its times")
        b = replace(b, time=b.time + time_shift, notes=notes)
    pairs = matched(a, b, mapping=mapping or {}, variables=variables)
    between = _interval(a, b, start_time, stop_time)
    found = {
        pair.variable.name: _difference(pair, a, b, between, relative_to, floor) for pair in pairs
    }
    taken = {pair.reference.name for pair in pairs}
    left_over, lacking = _left_over(a, b, start_time, stop_time)
    told = [f"{file.path.name}: {note}" for file in (a, b) for note in file.notes]
    return Comparison(
        path=a.path,
        reference=b.path,
        differences=found,
        relative_to=relative_to,
        tolerance=tolerance,
        only_here=tuple(n for n in a.quantities if n not in found) if variables is None else (),
        only_there=tuple(n for n in b.quantities if n not in taken) if variables is None else (),
        notes=(*told, *left_over, *_grouped_notes(found)),
        lacking=lacking,
    )


def _check(
    tolerance: float | None,
    relative_to: str,
    floor: float,
    start: float | None,
    stop: float | None,
    shift: float,
) -> None:
    wrong = []
    if relative_to not in SCALES:
        wrong.append(Problem(f"relative_to is {relative_to!r}", suggestion(relative_to, SCALES)))
    wrong += [
        Problem(f"the {name} is {value:g}, expected a number from 0 on")
        for name, value in (("tolerance", tolerance), ("floor", floor))
        if value is not None and not 0.0 <= value < math.inf
    ]
    if not math.isfinite(shift):
        wrong.append(Problem(f"time_shift is {shift:g} s, expected a finite number"))
    if start is not None and stop is not None and not start < stop:
        wrong.append(Problem(f"start_time {start:g} s is not before stop_time {stop:g} s"))
    InputError.raise_for(wrong)


def _interval(
    a: ComparedFile, b: ComparedFile, start: float | None, stop: float | None
) -> tuple[float, float]:
    """Common interval of both files within `start` and `stop` [s]; InputError if it is empty."""
    low = max(a.time[0], b.time[0], -math.inf if start is None else start)
    high = min(a.time[-1], b.time[-1], math.inf if stop is None else stop)
    if not low < high:
        spans = "; ".join(f"{f.path.name} has {f.time[0]:g} to {f.time[-1]:g} s" for f in (a, b))
        if max(a.time[0], b.time[0]) < min(a.time[-1], b.time[-1]):
            asked = f"{'' if start is None else f' from {start:g} s'}"
            asked += f"{'' if stop is None else f' until {stop:g} s'}"
            message = f"the files have no time in common{asked}: {spans}"
            raise InputError.single(message, "give a start_time or stop_time within both")
        remedy = "if these count from another origin, shift the reference: --time-shift S"
        raise InputError.single(f"the files have no time in common: {spans}", remedy)
    return float(low), float(high)


def _left_over(
    a: ComparedFile, b: ComparedFile, start: float | None, stop: float | None
) -> tuple[list[str], tuple[Span, ...]]:
    """A note if one file begins or ends more than two steps apart from the other.

    And the times of the reference `b` that `a` lacks there. Two steps of a reference with few rows
    are a large part of it: `SMALL_PART` is enough, then. Only within `start` and `stop` [s].
    """
    bounds = (-math.inf if start is None else start), (math.inf if stop is None else stop)
    first, last = (np.clip([f.time[k] for f in (a, b)], *bounds) for k in (0, -1))
    step, other_step = (float(np.median(np.diff(f.time))) for f in (a, b))
    least = max(2.0 * step, min(2.0 * other_step, SMALL_PART * float(last[1] - first[1])))
    if max(np.ptp(first), np.ptp(last)) <= least:
        return [], ()
    spans = ", ".join(f"{f.path.name} {f.time[0]:g} to {f.time[-1]:g} s" for f in (a, b))
    before, behind = (float(first[1]), float(first[0])), (float(last[0]), float(last[1]))
    lacking = tuple(span for span in (before, behind) if span[1] - span[0] > least)
    return [f"only {max(first):g} to {min(last):g} s are in both files: {spans}"], lacking


def _difference(
    pair: Pair,
    a: ComparedFile,
    b: ComparedFile,
    between: tuple[float, float],
    relative_to: str,
    floor: float,
) -> Difference:
    variable, reference = pair.variable, pair.reference
    check_marks(a, variable)
    check_marks(b, reference)
    held = variable.held or reference.held
    both = aligned(
        a.time, variable.values, b.time, pair.factor * reference.values + pair.offset,
        between=between, held=held,
    )  # fmt: skip
    rows = len(both.time)
    difference = both.values - both.reference
    rms = largest = at = nrmse = math.nan
    sizes, found = Scales(math.nan, math.nan, math.nan), Phase(reason="no common rows")
    if rows:
        worst = int(np.argmax(np.abs(difference)))
        rms = float(np.sqrt(np.mean(difference**2)))
        largest, at = float(abs(difference[worst])), float(both.time[worst])
        sizes = scales(both.time, both.reference)
        nrmse = float(normalised(np.array([rms]), max(sizes.value, floor))[0])
        found = (
            Phase(reason="whole numbers") if held else phase(both.time, both.values, both.reference)
        )
    return Difference(
        name=variable.name, reference_name=reference.name, unit=pair.unit,
        time=both.time, values=both.values, reference=both.reference,
        left_out=both.left_out, lacking=both.lacking, interpolated=both.interpolated,
        interpolation_error=both.error, rms=rms, largest=largest, largest_at=at,
        sizes=sizes, scale=getattr(sizes, relative_to), nrmse=nrmse, phase=found,
        notes=pair.notes,
    )  # fmt: skip


def _grouped_notes(found: Mapping[str, Difference]) -> list[str]:
    """Notes on matching, interpolation and gaps, those of several variables together."""
    by_text: dict[str, list[str]] = {}
    for name, one in found.items():
        texts = list(one.notes)
        if one.interpolated:
            texts.append(f"interpolated to the times of the coarser file, {one.interpolated}")
        if one.left_out:
            texts.append(f"{one.left_out} rows left out, as one of the files has a gap there")
        if one.lacking:
            texts.append(f"no finite value in {one.lacking} rows in which the reference has one")
        if not len(one.time):
            texts.append("no rows in common")
        for text in texts:
            by_text.setdefault(text, []).append(name)
    return [f"{first_of(names, _MOST_NAMED)}: {text}" for text, names in by_text.items()]
