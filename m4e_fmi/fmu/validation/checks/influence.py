"""Groups `dependencies` and `directional`: how unknowns change when known values change.

There are three places where known values are set and unknown ones read: initialization mode (start
values → initial unknowns), a communication point of co-simulation (inputs → outputs),
continuous-time mode of model exchange (states and inputs → rates and outputs). What ModelStructure
declares, and directional derivatives, are compared with what changes there.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.elements import FmpyUnknown, owner
from m4e_fmi.fmu.importer.questions import moved
from m4e_fmi.fmu.validation.checks.samples import SAFETY, Slope, central
from m4e_fmi.fmu.validation.findings import Finding, about
from m4e_fmi.fmu.validation.probe import Context, Probe, RefusedError
from m4e_fmi.fmu.validation.subject import limits, scale, within

INITIAL, STEPPING, EXCHANGE = "initialization mode", "co-simulation", "model exchange"
APPROACH = 3
"""Steps before the communication point."""
POINTS, DIRECTIONAL_POINTS = 5, 2
SECONDS = 4.0
"""For one place; after it no new point is begun."""
CHANGE = 0.1
"""By how much of its scale a known is changed."""
SIGNIFICANT = 1e-9
"""Part of an unknown's own size below which a change may be rounding or iteration noise: a million
roundings, a tenth of the tolerance the FMU is asked for."""
LINEAR_KINDS = ("constant", "fixed", "tunable")
BASIS, DIRECTIONAL_BASIS = "FMI 2.0.4, section 2.2.8", "FMI 2.0.4, section 2.1.9"
STEPS = np.array([1.0, 2.0, 4.0]) * 2.0**-10
"""Of the differences, in scales of the known. The sixth root of the machine's precision, about
2⁻⁹, balances rounding with the error left by the extrapolation."""
CLEAR = 0.01
"""Differences tell something where their error is below this part of the column's largest entry."""
ADJOINT_BASIS = "FMI 3.0, fmi3GetAdjointDerivative"
CAPABILITY = "providesDirectionalDerivative"
ADJOINT = "providesAdjointDerivatives"


@dataclass
class WorkingPoint:
    """One of the three; `declared` are the entries of ModelStructure for its unknowns."""

    name: str
    context: Context
    knowns: list[ModelVariable]
    declared: list[FmpyUnknown]
    probe: Probe = field(init=False)

    def __post_init__(self) -> None:
        self.unknowns = [entry.variable for entry in self.declared]
        self._arrive()

    def _arrive(self) -> None:
        """Bring a new instance here."""
        context = self.context
        exchange = self.name == EXCHANGE or not context.subject.steps
        self.probe = context.new_probe(exchange=exchange)
        if self.name == INITIAL:
            self.probe.setup()
            self.probe.fmu.enter_initialization()
            return
        self.probe.begin()
        if self.name == STEPPING:
            for row in context.random_inputs(APPROACH):
                self.probe.put(context.subject.inputs, row)
                self.probe.advance(context.subject.step_size)

    def evaluate(self, values: np.ndarray) -> np.ndarray | None:
        """Unknowns (n_unknowns,), in their units; None where the FMU has no finite answer.

        The knowns are `values` (n_knowns,), in their units. After an answer that leaves the FMU
        unusable, there is a new instance.
        """
        count = len(self.context.subject.states) if self.name == EXCHANGE else 0
        try:
            if self.name == EXCHANGE:
                self.probe.set_states(values[:count])
            self.probe.put(self.knowns[count:], values[count:])
            found = self.probe.read(self.unknowns)
        except RefusedError:
            self.probe.free()
            self._arrive()
            return None
        return found if np.isfinite(found).all() else None

    def states_fit(self) -> bool:
        """True if the declared states are those of the state vector; `derivatives` tells if not."""
        states = self.context.subject.states
        self.probe.set_states(self.context.random(states)[0])
        variables = self.probe.read(states)
        return np.allclose(variables, self.probe.vector(), rtol=1e-12, atol=0.0)


def places(context: Context) -> Iterator[WorkingPoint]:
    """Those that the FMU has, one after the other."""
    subject, raw = context.subject, context.subject.raw
    continuous = [e for e in raw.outputs if e.variable.variability == "continuous"]
    wanted = []
    if subject.given and raw.initialUnknowns:
        wanted.append((INITIAL, subject.given, raw.initialUnknowns))
    if subject.steps and subject.inputs and continuous:
        wanted.append((STEPPING, subject.inputs, continuous))
    if subject.exchanges and (subject.states or subject.inputs):
        both = [*subject.states, *subject.inputs]
        wanted.append((EXCHANGE, both, [*continuous, *raw.derivatives]))
    for name, knowns, entries in wanted:
        place = WorkingPoint(
            name, context, knowns, [e for e in entries if e.variable.type == "Real"]
        )
        try:
            if name != EXCHANGE or place.states_fit():
                yield place
        finally:
            place.probe.free()


# ---- dependencies ----


_Measured = tuple[np.ndarray, np.ndarray, np.ndarray]
"""By unknown and known: where a change was seen, where it is not linear, and the slopes.

These have a further first axis, the points; nan where there was no answer.
"""


def check_dependencies(context: Context) -> Iterator[Finding | str]:
    """Dependencies that contradict what changes, and a reason if there are none."""
    found = False
    for place in places(context):
        found = True
        yield from _declared_findings(place, *_measure(place))
    if not found:
        yield "there is nothing that could depend on anything"


def _measure(place: WorkingPoint) -> _Measured:
    size = (len(place.unknowns), len(place.knowns))
    changes, bends = np.zeros(size, bool), np.zeros(size, bool)
    slopes: list[np.ndarray] = []
    began = time.monotonic()
    for values in place.context.random(place.knowns, POINTS):
        if slopes and time.monotonic() - began > SECONDS:
            break
        slope = np.full(size, np.nan)
        for k in range(len(place.knowns)):
            column = _column(place, values, k)
            if column is not None:
                changes[:, k] |= column[0]
                bends[:, k] |= column[1]
                slope[:, k] = column[2]
        slopes.append(slope)
    return changes, bends, np.array(slopes)


def _column(
    place: WorkingPoint, values: np.ndarray, k: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Of each unknown: whether it changes with known k, bends, and its slope."""
    known = place.knowns[k]
    up, down = values.copy(), values.copy()
    change = CHANGE * scale(known)
    up[k], down[k] = within(known, values[k] + change), within(known, values[k] - change)
    (middle, above, _), (_, below, again) = moved(place.evaluate, values, (up, down))
    if middle is None or above is None or below is None or again is None or up[k] == down[k]:
        return None
    largest = np.max(np.abs([middle, above, below]), axis=0)
    noise = 10 * np.abs(again - middle) + SIGNIFICANT * largest
    differs = np.maximum(np.abs(above - middle), np.abs(below - middle)) > noise
    span = up[k] - down[k]
    straight = below + (above - below) * (values[k] - down[k]) / span
    return differs, np.abs(straight - middle) > noise, (above - below) / span


def _declared_findings(
    place: WorkingPoint, changes: np.ndarray, bends: np.ndarray, slopes: np.ndarray
) -> Iterator[Finding]:
    undeclared, extra, unseen, wrong_kind = (list[str]() for _ in range(4))
    # arrays declare dependencies as a whole: one of a pair of elements is enough
    seen = {(owner(place.unknowns[row]), owner(place.knowns[k])) for row, k in np.argwhere(changes)}
    column = {known.name: k for k, known in enumerate(place.knowns)}
    for row, entry in enumerate(place.declared):
        unknown = entry.variable
        if entry.dependencies is None:
            undeclared.append(unknown.name)
            continue
        names = [v.name for v in entry.dependencies]
        for known, has_changed in zip(place.knowns, changes[row], strict=True):
            itself = known.valueReference == unknown.valueReference
            if has_changed and known.name not in names and not itself:
                extra.append(f"{unknown.name} ← {known.name}")
        for name, kind in zip(names, entry.dependenciesKind or [], strict=False):
            k = column.get(name)
            if (
                k is not None
                and kind in LINEAR_KINDS
                and _varies(changes[row, k], bends[row, k], slopes[:, row, k])
            ):
                wrong_kind.append(f"{unknown.name} ← {name} ({kind})")
        unseen += [
            f"{unknown.name} ← {v.name}"
            for v in entry.dependencies
            if v.name in column and (owner(unknown), owner(v)) not in seen
        ]
    where = f"in {place.name} {{count}}"
    message = f"{where} undeclared dependencies"
    yield from about(extra, "dependencies.missing", "error", message, BASIS)
    message, basis = f"{where} factors are not what is declared", f"{BASIS}, dependenciesKind"
    yield from about(wrong_kind, "dependencies.kind", "error", message, basis)
    if place.name != INITIAL:
        message = f"{where} declared dependencies were never seen"
        basis = "fewer make fewer algebraic loops"
        yield from about(unseen, "dependencies.unseen", "note", message, basis)
    message, basis = f"{where} unknowns declare no dependencies", f"{BASIS}: on all, then"
    yield from about(undeclared, "dependencies.undeclared", "note", message, basis)


def _varies(changes: np.bool, bends: np.bool, slopes: np.ndarray) -> bool:
    """True if the factor between two variables, whose `slopes` (n_points,) these are, varies."""
    slopes = slopes[np.isfinite(slopes)]
    if not len(slopes) or bends:
        return bool(bends)
    return bool(np.ptp(slopes) > 1e-6 * np.max(np.abs(slopes)) and changes)


# ---- directional derivatives ----


def check_directional(context: Context) -> Iterator[Finding | str]:
    """Directional derivatives that contradict differences."""
    works = context.works
    if not any(name.startswith((CAPABILITY, ADJOINT)) for name in works):
        yield f"{CAPABILITY} is not declared, or not there"
        return
    ways = (
        (CAPABILITY, DIRECTIONAL_BASIS, _directional_findings),
        (ADJOINT, ADJOINT_BASIS, _adjoint_findings),
    )
    for place in places(context):
        way = " (model exchange)" if place.probe.exchange else ""
        for capability, basis, findings in ways:
            try:
                if capability + way in works and place.unknowns:
                    yield from findings(place)
            except RefusedError as error:
                message = f"in {place.name}: {error}"
                yield Finding("directional.refused", "error", message, basis, error.words)


def _directional_findings(place: WorkingPoint) -> Iterator[Finding]:
    wrong, not_linear = list[str](), list[str]()
    began = time.monotonic()
    for values in place.context.random(place.knowns, DIRECTIONAL_POINTS):
        if time.monotonic() - began < SECONDS:
            wrong += _wrong_entries(place, values)
            not_linear += _not_linear(place, values)
    message = f"in {place.name} {{count}} entries contradict differences"
    yield from about(wrong, "directional.mismatch", "error", message, DIRECTIONAL_BASIS)
    if not wrong:
        message = f"in {place.name} not linear in the seed"
        yield from about(not_linear, "directional.linear", "error", message, DIRECTIONAL_BASIS)


def _adjoint_findings(place: WorkingPoint) -> Iterator[Finding]:
    wrong = _wrong_adjoint(place, place.context.random(place.knowns)[0])
    message = f"in {place.name} the adjoint contradicts differences"
    yield from about(wrong, "directional.adjoint", "error", message, ADJOINT_BASIS)


def _wrong_adjoint(place: WorkingPoint, values: np.ndarray) -> list[str]:
    """Knowns by which the derivative of a weighted sum of all unknowns is wrong."""
    estimates = [_differences(place, values, k) for k in range(len(place.knowns))]
    if place.evaluate(values) is None:
        return []
    seed = place.context.rng.uniform(0.5, 1.5, len(place.unknowns))
    told = place.probe.sensitivity(place.unknowns, place.knowns, seed, adjoint=True)
    found = []
    for known, slope, expected in zip(place.knowns, told, estimates, strict=True):
        if expected is None or (place.name == STEPPING and not expected.value.any()):
            continue
        error = SAFETY * (seed @ expected.error)
        largest = max(abs(slope), np.max(np.abs(expected.value)))
        if abs(slope - seed @ expected.value) > error and error < CLEAR * largest:
            found.append(f"by {known.name}")
    return found


def _wrong_entries(place: WorkingPoint, values: np.ndarray) -> list[str]:
    found = []
    for k, known in enumerate(place.knowns):
        expected = _differences(place, values, k)
        if expected is None or place.evaluate(values) is None:
            continue
        told = place.probe.sensitivity(place.unknowns, [known], np.ones(1))
        largest = max(np.max(np.abs(told)), np.max(np.abs(expected.value)))
        error = SAFETY * expected.error
        wrong = (np.abs(told - expected.value) > error) & (error < CLEAR * largest)
        if place.name == STEPPING and not expected.value.any():
            continue  # outputs that follow inputs only after a step
        found += [
            f"∂{v.name}/∂{known.name}" for v, w in zip(place.unknowns, wrong, strict=True) if w
        ]
    return found


def _differences(place: WorkingPoint, values: np.ndarray, k: int) -> Slope | None:
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


def _not_linear(place: WorkingPoint, values: np.ndarray) -> list[str]:
    """Unknowns whose derivative for two knowns at once is not the sum of that for each."""
    if len(place.knowns) < 2 or place.evaluate(values) is None:
        return []
    pair, seed = [place.knowns[0], place.knowns[-1]], np.array([2.0, -3.0])
    told = place.probe.sensitivity(place.unknowns, pair, seed)
    parts = np.array([place.probe.sensitivity(place.unknowns, [v], np.ones(1)) for v in pair])
    terms = np.abs(seed) @ np.abs(parts)
    # sums within the FMU may cancel: a hundred roundings of the largest, which grow with the seed
    rounding = np.finfo(float).eps * (SAFETY * terms + 100 * np.max(terms))
    wrong = np.abs(told - seed @ parts) > rounding
    return [v.name for v, w in zip(place.unknowns, wrong, strict=True) if w]
