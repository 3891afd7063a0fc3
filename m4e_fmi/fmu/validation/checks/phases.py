"""Group `phases`: every function in every state of FMI's state machine.

Source: FMI 2.0.4, tables in section 3.2.3 (model exchange) and 4.2.4 (co-simulation).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator

import numpy as np

from m4e_fmi.fmu.importer.messages import WARNING
from m4e_fmi.fmu.validation.findings import Finding, about
from m4e_fmi.fmu.validation.probe import Context, Probe, RefusedError

INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS, STEP, TERMINATED = (
    "before initialization",
    "in initialization mode",
    "in event mode",
    "in continuous-time mode",
    "between steps",
    "after termination",
)
STATES = {
    False: (INSTANTIATED, INITIALIZATION, STEP, TERMINATED),
    True: (INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS, TERMINATED),
}
LATER = (INITIALIZATION, EVENT, CONTINUOUS, STEP, TERMINATED)
RUNNING = (EVENT, CONTINUOUS, STEP)
ANY = (INSTANTIATED, *LATER)
BASIS = "FMI 2.0.4, section 3.2.3 and 4.2.4"

Action = Callable[[Probe], int]


def check(context: Context) -> Iterator[Finding | str]:
    """Calls that are refused or accepted against the state machine."""
    refused, accepted, readable, left_out = (list[str]() for _ in range(4))
    for exchange in context.subject.ways:
        for state in STATES[exchange]:
            for name, (allowed, action) in _functions(context, exchange=exchange).items():
                call = f"{name} {state}"  # which may be there in both ways
                if context.late:
                    left_out.append(call)
                    continue
                status, heard = _outcome(context, state, action, exchange=exchange)
                if state in allowed and status > WARNING:
                    refused.append(call)
                elif state not in allowed and max(status, heard) <= WARNING:
                    (readable if "Get" in name else accepted).append(call)
    message = "the FMU is slow: {count} calls were left out"
    yield from about(left_out, "phases.left_out", "note", message)
    message = "{count} allowed calls are refused"
    yield from about(refused, "phases.refused", "error", message, BASIS)
    message, basis = "{count} forbidden calls are accepted", f"{BASIS}: answer fmi2Error"
    yield from about(accepted, "phases.accepted", "warning", message, basis)
    message = "{count} values can be read when they need not be there"
    yield from about(readable, "phases.readable", "note", message, BASIS)


def _outcome(context: Context, state: str, action: Action, *, exchange: bool) -> tuple[int, int]:
    """Status of the call, and the worst one among what the FMU logs meanwhile."""
    with context.probe(exchange=exchange) as probe:
        _bring(context, probe, state)
        probe.words()
        try:
            return action(probe), probe.listen()
        except RefusedError as error:
            return error.status, error.status


def _bring(context: Context, probe: Probe, state: str) -> None:
    if state == INSTANTIATED:
        probe.setup()  # which entering initialization mode needs, and may be done twice
        return
    if state in (INITIALIZATION, EVENT):
        probe.setup()
        probe.fmu.enter_initialization()
        if state == EVENT:
            probe.fmu.exit_initialization()
        return
    probe.begin()
    if not probe.exchange:
        probe.advance(context.subject.step_size)
    if state == TERMINATED:
        probe.fmu.do("Terminate")


def _plain(function: str) -> Action:
    return lambda probe: probe.call(function)


def _functions(context: Context, *, exchange: bool) -> dict[str, tuple[tuple[str, ...], Action]]:
    """Function → states in which it may be called, and how."""
    subject = context.subject
    found: dict[str, tuple[tuple[str, ...], Action]] = {
        "EnterInitializationMode": ((INSTANTIATED,), lambda p: _status(p.fmu.enter_initialization)),
        "ExitInitializationMode": ((INITIALIZATION,), _plain("ExitInitializationMode")),
        "Terminate": (RUNNING, _plain("Terminate")),
        "Reset": (ANY, _plain("Reset")),
    }
    if not subject.fmi_3:
        found["SetupExperiment"] = ((INSTANTIATED,), lambda p: _status(p.setup))
    real = "Float64" if subject.fmi_3 else "Real"
    if subject.outputs:
        reference = [subject.outputs[0].valueReference]
        found[f"Get{real}"] = (LATER, lambda p: p.get(reference)[0])
    if subject.inputs:
        v = subject.inputs[0]
        value = np.array([float(v.start or 0.0)])
        states = tuple(s for s in ANY if s != TERMINATED)
        found[f"Set{real}"] = (states, lambda p: p.set([v.valueReference], value))
    works = [n for n in context.facts.works if exchange == n.endswith("(model exchange)")]
    if any(name.startswith("canGetAndSetFMUstate") for name in works):
        found["GetFMUstate"] = (ANY, _save)
    return found | (_of_exchange(context) if exchange else _of_stepping(context))


def _of_stepping(context: Context) -> dict[str, tuple[tuple[str, ...], Action]]:
    subject, works, size = context.subject, context.facts.works, context.subject.step_size
    found: dict[str, tuple[tuple[str, ...], Action]] = {
        "DoStep": ((STEP,), lambda p: p.step(size)),
    }
    if "canInterpolateInputs" in works:
        u = subject.inputs[:1]
        zero = np.zeros(1)
        found["SetRealInputDerivatives"] = (
            (INSTANTIATED, INITIALIZATION, STEP),
            lambda p: _status(lambda: p.set_input_derivatives(u, zero)),
        )
    if "maxOutputDerivativeOrder" in works:
        y = subject.outputs[:1]
        found["GetRealOutputDerivatives"] = (
            (STEP, TERMINATED),
            lambda p: _status(lambda: p.output_derivatives(y)),
        )
    return found


def _of_exchange(context: Context) -> dict[str, tuple[tuple[str, ...], Action]]:
    x = np.array([float(v.start or 0.0) for v in context.subject.states])
    t = context.subject.start_time
    values = (INITIALIZATION, EVENT, CONTINUOUS, TERMINATED)
    rates = values if context.subject.fmi_3 else values[1:]
    event_mode = (CONTINUOUS,) if context.subject.fmi_3 else (EVENT, CONTINUOUS)
    return {
        "EnterEventMode": (event_mode, _plain("EnterEventMode")),
        "NewDiscreteStates": ((EVENT,), lambda p: _status(p.settle)),
        "EnterContinuousTimeMode": ((EVENT,), _plain("EnterContinuousTimeMode")),
        "CompletedIntegratorStep": ((CONTINUOUS,), _completed_integrator_step),
        "SetTime": ((EVENT, CONTINUOUS), lambda p: p.call("SetTime", t)),
        "SetContinuousStates": (
            (CONTINUOUS,),
            lambda p: _status(lambda: p.set_states(x)),
        ),
        "GetContinuousStates": (values, lambda p: _status(p.vector)),
        "GetDerivatives": (rates, lambda p: _status(p.rates)),
    }


def _completed_integrator_step(probe: Probe) -> int:
    event, terminate = probe.fmu.BOOLEAN(), probe.fmu.BOOLEAN()
    places = ctypes.byref(event), ctypes.byref(terminate)
    return probe.call("CompletedIntegratorStep", 1, *places)


def _status(action: Callable[[], object]) -> int:
    try:
        action()
    except RefusedError as error:
        return error.status
    return 0


def _save(probe: Probe) -> int:
    return _status(lambda: probe.free_state(probe.save()))
