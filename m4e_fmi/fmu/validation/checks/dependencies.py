"""Group `dependencies`: what ModelStructure declares, against what changes when values change."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from m4e_fmi.fmu.importer.elements import owner
from m4e_fmi.fmu.validation.context import Context
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.fmu_under_test import scale, within
from m4e_fmi.fmu.validation.sampling.points import INITIAL, Place, places

POINTS = 5
SECONDS = 4.0
"""For one place; after it no new point is begun."""
CHANGE = 0.1
"""By how much of its scale a known is changed."""
SIGNIFICANT = 1e-9
"""Part of an unknown's own size below which a change may be rounding or iteration noise: a million
roundings, a tenth of the tolerance the FMU is asked for."""
LINEAR_KINDS = ("constant", "fixed", "tunable")
BASIS = "FMI 2.0.4, section 2.2.8"


@dataclass(frozen=True)
class _Measured:
    """By unknown and known: `changes` where it was seen to, `bends` where not linear.

    `slopes` has a further first axis, the points; nan where there was no answer.
    """

    changes: np.ndarray
    bends: np.ndarray
    slopes: np.ndarray


def check(context: Context) -> Iterator[Finding | str]:
    """Dependencies that contradict what changes, and a reason if there are none."""
    found = False
    for place in places(context):
        found = True
        yield from _place_findings(place, _measure(place))
    if not found:
        yield "there is nothing that could depend on anything"


def _measure(place: Place) -> _Measured:
    size = (len(place.unknowns), len(place.knowns))
    changes, bends = np.zeros(size, bool), np.zeros(size, bool)
    slopes: list[np.ndarray] = []
    began = time.monotonic()
    for values in place.context.random(place.knowns, POINTS):
        if slopes and time.monotonic() - began > SECONDS:
            break
        slope = np.full(size, np.nan)
        for k, known in enumerate(place.knowns):
            column = _column(place, values, k, CHANGE * scale(known))
            if column is not None:
                changes[:, k] |= column[0]
                bends[:, k] |= column[1]
                slope[:, k] = column[2]
        slopes.append(slope)
    return _Measured(changes, bends, np.array(slopes))


def _column(
    place: Place, values: np.ndarray, k: int, change: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Of each unknown: whether it changes with known k, bends, and its slope."""
    known = place.knowns[k]
    up, down = values.copy(), values.copy()
    up[k], down[k] = within(known, values[k] + change), within(known, values[k] - change)
    middle = place.evaluate(values)
    above, below = place.evaluate(up), place.evaluate(down)
    again = place.evaluate(values)
    if middle is None or above is None or below is None or again is None or up[k] == down[k]:
        return None
    largest = np.max(np.abs([middle, above, below]), axis=0)
    noise = 10 * np.abs(again - middle) + SIGNIFICANT * largest
    moved = np.maximum(np.abs(above - middle), np.abs(below - middle)) > noise
    span = up[k] - down[k]
    straight = below + (above - below) * (values[k] - down[k]) / span
    return moved, np.abs(straight - middle) > noise, (above - below) / span


def _place_findings(place: Place, measured: _Measured) -> Iterator[Finding]:
    undeclared: list[str] = []
    extra: list[str] = []
    unseen: list[str] = []
    wrong_kind: list[str] = []
    # arrays declare dependencies as a whole: one of a pair of elements is enough
    seen = {
        (owner(place.unknowns[row]), owner(place.knowns[k]))
        for row, k in np.argwhere(measured.changes)
    }
    column = {known.name: k for k, known in enumerate(place.knowns)}
    for row, entry in enumerate(place.declared):
        changes = measured.changes[row]
        if entry.dependencies is None:
            undeclared.append(entry.variable.name)
            continue
        names = [v.name for v in entry.dependencies]
        for k, known in enumerate(place.knowns):
            itself = known.valueReference == entry.variable.valueReference
            if changes[k] and known.name not in names and not itself:
                extra.append(f"{entry.variable.name} ← {known.name}")
        for name, kind in zip(names, entry.dependenciesKind or [], strict=False):
            k = column.get(name)
            if k is not None and kind in LINEAR_KINDS and _varies(measured, row, k):
                wrong_kind.append(f"{entry.variable.name} ← {name} ({kind})")
        unseen += [
            f"{entry.variable.name} ← {v.name}"
            for v in entry.dependencies
            if v.name in column and (owner(entry.variable), owner(v)) not in seen
        ]
    where = f"in {place.name}"
    if extra:
        message = f"{where} {len(extra)} undeclared dependencies: {some(extra)}"
        yield Finding("dependencies.missing", "error", message, BASIS)
    if wrong_kind:
        message = f"{where} {len(wrong_kind)} factors are not what is declared: {some(wrong_kind)}"
        yield Finding("dependencies.kind", "error", message, f"{BASIS}, dependenciesKind")
    if unseen and place.name != INITIAL:
        message = f"{where} {len(unseen)} declared dependencies were never seen: {some(unseen)}"
        yield Finding("dependencies.unseen", "note", message, "fewer make fewer algebraic loops")
    if undeclared:
        message = f"{where} {len(undeclared)} unknowns declare no dependencies: {some(undeclared)}"
        yield Finding("dependencies.undeclared", "note", message, f"{BASIS}: on all, then")


def _varies(measured: _Measured, row: int, k: int) -> bool:
    """True if the factor between two variables is not one number."""
    slopes = measured.slopes[:, row, k]
    slopes = slopes[np.isfinite(slopes)]
    if not len(slopes) or measured.bends[row, k]:
        return bool(measured.bends[row, k])
    return bool(np.ptp(slopes) > 1e-6 * np.max(np.abs(slopes)) and measured.changes[row, k])
