"""Groups `state`, `state_elsewhere` and `instances`: runs that must repeat, bit by bit.

Saved states restore everything, and saving disturbs nothing; their bytes also work in another
instance and process. A reset equals a fresh start, instances share nothing, freeing them frees
memory.
"""

from __future__ import annotations

import ctypes
import mmap
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from m4e_fmi.fmu.importer.messages import FATAL, OK
from m4e_fmi.fmu.importer.questions import trajectory
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.probe import GUARD, Context, Probe, RefusedError
from m4e_fmi.fmu.validation.subject import scale, start, within

STEPS = 5
BASIS = "FMI 2.0.4, section 2.1.8"
RESUME = "resume.npz"
"""File from which the group `state_elsewhere` goes on."""
WARM_UP, CYCLES, LEAST = 10, 40, 4
"""Instances before any are counted, instances counted, and how many at least if they are slow."""
LEAK = 65536
"""Bytes that an instance may leave behind: well above what an allocator keeps, or an interpreter
that compiles a small script (5 to 8 kB have been measured)."""
_STATM = Path("/proc/self/statm")

Rows = list[np.ndarray]


class _Instance:
    """An instance that is to repeat a run; all its Reals are read."""

    def __init__(self, probe: Probe) -> None:
        self.probe = probe

    def set(self, values: np.ndarray) -> None:
        """All continuous inputs, `values` (n_inputs,), in their units."""
        self.probe.put(self.probe.subject.inputs, values)

    def read(self) -> np.ndarray:
        """All Reals (n_reals,), in their units."""
        return self.probe.read(self.probe.subject.readable)

    def step(self, size: float) -> None:
        """A step of `size` [s]; in model exchange, nothing but the inputs changes."""
        if not self.probe.exchange:
            self.probe.advance(size)

    def run(self, inputs: np.ndarray) -> Rows:
        """All Reals now and after each step, with its row of `inputs` (n_steps, n_inputs).

        In the variables' units.
        """
        return [self.read(), *trajectory(self, inputs, self.probe.subject.step_size)]

    def to_bytes(self) -> tuple[bytes, bool]:
        """The state as bytes, and whether no more was written than announced."""
        saved = self.probe.save()
        written = self.probe.fmu.state_bytes(saved[1], GUARD)
        self.probe.free_state(saved)
        return written[: -len(GUARD)], written.endswith(GUARD)

    def from_bytes(self, content: bytes, time: float) -> None:
        """Bring the instance to the state in `content`, which is one at `time` [s]."""
        saved = time, self.probe.fmu.state_of(content)
        self.probe.restore(saved)
        self.probe.free_state(saved)


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
            names = some([context.subject.readable[k].name for k in places])
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
    with _after(context, before) as instance:
        undisturbed = instance.run(after)
    with _after(context, before) as instance:
        saved = instance.probe.save()
        first = instance.run(after)
        instance.probe.restore(saved)
        again = instance.run(after)
        what = "saving a state changes the run"
        yield from _not_repeated(context, undisturbed, first, "disturbs", what)
        what = "a restored state does not repeat it"
        yield from _not_repeated(context, first, again, "rollback", what)
        yield from _freed(instance.probe, saved[1])
    if "canSerializeFMUstate" in works:
        yield from _serialised(context, before, after, first)
    if not _once(context):
        yield from _into_another(context, before, after, first)


@contextmanager
def _after(context: Context, before: np.ndarray) -> Generator[_Instance, None, None]:
    """An instance after the steps with the inputs `before` (n_steps, n_inputs), in their units."""
    with context.probe() as probe:
        instance = _Instance(probe.begin())
        instance.run(before)
        yield instance


def _once(context: Context) -> bool:
    """True if there may be one instance per process only."""
    return any(kind.canBeInstantiatedOnlyOncePerProcess for kind in context.subject.kinds)


def _not_repeated(
    context: Context, one: Rows, other: Rows, name: str, what: str
) -> Iterator[Finding]:
    message = f"{what}: after {{row}} of {{steps}} steps other bits in {{names}}"
    yield from _differences(context, one, other, f"state.{name}", message)


def _freed(probe: Probe, state: ctypes.c_void_p) -> Iterator[Finding]:
    for what, given in (("a saved state", state), ("no state (NULL)", ctypes.c_void_p())):
        status = probe.fmu.call("FreeFMUstate", ctypes.byref(given), note=what)
        if status != OK:
            message = f"fmi2FreeFMUstate of {what} answered {status}"
            yield Finding("state.free", "warning", message, BASIS, probe.words())
        if not OK <= status < FATAL:
            probe.fmu.component = None


def _serialised(
    context: Context, before: np.ndarray, after: np.ndarray, expected: Rows
) -> Iterator[Finding]:
    with _after(context, before) as instance:
        time = instance.probe.time
        content, fits = instance.to_bytes()
        if not fits:
            message = f"fmi2SerializeFMUstate wrote more than the {len(content)} bytes announced"
            yield Finding("state.serialised_size", "error", message, BASIS)
            return
        instance.run(after)
        try:
            instance.from_bytes(content, time)
        except RefusedError as error:
            yield Finding("state.serialised", "error", str(error), BASIS, error.words)
            return
        again = instance.run(after)
        what = "a state from bytes does not repeat the run"
        yield from _not_repeated(context, expected, again, "serialised", what)
    state = np.frombuffer(content, np.uint8)
    np.savez(context.folder / RESUME, state=state, time=time, inputs=after, expected=expected)


def _into_another(
    context: Context, before: np.ndarray, after: np.ndarray, expected: Rows
) -> Iterator[Finding]:
    """A state of one instance in another: as bytes, and last as it is, which FMI leaves open."""
    ways: dict[str, Callable[[_Instance, _Instance], None]] = {}
    if (context.folder / RESUME).exists():
        ways["bytes"] = lambda one, other: other.from_bytes(one.to_bytes()[0], one.probe.time)
    ways["handle"] = _handed_over
    for way, hand_over in ways.items():
        severity = "error" if way == "bytes" else "note"
        with _after(context, before) as one, context.probe(name="other") as probe:
            other = _Instance(probe.begin())
            try:
                hand_over(one, other)
            except RefusedError as error:
                message = f"a state ({way}) is not taken by another instance: {error}"
                yield Finding("state.transfer", severity, message, BASIS, error.words)
                continue
            again = other.run(after)
            what = f"a state ({way}) in another instance does not repeat the run"
            yield from _not_repeated(context, expected, again, "transfer", what)


def _handed_over(one: _Instance, other: _Instance) -> None:
    saved = one.probe.save()
    other.probe.restore(saved)
    one.probe.free_state(saved)


def check_state_elsewhere(context: Context) -> Iterator[Finding | str]:
    """A state that does not repeat a run in another process."""
    path = context.folder / RESUME
    if not path.exists():
        yield "there is no serialised state"
        return
    with np.load(path) as left, context.probe() as probe:
        instance = _Instance(probe.begin())
        try:
            instance.from_bytes(left["state"].tobytes(), float(left["time"]))
        except RefusedError as error:
            yield Finding("state_elsewhere.refused", "error", str(error), BASIS, error.words)
            return
        again, expected = instance.run(left["inputs"]), list(left["expected"])
    message = "in a new process, after {row} steps other bits in {names}"
    yield from _differences(context, expected, again, "state_elsewhere.differs", message)


# ---- instances ----


def check_instances(context: Context) -> Iterator[Finding | str]:
    """Instances that differ after a reset, share values, or leave memory behind."""
    for exchange in context.subject.ways:
        yield from _reset(context, exchange=exchange)
        if not _once(context):
            yield from _shared(context, exchange=exchange)
    yield from _leak(context)


def _reset(context: Context, *, exchange: bool) -> Iterator[Finding]:
    inputs = context.random_inputs(STEPS)
    with context.probe(exchange=exchange) as probe:
        fresh = _Instance(probe.begin()).run(inputs)
    with context.probe(exchange=exchange) as probe:
        _Instance(_perturbed(context, probe)).run(inputs[::-1])
        probe.reset()
        again = _Instance(probe.begin()).run(inputs)
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
        expected = _Instance(probe.begin()).run(inputs)
    with (
        context.probe(exchange=exchange) as probe,
        context.probe(exchange=exchange, name="other") as stranger,
    ):
        one, other = _Instance(probe.begin()), _Instance(_perturbed(context, stranger))
        seen = [one.read()]
        for row, opposite in zip(inputs, inputs[::-1], strict=True):
            seen += one.run(row[None])[1:]
            other.run(opposite[None])
    message = "a second instance changes the results of the first: {names}, row {row}"
    basis = "else declare canBeInstantiatedOnlyOncePerProcess: FMI 2.0.4, section 2.1.5"
    yield from _differences(context, expected, seen, "instances.shared", message, basis)


def _leak(context: Context) -> Iterator[Finding]:
    if not _STATM.exists():
        return
    sizes: list[int] = []  # bytes of this process in memory
    while len(sizes) <= WARM_UP + CYCLES and not (context.late and len(sizes) > LEAST):
        with context.probe(exchange=not context.subject.steps) as probe:
            probe.setup()
            probe.fmu.enter_initialization()
            probe.fmu.exit_initialization()
            probe.fmu.do("Terminate")
        sizes.append(int(_STATM.read_text().split()[1]) * mmap.PAGESIZE)
    counted = sizes[min(WARM_UP, len(sizes) // 2) :]
    each = (counted[-1] - counted[0]) / (len(counted) - 1)
    if each > LEAK:
        message = f"{len(counted)} instances left {each / 1024:.0f} kB each behind when freed"
        yield Finding("instances.leak", "warning", message, "FMI 2.0.4, section 2.1.5")
