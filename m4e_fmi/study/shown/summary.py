"""A study that has ended, as text: tables of what was wanted, the worst run, failures, time."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from m4e_fmi.cosim.error.report import share_text
from m4e_fmi.report.panels import aligned
from m4e_fmi.shown import columns
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.run import StudyOutcome
from m4e_fmi.study.shown.over_states import Averaged, averaged, over_states, shown_unit, states_of
from m4e_fmi.study.shown.warnings import MOST_TOLD, warning_lines
from m4e_fmi.study.start_up import left_out

MOST_ROWS = 40
"""Rows of a table."""


def summary(outcome: StudyOutcome) -> str:
    """Results of a study that has ended, then doubts, then how it was made."""
    study, count = outcome.study, outcome.study.grid.count
    made = count - outcome.kept
    kept = f", {outcome.kept} kept from before" if outcome.kept else ""
    results = [line for wanted in study.wanted for line in (*_of(outcome, wanted), "")]
    doubts = [*_failures(outcome), *warning_lines(outcome.warnings), *_worst(outcome)]
    lines = [f"{study.name}: {count} runs, {made} made{kept}, in {outcome.wall_time:.1f} s"]
    lines += [f"  {note}" for note in outcome.notes]
    lines += [f"  {study.grid.covered}"] if study.grid.covered else []
    if study.wanted:
        how = outcome.data.attrs["start_up"] if study.start_up is None else "as stated"
        lines += [f"  statistics leave out {left_out(outcome.data['start_up'].values, how)}"]
        rows = outcome.data.attrs["rows"]
        lines += [f"  statistics are of rows {rows}: extremes between them are not seen"]
    return "\n".join([*results, *doubts, *lines])


def _of(outcome: StudyOutcome, wanted: Wanted) -> Iterator[str]:
    """The tables of one quantity."""
    one, grid = outcome.data[wanted.name], outcome.study.grid
    found = averaged(grid.axes, one.values, grid.is_run)
    scale, unit = shown_unit(found, one.attrs["units"])
    seeds = any(axis.repeats and len(axis) > 1 for axis in grid.axes)
    how = ", mean over seeds ± 95 % confidence" if seeds else ""
    yield f"{wanted.name}{_bracketed(unit)}: {wanted}{how}"
    states = grid.probability
    shown_first = found.led_by(states[0]) if states else found  # a scatter diagram for each design
    yield from _table(shown_first.scaled(scale))
    if found.missing.any():
        count = int(found.missing.sum())
        yield f"  * without runs that failed or have no value: {count}"
    yield from _over_states(outcome, wanted)


def _over_states(outcome: StudyOutcome, wanted: Wanted) -> Iterator[str]:
    """One number of all sea states or cases for each other design, and the energy of a year."""
    states = states_of(outcome.data)
    if states is None:
        return
    grid, one = outcome.study.grid, outcome.data[wanted.name]
    for name, unit, found in over_states(grid, one.values, states, wanted, one.attrs["units"]):
        scale, unit = shown_unit(found, unit)
        if np.isnan(found.mean).all():
            means = averaged(grid.axes, one.values)
            missing = np.isnan(states.last(means.axes, means.mean))
            seeds = " of any seed" if any(axis.repeats for axis in grid.axes) else ""
            lacking = int(missing.reshape(-1, len(states.weights)).any(axis=0).sum())
            count = f"{lacking} of {len(states.weights)} states"
            yield f"  {name}: not known, {count} without a value{seeds}"
            return
        if found.axes:
            yield f"  {name}{_bracketed(unit)}:"
            yield from _table(found.scaled(scale))
        else:
            yield f"  {name}: {found.scaled(scale).cell(())} {unit}".rstrip()
        if found.missing.any():
            yield "  * for seeds that failed in a state stands the mean of the others there"


def _bracketed(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def _table(found: Averaged) -> Iterator[str]:
    """Lines of values over their axes: one number, a column, or matrices."""
    axes, count = found.axes, len(found.axes)
    if count == 0:
        yield f"  {found.cell(())}"
    elif count == 1 and len(axes[0]) > MOST_ROWS:
        yield from _spread(found)
    elif count == 1:
        rows = [[label, found.cell((k,))] for k, label in enumerate(axes[0].labels)]
        yield from columns(">>", (axes[0].name, ""), *rows)
    else:
        if math.prod(len(axis) for axis in axes) > MOST_TOLD * MOST_ROWS:
            yield from _spread(found)
            return
        others = list(np.ndindex(tuple(len(axis) for axis in axes[2:])))
        for rest in others[:MOST_TOLD]:
            told = [f"{axis.name} {axis.labels[k]}" for axis, k in zip(axes[2:], rest, strict=True)]
            if told:
                yield f"  {', '.join(told)}"
            head = [f"{axes[0].name} \\ {axes[1].name}", *axes[1].labels]
            rows = [
                [label, *(found.cell((i, j, *rest)) for j in range(len(axes[1])))]
                for i, label in enumerate(axes[0].labels)
            ]
            yield from columns(">" * len(head), head, *rows)
        if len(others) > MOST_TOLD:
            yield f"  … {len(others) - MOST_TOLD} further tables are in the file"


def _spread(found: Averaged) -> Iterator[str]:
    """Mean, spread and extremes of many designs."""
    good = found.mean[np.isfinite(found.mean)]
    if not len(good):
        yield "  no run has a value"
        return
    numbers = (good.mean(), good.std(ddof=1) if len(good) > 1 else 0.0, good.min(), good.max())
    mean, deviation, low, high = aligned(*map(float, numbers))
    yield (
        f"  over {len(good)} designs: mean {mean}, standard deviation {deviation}, {low} to {high}"
    )


def _worst(outcome: StudyOutcome) -> Iterator[str]:
    """The run with the largest coupling error."""
    errors = np.array([record.coupling_error for record in outcome.records])
    if np.isnan(errors).all():
        return
    run = int(np.nanargmax(errors))
    record = outcome.records[run]
    yield (
        f"largest coupling error {share_text(record.coupling_error)} of range, at "
        f"{record.coupling_at}, in the run of {outcome.study.grid.label(run)}"
    )


def _failures(outcome: StudyOutcome) -> Iterator[str]:
    if not outcome.failures:
        return
    yield f"{len(outcome.failures)} of {outcome.study.grid.count} runs failed:"
    for run, why in list(outcome.failures.items())[:MOST_TOLD]:
        yield f"  {outcome.study.grid.label(run)}: {why}"
    if len(outcome.failures) > MOST_TOLD:
        yield f"  … {len(outcome.failures) - MOST_TOLD} more: `failure` in the file"
