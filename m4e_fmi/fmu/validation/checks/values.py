"""Group `values`: nan, infinite, huge and tiny values, impossible steps, unknown references."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.calls.functions import DISCARD, WARNING
from m4e_fmi.fmu.importer.elements import owner
from m4e_fmi.fmu.validation.checks.parameters import noticed
from m4e_fmi.fmu.validation.context import Context
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.probe import FatalError, Probe, RefusedError

SPECIAL = (math.nan, math.inf, -math.inf, 5e-324, 1e300, -1e300)
MOST = 6
"""Inputs, parameters and states, each, that are given special values."""
STEPS = 3
SECONDS = 2.0
"""After which no further case is tried; values that make an FMU slow come last."""
ANSWERED = ("past_stop", "huge_step")
"""Impossible steps to which the standard gives the answer; importers must not ask for others."""
FATAL_REMEDY = "fmi2Error is enough: after fmi2Fatal the importer can only give up"
UNUSABLE = "FMI 2.0.4, section 2.1.3: fmi2Reset makes an FMU usable again after fmi2Error"


def check(context: Context) -> Iterator[Finding | str]:
    """Special values, steps and references that are not answered as FMI asks for."""
    exchange = not context.subject.steps
    baseline = _plain_run(context, exchange=exchange)
    yield from _references(context, exchange=exchange)
    yield from _special(context, baseline, exchange=exchange)
    if not exchange:
        yield from _steps(context, baseline)


def _plain_run(context: Context, *, exchange: bool) -> np.ndarray:
    with context.probe(exchange=exchange) as probe:
        return _go(context, probe)


def _go(context: Context, probe: Probe) -> np.ndarray:
    """From a new or reset instance through a few steps; all Reals at the end."""
    probe.begin()
    for _ in range(0 if probe.exchange else STEPS):
        probe.advance(context.subject.step_size)
    return probe.read(context.subject.readable)


def _chosen(variables: list[ModelVariable]) -> list[ModelVariable]:
    return variables[:: max(1, math.ceil(len(variables) / MOST))]


def _special(context: Context, baseline: np.ndarray, *, exchange: bool) -> Iterator[Finding]:
    subject = context.subject
    others = [v for v in subject.given if v.causality not in ("input", "parameter")]
    silent: list[str] = []
    fatal: list[str] = []
    unusable: list[str] = []
    untimely: list[str] = []
    began = time.monotonic()
    chosen = [*_chosen(subject.inputs), *_chosen(subject.parameters), *_chosen(others)]
    for value in SPECIAL:
        for v in chosen:
            if time.monotonic() - began > SECONDS:
                break
            context.library.journal.occasion = case = f"{v.name} = {value:g}"
            with context.probe(exchange=exchange) as probe:
                try:
                    heard = _with_special(context, probe, v, value)
                except FatalError:
                    fatal.append(case)
                    continue
                except RefusedError as error:
                    heard = True
                    if error.call.startswith("fmi2DoStep") and error.status == DISCARD:
                        untimely += [case] * (not _timely(context, probe))
                if not heard:
                    silent.append(case)
                if not _usable(context, probe, baseline):
                    unusable.append(case)
    context.library.journal.occasion = ""
    if silent:
        message = f"non-finite outputs are returned without an error status: {some(silent)}"
        yield Finding("values.silent", "warning", message, "answer fmi2Error or fmi2Discard")
    if fatal:
        message = f"is answered by fmi2Fatal: {some(fatal)}"
        yield Finding("values.fatal", "warning", message, FATAL_REMEDY)
    if untimely:
        message = (
            f"doStep answers fmi2Discard, but no time within the step is told: {some(untimely)}"
        )
        basis = "fmi2GetRealStatus(fmi2LastSuccessfulTime): FMI 2.0.4, section 4.2.2 and 4.2.3"
        yield Finding("values.discard_time", "error", message, basis)
    if unusable:
        message = f"after fmi2Reset it is not as it was before: {some(unusable)}"
        yield Finding("values.unusable", "error", message, UNUSABLE)


def _with_special(context: Context, probe: Probe, variable: ModelVariable, value: float) -> bool:
    """Step with a special value; False if non-finite outputs are returned without an error."""
    is_input = variable.causality == "input"
    probe.begin(None if is_input else {variable.valueReference: value})
    if is_input:
        probe.put([variable], np.array([value]))
    for _ in range(0 if probe.exchange else STEPS):
        probe.advance(context.subject.step_size)
    values = [probe.read(context.subject.outputs)]
    if probe.exchange:
        values.append(probe.rate_vector())
    return bool(np.isfinite(np.concatenate(values)).all()) or probe.listen() >= WARNING


def _timely(context: Context, probe: Probe) -> bool:
    """True if the FMU tells how far it came in the step that it discarded."""
    try:
        status, reached = probe.last_successful_time()
    except FatalError:
        return False
    slack = 1e-6 * context.subject.step_size
    low, high = probe.time - slack, probe.time + context.subject.step_size + slack
    return status <= WARNING and low <= reached <= high


def _usable(context: Context, probe: Probe, baseline: np.ndarray) -> bool:
    try:
        probe.reset()
        return _go(context, probe).tobytes() == baseline.tobytes()
    except RefusedError:
        return False


def _steps(context: Context, baseline: np.ndarray) -> Iterator[Finding]:
    """Steps that no importer should ask for; nan last, of which the standard says nothing."""
    size, t = context.subject.step_size, context.subject.start_time
    stop = t + 2 * size
    section = "FMI 2.0.4, section 4.2.2"
    cases: dict[str, tuple[Callable[[Probe], int], str, str]] = {
        "negative_step": (lambda p: p.step(-size), "a negative step", section),
        "past_stop": (
            lambda p: p.step(10 * size),
            "a step past the stop time",
            "FMI 2.0.4, section 2.1.6: has to return fmi2Error",
        ),
        "huge_step": (
            lambda p: p.step(1e300),
            "a step of 1e300 s, past the stop time",
            "FMI 2.0.4, section 2.1.6: has to return fmi2Error",
        ),
        "zero_step": (lambda p: p.step(0.0), "a step of 0 s", section),
        "nan_step": (lambda p: p.step(math.nan), "a step of nan", section),
    }
    for name, (action, what, basis) in cases.items():
        if context.late:
            return
        severity = "note" if name == "zero_step" else "warning"
        context.library.journal.unasked = name not in ANSWERED
        with context.probe() as probe:
            probe.begin(stop=stop)
            probe.advance(size)
            probe.words()
            try:
                refused = max(action(probe), noticed(probe)) > WARNING
            except FatalError:
                message = f"{what} is answered by fmi2Fatal"
                yield Finding(f"values.{name}", "warning", message, basis)
                continue
            if not refused:
                yield Finding(f"values.{name}", severity, f"{what} is accepted", basis)
            if not _usable(context, probe, baseline):
                message = f"after {what} and fmi2Reset it is not as it was before"
                severity = "error" if name in ANSWERED else "warning"
                yield Finding("values.unusable", severity, message, UNUSABLE)
    context.library.journal.unasked = False


def _references(context: Context, *, exchange: bool) -> Iterator[Finding]:
    absent = max((owner(v) for v in context.subject.readable), default=0) + 100_000
    basis = "FMI 2.0.4, section 2.1.7"
    cases: dict[str, Callable[[Probe], int]] = {
        "reading": lambda p: p.get([absent])[0],
        "setting": lambda p: p.set([absent], np.zeros(1), "of no variable"),
    }
    for name, action in cases.items():
        with context.probe(exchange=exchange) as probe:
            probe.begin()
            probe.words()
            try:
                refused = max(action(probe), noticed(probe)) > WARNING
            except FatalError:
                refused = True
                message = f"{name} a value reference that no variable has is answered by fmi2Fatal"
                yield Finding("values.fatal", "warning", message, FATAL_REMEDY)
            if not refused:
                message = f"{name} values accepts a value reference that no variable has"
                yield Finding("values.reference", "warning", message, basis)
