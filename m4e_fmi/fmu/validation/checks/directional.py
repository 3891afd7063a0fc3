"""Group `directional`: directional derivatives against central differences, everywhere."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from m4e_fmi.fmu.validation.context import Context
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.fmu_under_test import limits, scale
from m4e_fmi.fmu.validation.probe import RefusedError
from m4e_fmi.fmu.validation.sampling.differences import SAFETY, Estimate, central
from m4e_fmi.fmu.validation.sampling.points import STEPPING, Place, places

POINTS = 2
SECONDS = 4.0  # for one place; after it no new point is begun
STEPS = np.array([1.0, 2.0, 4.0]) * 2.0**-10
"""Of the differences, in scales of the known. The sixth root of the machine's precision, about
2⁻⁹, balances rounding with the error left by the extrapolation."""
CLEAR = 0.01
"""Differences tell something where their error is below this part of the column's largest entry."""
BASIS = "FMI 2.0.4, section 2.1.9"
ADJOINT_BASIS = "FMI 3.0, fmi3GetAdjointDerivative"
CAPABILITY = "providesDirectionalDerivative"
ADJOINT = "providesAdjointDerivatives"


def check(context: Context) -> Iterator[Finding | str]:
    """Directional derivatives that contradict differences."""
    works = context.facts.works
    if not any(name.startswith((CAPABILITY, ADJOINT)) for name in works):
        yield f"{CAPABILITY} is not declared, or not there"
        return
    for place in places(context):
        way = " (model exchange)" if place.probe.exchange else ""
        if CAPABILITY + way in works and place.unknowns:
            yield from _place_findings(place)
        if ADJOINT + way in works and place.unknowns:
            yield from _adjoint_findings(place)


def _place_findings(place: Place) -> Iterator[Finding]:
    wrong: list[str] = []
    not_linear: list[str] = []
    try:
        began = time.monotonic()
        for values in place.context.random(place.knowns, POINTS):
            if time.monotonic() - began < SECONDS:
                wrong += _wrong_entries(place, values)
                not_linear += _not_linear(place, values)
    except RefusedError as error:
        message = f"in {place.name}: {error}"
        yield Finding("directional.refused", "error", message, BASIS, error.words)
        return
    wrong = list(dict.fromkeys(wrong))
    if wrong:
        message = f"in {place.name} {len(wrong)} entries contradict differences: {some(wrong)}"
        yield Finding("directional.mismatch", "error", message, BASIS)
    elif not_linear:
        message = f"in {place.name} not linear in the seed: {some(dict.fromkeys(not_linear))}"
        yield Finding("directional.linear", "error", message, BASIS)


def _adjoint_findings(place: Place) -> Iterator[Finding]:
    values = place.context.random(place.knowns)[0]
    try:
        wrong = _wrong_adjoint(place, values)
    except RefusedError as error:
        message = f"the adjoint in {place.name}: {error}"
        yield Finding("directional.refused", "error", message, ADJOINT_BASIS, error.words)
        return
    if wrong:
        message = f"in {place.name} the adjoint contradicts differences: {some(wrong)}"
        yield Finding("directional.adjoint", "error", message, ADJOINT_BASIS)


def _wrong_adjoint(place: Place, values: np.ndarray) -> list[str]:
    """Knowns by which the derivative of a weighted sum of all unknowns is wrong."""
    estimates = [_differences(place, values, k) for k in range(len(place.knowns))]
    if place.evaluate(values) is None:
        return []
    seed = place.context.rng.uniform(0.5, 1.5, len(place.unknowns))
    told = place.probe.adjoint(place.unknowns, place.knowns, seed)
    found = []
    for known, slope, expected in zip(place.knowns, told, estimates, strict=True):
        if expected is None or (place.name == STEPPING and not expected.value.any()):
            continue
        error = SAFETY * (seed @ expected.error)
        largest = max(abs(slope), np.max(np.abs(expected.value)))
        if abs(slope - seed @ expected.value) > error and error < CLEAR * largest:
            found.append(f"by {known.name}")
    return found


def _wrong_entries(place: Place, values: np.ndarray) -> list[str]:
    found = []
    for k, known in enumerate(place.knowns):
        expected = _differences(place, values, k)
        if expected is None or place.evaluate(values) is None:
            continue
        told = place.probe.directional(place.unknowns, [known], np.ones(1))
        largest = max(np.max(np.abs(told)), np.max(np.abs(expected.value)))
        error = SAFETY * expected.error
        wrong = (np.abs(told - expected.value) > error) & (error < CLEAR * largest)
        if place.name == STEPPING and not expected.value.any():
            continue  # outputs that follow inputs only after a step
        found += [
            f"∂{v.name}/∂{known.name}" for v, w in zip(place.unknowns, wrong, strict=True) if w
        ]
    return found


def _differences(place: Place, values: np.ndarray, k: int) -> Estimate | None:
    known = place.knowns[k]
    steps = scale(known) * STEPS
    low, high = limits(known)
    if not low <= values[k] - steps[-1] <= values[k] + steps[-1] <= high:
        return None
    rows = []
    for sign in (1, -1):
        for step in steps:
            moved = values.copy()
            moved[k] += sign * step
            row = place.evaluate(moved)
            if row is None:
                return None
            rows.append(row)
    return central(np.array(rows[:3]), np.array(rows[3:]), steps)


def _not_linear(place: Place, values: np.ndarray) -> list[str]:
    """Unknowns whose derivative for two knowns at once is not the sum of that for each."""
    if len(place.knowns) < 2 or place.evaluate(values) is None:
        return []
    pair, seed = [place.knowns[0], place.knowns[-1]], np.array([2.0, -3.0])
    told = place.probe.directional(place.unknowns, pair, seed)
    parts = np.array([place.probe.directional(place.unknowns, [v], np.ones(1)) for v in pair])
    rounding = SAFETY * np.finfo(float).eps * (np.abs(seed) @ np.abs(parts))
    # sums within the FMU may cancel: a hundred roundings of the largest entry
    rounding = rounding + 100 * np.finfo(float).eps * np.max(np.abs(parts))
    wrong = np.abs(told - seed @ parts) > rounding
    return [v.name for v, w in zip(place.unknowns, wrong, strict=True) if w]
