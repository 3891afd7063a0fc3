"""Group `state`: saved states bring back everything, bit by bit, and saving disturbs nothing."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable, Iterator

import numpy as np

from m4e_fmi.fmu.importer.calls.functions import OK
from m4e_fmi.fmu.validation.context import Context, first_difference
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.probe import Probe, RefusedError

STEPS = 5
BASIS = "FMI 2.0.4, section 2.1.8"
RESUME = "resume.json"
"""File from which the group `state_elsewhere` goes on."""
_GUARD = b"\xa5guard\x5a" * 4


def check(context: Context) -> Iterator[Finding | str]:
    """Saved states that do not repeat a run."""
    if not context.subject.steps or "canGetAndSetFMUstate" not in context.facts.works:
        yield "canGetAndSetFMUstate is not declared for co-simulation, or not there"
        return
    inputs = context.random_inputs(2 * STEPS)
    before, after = inputs[:STEPS], inputs[STEPS:]
    size = context.subject.step_size
    with context.probe() as probe:
        probe.begin()
        context.run(probe, before, size)
        undisturbed = context.run(probe, after, size)
    with context.probe() as probe:
        probe.begin()
        context.run(probe, before, size)
        time, state = probe.time, probe.save()
        first = context.run(probe, after, size)
        probe.restore(state)
        probe.time = time
        again = context.run(probe, after, size)
        yield from _compare(
            context, undisturbed, first, "disturbs", "saving a state changes the run"
        )
        yield from _compare(
            context, first, again, "rollback", "a restored state does not repeat it"
        )
        yield from _freed(probe, state)
    if "canSerializeFMUstate" in context.facts.works:
        yield from _serialised(context, before, after, first)
    if not context.subject.once:
        yield from _into_another(context, before, after, first)


def _compare(
    context: Context, one: list[np.ndarray], other: list[np.ndarray], name: str, what: str
) -> Iterator[Finding]:
    difference = first_difference(context.subject, one, other)
    if difference is not None:
        row, names = difference
        message = f"{what}: after {row} of {len(one) - 1} steps other bits in {some(names)}"
        yield Finding(f"state.{name}", "error", message, BASIS)


def _freed(probe: Probe, state: ctypes.c_void_p) -> Iterator[Finding]:
    for what, given in (("a saved state", state), ("no state (NULL)", ctypes.c_void_p())):
        status = probe.call("FreeFMUstate", ctypes.byref(given), note=what)
        if status != OK:
            message = f"fmi2FreeFMUstate of {what} answered {status}"
            yield Finding("state.free", "warning", message, BASIS, probe.words())


def serialise(probe: Probe) -> tuple[bytes, bool]:
    """The state of an instance as bytes, and whether no more was written than announced."""
    state, size = probe.save(), ctypes.c_size_t()
    probe.must("SerializedFMUstateSize", state, ctypes.byref(size))
    room = (probe.functions.BYTE * (size.value + len(_GUARD)))()
    ctypes.memmove(ctypes.addressof(room) + size.value, _GUARD, len(_GUARD))
    note = f"{size.value} bytes"
    probe.must("SerializeFMUstate", state, room, size.value, note=note)
    probe.free_state(state)
    written = bytes(room)
    return written[: size.value], written[size.value :] == _GUARD


def deserialise(probe: Probe, content: bytes) -> None:
    """Bring an instance to the state in `content`."""
    state = ctypes.c_void_p()
    room = (probe.functions.BYTE * len(content)).from_buffer_copy(content)
    note = f"{len(content)} bytes"
    probe.must("DeSerializeFMUstate", room, len(content), ctypes.byref(state), note=note)
    probe.restore(state)
    probe.free_state(state)


def _serialised(
    context: Context, before: np.ndarray, after: np.ndarray, expected: list[np.ndarray]
) -> Iterator[Finding]:
    size = context.subject.step_size
    with context.probe() as probe:
        probe.begin()
        context.run(probe, before, size)
        time = probe.time
        content, fits = serialise(probe)
        if not fits:
            message = f"fmi2SerializeFMUstate wrote more than the {len(content)} bytes announced"
            yield Finding("state.serialised_size", "error", message, BASIS)
            return
        context.run(probe, after, size)
        try:
            deserialise(probe, content)
        except RefusedError as error:
            yield Finding("state.serialised", "error", str(error), BASIS, error.words)
            return
        probe.time = time
        again = context.run(probe, after, size)
        what = "a state from bytes does not repeat the run"
        yield from _compare(context, expected, again, "serialised", what)
    left = {
        "state": content.hex(),
        "time": time,
        "inputs": [[value.hex() for value in row] for row in after.tolist()],
        "expected": [row.tobytes().hex() for row in expected],
    }
    (context.folder / RESUME).write_text(json.dumps(left))


def _into_another(
    context: Context, before: np.ndarray, after: np.ndarray, expected: list[np.ndarray]
) -> Iterator[Finding]:
    """A state of one instance in another: as bytes, and last as it is, which FMI leaves open."""
    ways: dict[str, Callable[[Probe, Probe], None]] = {}
    if (context.folder / RESUME).exists():
        ways["bytes"] = lambda one, other: deserialise(other, serialise(one)[0])
    ways["handle"] = _handed_over
    for way, hand_over in ways.items():
        severity = "error" if way == "bytes" else "note"
        with context.probe() as one, context.probe(name="other") as other:
            one.begin()
            context.run(one, before, context.subject.step_size)
            other.begin()
            try:
                hand_over(one, other)
            except RefusedError as error:
                message = f"a state ({way}) is not taken by another instance: {error}"
                yield Finding("state.transfer", severity, message, BASIS, error.words)
                continue
            other.time = one.time
            again = context.run(other, after, context.subject.step_size)
            what = f"a state ({way}) in another instance does not repeat the run"
            yield from _compare(context, expected, again, "transfer", what)


def _handed_over(one: Probe, other: Probe) -> None:
    state = one.save()
    other.restore(state)
    one.free_state(state)
