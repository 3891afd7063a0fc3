"""Group `start`: the FMU can be loaded, instantiated and stepped, and does what it declares."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np

from m4e_fmi.fmu.importer.messages import ERROR
from m4e_fmi.fmu.importer.opening import remedy_for
from m4e_fmi.fmu.validation.findings import SHOWN, Finding, about
from m4e_fmi.fmu.validation.probe import (
    FACTS,
    Context,
    Probe,
    RefusedError,
    refused,
)
from m4e_fmi.fmu.validation.subject import CLASSES, WRITTEN, scale, start
from m4e_fmi.shown import first_of

STEPS = 10
AMPLITUDES = (1.0, 0.1, 0.01, 1e-4, 0.0)
EPS = float(np.finfo(float).eps)


def check(context: Context) -> Iterator[Finding]:
    """Findings; the file of facts for the other groups, unless the FMU does not even start."""
    subject = context.subject
    try:
        version = _version(context)
    except Exception as error:  # noqa: BLE001  FMPy raises plain exceptions
        text = str(error).replace(str(subject.folder), "")
        remedy = remedy_for(text, subject.raw.fmiVersion)
        yield Finding("start.library", "error", f"cannot be loaded: {text}", remedy)
        return
    if version != (subject.raw.fmiVersion, "default"):
        message = f"GetVersion and GetTypesPlatform answer {version}"
        yield Finding("start.version", "error", message, "FMI 2.0.4, section 2.1.2 and 2.1.4")
    others: list[str] = []
    for exchange in subject.ways:
        try:
            _first_steps(context, exchange=exchange)
        except RefusedError as error:
            how = " (model exchange)" if exchange else " (co-simulation)"
            assumed = subject.steps and not subject.variable_steps and not subject.declared_step
            if assumed and error.call.partition("(")[0].endswith("DoStep"):
                yield _assumed_step(context, error)
            else:
                yield refused("start", error, how)
            return
        with suppress(RefusedError):  # who gives no values yet is not asked for them
            others += _other_starts(context, exchange=exchange)
        yield from _own_runs(context, exchange=exchange)
    message = "a new instance has other values than declared"
    basis = "a start value is that of the FMU until another is set: FMI 2.0.4, section 2.2.7"
    yield from about(others, "start.values", "error", message, basis)
    for exchange in subject.ways:
        yield from _capabilities(context, exchange=exchange)
    if subject.exchanges and subject.states:
        yield from _order_of_states(context)
    facts = {"amplitude": context.amplitude, "works": context.works}
    (context.folder / FACTS).write_text(json.dumps(facts))


def _assumed_step(context: Context, error: RefusedError) -> Finding:
    """The finding that a step was refused of which nobody knows whether the FMU makes it."""
    message = (
        f"the checks that make steps were left out: {error}, but that step of "
        f"{context.subject.step_size:g} s was assumed, because the FMU makes steps of one "
        "size only (canHandleVariableCommunicationStepSize) and its description does not give it"
    )
    basis = "give stepSize in DefaultExperiment of modelDescription.xml, and validate again"
    return Finding("start.step_unknown", "warning", message, basis, error.words)


def _version(context: Context) -> tuple[str, str]:
    """The answers of the library; Exception if it cannot be loaded, or lacks functions."""
    raw = context.subject.raw
    classes = [CLASSES[raw.fmiVersion][exchange] for exchange in context.subject.ways]
    dll = context.loaded(exchange=context.subject.exchanges).library
    names = {n for one in classes for n in dir(one) if n.startswith(f"fmi{raw.fmiVersion[0]}")}
    if missing := sorted(name for name in names if not hasattr(dll, name)):
        raise AttributeError(
            f"it does not export {first_of(missing, SHOWN)}, as all libraries have to"
        )
    context.journal("GetVersion()")
    if context.subject.fmi_3:
        return _text(dll.fmi3GetVersion()), "default"
    return _text(dll.fmi2GetVersion()), _text(dll.fmi2GetTypesPlatform())


def _text(answer: bytes | None) -> str:
    return "NULL" if answer is None else answer.decode("utf-8", "replace")


def _first_steps(context: Context, *, exchange: bool) -> None:
    """Twice through all phases, at the largest amplitude of inputs at which that is possible."""
    amplitudes = (context.amplitude,) if exchange and context.subject.steps else AMPLITUDES
    for amplitude in amplitudes:
        context.amplitude = amplitude
        try:
            for _ in range(2):
                with context.probe(exchange=exchange) as probe:
                    _through(context, probe)
        except RefusedError:
            if amplitude == amplitudes[-1]:
                raise
        else:
            return


def _through(context: Context, probe: Probe) -> None:
    probe.begin()
    for row in context.random_inputs(STEPS):
        probe.put(context.subject.inputs, row)
        if probe.exchange:
            probe.rates()
        else:
            probe.advance(context.subject.step_size)
        probe.read(context.subject.outputs)
    probe.fmu.do("Terminate")


def _other_starts(context: Context, *, exchange: bool) -> list[str]:
    """Values of a new instance, before anything is set, that are not the start values declared.

    Read in initialization mode, where FMI allows it; there `exact` ones are as they were before.
    """
    declared = [
        v
        for v in context.subject.readable
        if v.initial == "exact" and v.start is not None and np.isfinite(float(v.start))
    ]
    with context.probe(exchange=exchange) as probe:
        probe.setup()
        probe.fmu.enter_initialization()
        values = probe.read(declared)
    return [
        f"{v.name} has {value:.9g}, start is {start(v):.9g}"
        for v, value in zip(declared, values, strict=True)
        if not abs(value - start(v)) <= max(WRITTEN * abs(start(v)), EPS * scale(v))
    ]


def _own_runs(context: Context, *, exchange: bool) -> Iterator[Finding]:
    """With its own start values: finite values, and the same bits twice."""
    outputs, way = context.subject.outputs, "ModelExchange" if exchange else "CoSimulation"
    sizes = [] if exchange else [context.subject.step_size] * STEPS
    values, again = (_course(context, sizes, exchange=exchange) for _ in range(2))
    if values.tobytes() != again.tobytes():
        message = f"{way}: a second run gives other bits"
        yield Finding("start.not_repeatable", "warning", message, "is there a global state?")
    wrong = [v.name for k, v in enumerate(outputs) if not np.isfinite(values[:, k]).all()]
    message, remedy = "with its own start values, not finite", "check its start values"
    yield from about(wrong, "start.not_finite", "error", message, remedy)


def _course(context: Context, sizes: list[float], *, exchange: bool) -> np.ndarray:
    """Outputs (n_steps + 1, n_outputs), in their units, at the start and after steps of `sizes`."""
    with context.probe(exchange=exchange) as probe:
        probe.begin()
        seen = [probe.read(context.subject.outputs)]
        for size in sizes:
            probe.advance(size)
            seen.append(probe.read(context.subject.outputs))
        return np.array(seen)


def _order_of_states(context: Context) -> Iterator[Finding]:
    """In model exchange: the vectors of states and rates, against the variables they stand for."""
    subject, wrong = context.subject, list[str]()
    both = [*subject.states, *subject.rates]
    with context.probe(exchange=True) as probe:
        probe.begin()
        for x in context.random(subject.states, 2):
            probe.set_states(x)
            vectors = np.concatenate([probe.vector(), probe.rates()])
            values = probe.read(both)
            # the same quantities, computed twice
            differs = abs(vectors - values) > 1e-12 * np.maximum(abs(vectors), abs(values))
            wrong += [
                f"{both[k].name} is {values[k]:g}, the vector has {vectors[k]:g}"
                for k in np.flatnonzero(differs)
            ]
    message = "states or rates are not where ModelStructure has them"
    basis = "FMI 2.0.4, section 2.2.8: the order of the derivatives is that of the states"
    yield from about(wrong, "start.order", "error", message, basis)


def _capabilities(context: Context, *, exchange: bool) -> Iterator[Finding]:
    """Declared capabilities that are not there; the others work."""
    for name, test in _tests(context, exchange=exchange).items():
        try:
            with context.probe(exchange=exchange) as probe:
                probe.begin()
                if not exchange:
                    probe.advance(context.subject.step_size)
                test(probe)
        except RefusedError as error:
            message = f"{name} is declared, but the functions it stands for are refused"
            basis = "FMI 2.0.4, section 3.3.1 and 4.3.1"
            yield Finding("capabilities.missing", "error", message, basis, error.words)
        else:
            context.works.append(f"{name} (model exchange)" if exchange else name)


def _tests(context: Context, *, exchange: bool) -> dict[str, Callable[[Probe], object]]:
    """Declared capability → calls that test it.

    Undeclared capabilities are not called: their behaviour is unspecified (FMI 2.0.4, section 2.3).
    """
    kind = context.subject.kind(exchange=exchange)
    outputs, inputs = context.subject.outputs[:1], context.subject.inputs[:1]
    tests: dict[str, Callable[[Probe], object]] = {
        "canGetAndSetFMUstate": _saves,
        "canSerializeFMUstate": _serialises,
    }
    if outputs and inputs:
        tests["providesDirectionalDerivative"] = lambda p: p.sensitivity(outputs, inputs)
    return {name: test for name, test in tests.items() if getattr(kind, name)}


def _saves(probe: Probe) -> None:
    state = probe.save()
    probe.restore(state)
    probe.free_state(state)


def _serialises(probe: Probe) -> None:
    state = probe.save()
    if not probe.fmu.state_size(state[1]):
        raise RefusedError("fmi2SerializedFMUstateSize (0 bytes)", ERROR, probe.words())
    probe.free_state(state)
