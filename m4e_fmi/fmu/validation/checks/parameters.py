"""Group `parameters`: tunable ones have an effect at any time, others cannot be set any more."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.messages import OK, WARNING
from m4e_fmi.fmu.validation.findings import Finding, about
from m4e_fmi.fmu.validation.probe import Context, Probe, RefusedError
from m4e_fmi.fmu.validation.subject import scale, start, within

STEPS = 4
CHANGE = 0.1
MOST = 30
"""Tunable parameters that are tried."""
BASIS = "FMI 2.0.4, section 2.2.7, variability and causality"


def check(context: Context) -> Iterator[Finding | str]:
    """Tunable parameters without effect, and others that can be set too late."""
    way = not context.subject.steps
    if context.subject.steps:
        yield from _tunable(context)
    yield from _not_settable(context, exchange=way)


def _tunable(context: Context) -> Iterator[Finding]:
    tunable = [v for v in context.subject.parameters if v.variability == "tunable"][:MOST]
    if not tunable:
        return
    inputs = context.random_inputs(2 * STEPS)
    plain = _run(context, inputs, None, 0)
    ignored, refused = [], []
    for v in tunable:
        try:
            late = _run(context, inputs, v, STEPS)
        except RefusedError as error:
            refused.append(f"{v.name} ({error})")
            continue
        if np.array_equal(late, plain) and not np.array_equal(_run(context, inputs, v, 0), plain):
            ignored.append(v.name)
    message = "tunable, but without effect when set between steps"
    yield from about(ignored, "parameters.tunable_ignored", "error", message, BASIS)
    message = "tunable, but refused between steps"
    yield from about(refused, "parameters.tunable_refused", "error", message, BASIS)


def _run(
    context: Context, inputs: np.ndarray, parameter: ModelVariable | None, when: int
) -> np.ndarray:
    """Last values of all but parameters, where one is changed after `when` steps (0: at first)."""
    change = {}
    if parameter is not None:
        value = within(parameter, start(parameter) + CHANGE * scale(parameter))
        change = {parameter.valueReference: value}
    with context.probe() as probe:
        probe.begin(change if when == 0 else None)
        for k, row in enumerate(inputs):
            if k == when and k and parameter is not None:
                probe.put([parameter], np.array(list(change.values())))
            probe.put(context.subject.inputs, row)
            probe.advance(context.subject.step_size)
        return probe.read([v for v in context.subject.readable if v.causality != "parameter"])


def _not_settable(context: Context, *, exchange: bool) -> Iterator[Finding]:
    """Set one variable of each kind that cannot be set any more, as an importer's mistake."""
    for what, variables in _kinds(context).items():
        if not variables:
            continue
        with context.probe(exchange=exchange) as probe:
            probe.begin()
            if not exchange:
                probe.advance(context.subject.step_size)
            probe.words()
            value = np.array([start(variables[0])])
            status = probe.set([variables[0].valueReference], value, variables[0].name)
            heard = _noticed(probe)
        if max(status, heard) <= WARNING:
            message = f"{what}, such as {variables[0].name}, can be set after initialization"
            yield Finding("parameters.settable", "warning", message, BASIS)
        elif status <= WARNING:
            message = f"{what} cannot be set after initialization; fmi2SetReal answers OK, but logs"
            yield Finding("parameters.told_by_log", "note", message + " an error", BASIS)


def _noticed(probe: Probe) -> int:
    """The worst status the FMU logged, also when it is only asked for values afterwards."""
    readable = probe.subject.outputs[:1]
    status, values = probe.get([v.valueReference for v in readable])
    return max(status, probe.listen(), OK if np.isfinite(values).all() else WARNING)


def _kinds(context: Context) -> dict[str, list[ModelVariable]]:
    subject = context.subject
    return {
        "fixed parameters": [v for v in subject.parameters if v.variability == "fixed"],
        "calculated parameters": subject.reals("calculatedParameter"),
        "outputs that are calculated": [v for v in subject.outputs if v.initial == "calculated"],
    }
