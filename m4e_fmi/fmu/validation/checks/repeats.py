"""Groups `state`, `state_elsewhere` and `instances`: runs that must repeat, bit by bit.

Saved states restore everything, and saving disturbs nothing; their bytes also work in another
process. A reset equals a fresh start, instances share nothing.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager

import numpy as np

from m4e_fmi.fmu.validation.findings import SHOWN, Finding
from m4e_fmi.fmu.validation.probe import Context, Probe, RefusedError
from m4e_fmi.fmu.validation.subject import scale, start, within
from m4e_fmi.shown import first_of

STEPS = 5
BASIS = "FMI 2.0.4, section 2.1.8"
RESUME = "resume.npz"
"""File from which the group `state_elsewhere` goes on."""
Rows = list[np.ndarray]


def _run(probe: Probe, inputs: np.ndarray) -> Rows:
    """All Reals now and after each step, with its row of `inputs` (n_steps, n_inputs).

    In the variables' units; in model exchange, nothing but the inputs changes.
    """
    subject = probe.subject
    found = [probe.read(subject.readable)]
    for row in inputs:
        probe.put(subject.inputs, row)
        if not probe.exchange:
            probe.advance(subject.step_size)
        found.append(probe.read(subject.readable))
    return found


def _restore(probe: Probe, content: bytes, time: float) -> None:
    """Bring the instance to the state in `content`, which is one at `time` [s]."""
    saved = time, probe.fmu.state_of(content)
    probe.restore(saved)
    probe.free_state(saved)


def _differences(
    context: Context, one: Rows, other: Rows, id_: str, message: str, basis: str = BASIS
) -> Iterator[Finding]:
    """A finding on the first difference of two runs, bit by bit, if there is one.

    The message has its row at {row}, the number of steps at {steps}, and at {names} the variables
    that differ there. `one` and `other` are lists of rows (n_reals,), in the variables' units.
    """
    for row, (a, b) in enumerate(zip(one, other, strict=True)):
        if a.tobytes() != b.tobytes():
            places = np.flatnonzero(a.view(np.uint64) != b.view(np.uint64))
            names = first_of((context.subject.readable[k].name for k in places), SHOWN)
            text = message.format(row=row, steps=len(one) - 1, names=names)
            yield Finding(id_, "error", text, basis)
            return


# ---- saved states ----


def check_state(context: Context) -> Iterator[Finding | str]:
    """Saved states that do not repeat a run."""
    works = context.works
    if not context.subject.steps or "canGetAndSetFMUstate" not in works:
        yield "canGetAndSetFMUstate is not declared for co-simulation, or not there"
        return
    inputs = context.random_inputs(2 * STEPS)
    before, after = inputs[:STEPS], inputs[STEPS:]
    with _after(context, before) as probe:
        undisturbed = _run(probe, after)
    with _after(context, before) as probe:
        saved = probe.save()
        first = _run(probe, after)
        probe.restore(saved)
        again = _run(probe, after)
        what = "saving a state changes the run"
        yield from _not_repeated(context, undisturbed, first, "disturbs", what)
        what = "a restored state does not repeat it"
        yield from _not_repeated(context, first, again, "rollback", what)
        probe.free_state(saved)
    if "canSerializeFMUstate" in works:
        yield from _serialised(context, before, after, first)


@contextmanager
def _after(context: Context, before: np.ndarray) -> Generator[Probe, None, None]:
    """An instance after the steps with the inputs `before` (n_steps, n_inputs), in their units."""
    with context.probe() as probe:
        _run(probe.begin(), before)
        yield probe


def _not_repeated(
    context: Context, one: Rows, other: Rows, name: str, what: str
) -> Iterator[Finding]:
    message = f"{what}: after {{row}} of {{steps}} steps other bits in {{names}}"
    yield from _differences(context, one, other, f"state.{name}", message)


def _serialised(
    context: Context, before: np.ndarray, after: np.ndarray, expected: Rows
) -> Iterator[Finding]:
    with _after(context, before) as probe:
        time, saved = probe.time, probe.save()
        content = probe.fmu.state_bytes(saved[1])
        probe.free_state(saved)
        _run(probe, after)
        try:
            _restore(probe, content, time)
        except RefusedError as error:
            yield Finding("state.serialised", "error", str(error), BASIS, error.words)
            return
        again = _run(probe, after)
        what = "a state from bytes does not repeat the run"
        yield from _not_repeated(context, expected, again, "serialised", what)
    state = np.frombuffer(content, np.uint8)
    np.savez(context.folder / RESUME, state=state, time=time, inputs=after, expected=expected)


def check_state_elsewhere(context: Context) -> Iterator[Finding | str]:
    """A state that does not repeat a run in another process."""
    path = context.folder / RESUME
    if not path.exists():
        yield "there is no serialised state"
        return
    with np.load(path) as left, context.probe() as probe:
        probe.begin()
        try:
            _restore(probe, left["state"].tobytes(), float(left["time"]))
        except RefusedError as error:
            yield Finding("state_elsewhere.refused", "error", str(error), BASIS, error.words)
            return
        again, expected = _run(probe, left["inputs"]), list(left["expected"])
    message = "in a new process, after {row} steps other bits in {names}"
    yield from _differences(context, expected, again, "state_elsewhere.differs", message)


# ---- instances ----


def check_instances(context: Context) -> Iterator[Finding | str]:
    """Instances that differ after a reset, or share values."""
    for exchange in context.subject.ways:
        yield from _reset(context, exchange=exchange)
        if not context.subject.kind(exchange=exchange).canBeInstantiatedOnlyOncePerProcess:
            yield from _shared(context, exchange=exchange)


def _reset(context: Context, *, exchange: bool) -> Iterator[Finding]:
    inputs = context.random_inputs(STEPS)
    with context.probe(exchange=exchange) as probe:
        fresh = _run(probe.begin(), inputs)
    with context.probe(exchange=exchange) as probe:
        _run(_perturbed(context, probe), inputs[::-1])
        probe.reset()
        again = _run(probe.begin(), inputs)
    message = "after fmi2Reset a run is not that of a new instance: {names}, row {row}"
    basis = "FMI 2.0.4, section 2.1.6"
    yield from _differences(context, fresh, again, "instances.reset", message, basis)


def _perturbed(context: Context, probe: Probe) -> Probe:
    """Begin with other parameters and inputs than the start values."""
    change = 0.01 * context.amplitude
    given = [v for v in context.subject.given if v.causality != "input"]
    values = [within(v, start(v) + change * scale(v)) for v in given]
    return probe.begin(given, np.array(values))


def _shared(context: Context, *, exchange: bool) -> Iterator[Finding]:
    inputs = context.random_inputs(STEPS)
    with context.probe(exchange=exchange) as probe:
        expected = _run(probe.begin(), inputs)
    with (
        context.probe(exchange=exchange) as probe,
        context.probe(exchange=exchange, name="other") as stranger,
    ):
        probe.begin()
        _perturbed(context, stranger)
        seen = [probe.read(context.subject.readable)]
        for row, opposite in zip(inputs, inputs[::-1], strict=True):
            seen += _run(probe, row[None])[1:]
            _run(stranger, opposite[None])
    message = "a second instance changes the results of the first: {names}, row {row}"
    basis = "else declare canBeInstantiatedOnlyOncePerProcess: FMI 2.0.4, section 2.1.5"
    yield from _differences(context, expected, seen, "instances.shared", message, basis)
