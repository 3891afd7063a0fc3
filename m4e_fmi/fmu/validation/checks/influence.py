"""Groups `dependencies` and `directional`: how unknowns change when known values change.

There are three places where known values are set and unknown ones read: initialization mode (start
values → initial unknowns), a communication point of co-simulation (inputs → outputs),
continuous-time mode of model exchange (states and inputs → rates and outputs). What ModelStructure
declares, and directional derivatives, are compared with what changes there.

Differences have an error estimate from the values themselves (Richardson). Source: L. F.
Richardson, "The deferred approach to the limit", Phil. Trans. R. Soc. A 226 (1927).
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.elements import FmpyUnknown, owner
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
BASIS, DIRECTIONAL_BASIS = "FMI 2.0.4, section 2.2.8", "FMI 2.0.4, section 2.1.9"
STEPS = np.array([1.0, 2.0, 4.0]) * 2.0**-10
"""Of the differences, in scales of the known. The sixth root of the machine's precision, about
2⁻⁹, balances rounding with the error left by the extrapolation."""
SAFETY = 10.0
"""Between an error estimate and what is called a contradiction."""
CLEAR = 0.01
"""Differences tell something where their error is below this part of the column's largest entry."""
CAPABILITY = "providesDirectionalDerivative"


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
        self.probe = Probe(context, exchange=exchange)
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
        """True if the declared states are those of the state vector; `start` tells if not."""
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


def check_dependencies(context: Context) -> Iterator[Finding | str]:
    """Dependencies that contradict what changes, and a reason if there are none."""
    found = False
    for place in places(context):
        found = True
        yield from _declared_findings(place, _measure(place))
    if not found:
        yield "there is nothing that could depend on anything"


def _measure(place: WorkingPoint) -> np.ndarray:
    """By unknown and known: where a change was seen, booleans (n_unknowns, n_knowns)."""
    changes = np.zeros((len(place.unknowns), len(place.knowns)), bool)
    began = time.monotonic()
    for number, values in enumerate(place.context.random(place.knowns, POINTS)):
        if number and time.monotonic() - began > SECONDS:
            break
        for k in range(len(place.knowns)):
            changes[:, k] |= _changed(place, values, k)
    return changes


def _changed(place: WorkingPoint, values: np.ndarray, k: int) -> np.ndarray:
    """Unknowns that change with known k, booleans (n_unknowns,); none without an answer."""
    known, found = place.knowns[k], [place.evaluate(values)]
    for sign in (1, -1):
        other = values.copy()
        other[k] = within(known, values[k] + sign * CHANGE * scale(known))
        found += [place.evaluate(other), place.evaluate(values)]
    rows = [row for row in found if row is not None]
    if len(rows) < len(found):
        return np.zeros(len(place.unknowns), bool)
    middle, above, _, below, again = rows
    largest = np.max(np.abs([middle, above, below]), axis=0)
    noise = 10 * np.abs(again - middle) + SIGNIFICANT * largest
    return np.maximum(np.abs(above - middle), np.abs(below - middle)) > noise


def _declared_findings(place: WorkingPoint, changes: np.ndarray) -> Iterator[Finding]:
    undeclared, extra, unseen = (list[str]() for _ in range(3))
    # arrays declare dependencies as a whole: one of a pair of elements is enough
    seen = {(owner(place.unknowns[row]), owner(place.knowns[k])) for row, k in np.argwhere(changes)}
    known_names = {known.name for known in place.knowns}
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
        unseen += [
            f"{unknown.name} ← {v.name}"
            for v in entry.dependencies
            if v.name in known_names and (owner(unknown), owner(v)) not in seen
        ]
    where = f"in {place.name} {{count}}"
    message = f"{where} undeclared dependencies"
    yield from about(extra, "dependencies.missing", "error", message, BASIS)
    if place.name != INITIAL:
        message = f"{where} declared dependencies were never seen"
        basis = "fewer make fewer algebraic loops"
        yield from about(unseen, "dependencies.unseen", "note", message, basis)
    message, basis = f"{where} unknowns declare no dependencies", f"{BASIS}: on all, then"
    yield from about(undeclared, "dependencies.undeclared", "note", message, basis)


# ---- directional derivatives ----


def check_directional(context: Context) -> Iterator[Finding | str]:
    """Directional derivatives that contradict differences."""
    if not any(name.startswith(CAPABILITY) for name in context.works):
        yield f"{CAPABILITY} is not declared, or not there"
        return
    for place in places(context):
        way = " (model exchange)" if place.probe.exchange else ""
        if CAPABILITY + way not in context.works or not place.unknowns:
            continue
        wrong, began = list[str](), time.monotonic()
        try:
            for values in context.random(place.knowns, DIRECTIONAL_POINTS):
                if time.monotonic() - began < SECONDS:
                    wrong += _wrong_entries(place, values)
        except RefusedError as error:
            message = f"in {place.name}: {error}"
            yield Finding("directional.refused", "error", message, DIRECTIONAL_BASIS, error.words)
        message = f"in {place.name} {{count}} entries contradict differences"
        yield from about(wrong, "directional.mismatch", "error", message, DIRECTIONAL_BASIS)


def _wrong_entries(place: WorkingPoint, values: np.ndarray) -> list[str]:
    """Unknowns and knowns whose directional derivative at `values` (n_knowns,) is wrong."""
    found = []
    for k, known in enumerate(place.knowns):
        differences = _differences(place, values, k)
        if differences is None or place.evaluate(values) is None:
            continue
        expected, error = differences
        told = place.probe.sensitivity(place.unknowns, [known])
        largest = max(np.max(np.abs(told)), np.max(np.abs(expected)))
        wrong = (np.abs(told - expected) > SAFETY * error) & (SAFETY * error < CLEAR * largest)
        if place.name == STEPPING and not expected.any():
            continue  # outputs that follow inputs only after a step
        found += [
            f"∂{v.name}/∂{known.name}" for v, w in zip(place.unknowns, wrong, strict=True) if w
        ]
    return found


def _differences(
    place: WorkingPoint, values: np.ndarray, k: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """Derivatives (n_unknowns,) by known k from central differences, and a bound on their error.

    The error covers the extrapolation, the differences between the three steps, and rounding in the
    largest of all values: small values may be differences of large ones. None where the steps leave
    the limits of the known, or the FMU has no answer.
    """
    known = place.knowns[k]
    steps = scale(known) * STEPS
    low, high = limits(known)
    if not low <= values[k] - steps[-1] <= values[k] + steps[-1] <= high:
        return None
    rows = []
    for step in (*steps, *-steps):
        moved = values.copy()
        moved[k] += step
        row = place.evaluate(moved)
        if row is None:
            return None
        rows.append(row)
    differences = (np.array(rows[:3]) - np.array(rows[3:])) / (2 * steps[:, None])
    fine, middle, coarse = differences
    once, before = (4 * fine - middle) / 3, (4 * middle - coarse) / 3
    rounding = SAFETY * np.finfo(float).eps * np.max(np.abs(rows)) / steps[0]
    error = np.abs(once - before) + rounding + np.ptp(differences, axis=0)
    return (16 * once - before) / 15, error
