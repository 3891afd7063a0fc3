"""Lists of operations that the C library performs: a `Schedule` once, a `StepLoop` step by step.

Algorithms list the operations. Behind the schedules, they are compiled for the runtime's loop.h,
which performs them in their order.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Collection, Sequence
from ctypes import POINTER, c_double, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p
from functools import cache
from typing import NoReturn
from weakref import WeakKeyDictionary

import numpy as np

from m4e_fmi.cosim.network import operations as op
from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.operations import Operation
from m4e_fmi.cosim.system.simulation import NEVER, NS_PER_SECOND
from m4e_fmi.fmu.importer.calls import DISCARD, RawCall
from m4e_fmi.fmu.importer.calls.access import RawComponent, runtime_function
from m4e_fmi.runtime.library import library

NO_ROWS = 2**63
"""Steps from row to row where there are no rows."""


class Schedule:
    """Operations that are performed in their order."""

    def __init__(self, operations: Sequence[Operation]) -> None:
        self.operations = tuple(operations)
        self.executor = NativeExecutor(self.operations)
        stepping = [o for o in self.operations if isinstance(o, op.DoStep)]
        self._stepping = tuple({id(o.instance): o.instance for o in stepping if not o.due}.values())
        self._sampled = tuple((o.instance, o.due) for o in stepping if o.due)
        self._returning = tuple(o.instance for o in self.operations if isinstance(o, op.Restore))

    def run(self, time: float, size: float = 0.0, *, row: int = 0) -> None:
        """Perform all once: a step of `size` [s] from `time` [s]; blocks are filled at `row`.

        RunError with component, variable, time and remedy where an FMU fails or gives no number.
        """
        for instance in self._returning:
            instance.events.ended = math.inf  # in a step that is made again
        status, index = self.executor.perform(time, size, row)
        if status:
            self.complete(status, index, time, size, row)
        self.arrive(time + size)

    def complete(self, status: int, index: int, time: float, size: float, row: int) -> None:
        """Perform the rest if the operation failed by which an FMU asks for the end of the run.

        So it is if the FMU has come to the end of the step; in that, nothing is set any more.
        """
        step, end = self.operations[index], time + size
        if status != DISCARD or not isinstance(step, op.DoStep) or not step.instance.ends_at(end):
            self.fail(status, index, time, size, row)
        rest = list(self.operations[index + 1 :])
        again = (isinstance(o, op.Restore) and o.instance is step.instance for o in rest)
        quiet = next((k for k, is_again in enumerate(again) if is_again), len(rest))
        quietly = Schedule(rest[:quiet]).without_sets([step.instance])
        Schedule([*quietly.operations, *rest[quiet:]]).run(time, size, row=row)

    def without_sets(self, instances: Collection[Instance]) -> Schedule:
        """The same, but nothing is set in these."""
        sets = op.Set, op.SetDerivatives, op.SetTyped
        return Schedule(
            [o for o in self.operations if not isinstance(o, sets) or o.instance not in instances]
        )

    def arrive(self, time: float) -> None:
        """All components that step have come to `time` [s]."""
        for instance in self._stepping:
            instance.time = time
        for instance, due in self._sampled:
            if due.at(time):
                instance.time = time

    def fail(self, status: int, index: int, time: float, size: float, row: int) -> NoReturn:
        """Raise what the status of an operation means; those before it are done."""
        for operation in self.operations[:index]:
            if isinstance(operation, op.DoStep):
                if not operation.due or operation.due.at(time + size):
                    operation.instance.time = sum(operation.span(time, size))
            elif isinstance(operation, op.Restore):
                operation.instance.time = time
        match self.operations[index]:
            case op.Get(instance, names, into) | op.Choose(instance, names, into) if (
                status == NOT_A_NUMBER
            ):
                instance.not_finite(names, into if into.ndim == 1 else into[row])
            case op.DoStep(instance) as step:
                instance.time, length = step.span(time, size)
                instance.fail(status, step.function, length)
            case op.GetTyped(instance, access, cells) | op.SetTyped(instance, access, cells):
                instance.fail_typed(status, access, cells)
            case op.Combine() | op.Gather() | op.Choose() | op.Monitor():
                raise AssertionError("these do not fail")
            case call:
                call.instance.fail(status, call.function)


class StepLoop:
    """A schedule for each macro step, and one for each step that is a row of the results.

    `state` has the present time `now`, the step `size` [ns], the next places of blocks that each
    step (`noted`) and each row (`written`) fill, and the steps `since` the last of the rows, which
    are `every` so many steps. All steps that end at `rows_from` [ns] or later may end at a row. One
    of the instances `telling` may ask for the end; one of `stops` (float64) that becomes finite
    ends it, too.
    """

    def __init__(
        self,
        step: Schedule,
        row: Schedule | None,
        *,
        every: int,
        telling: Sequence[Instance],
        stops: np.ndarray,
    ) -> None:
        self.step = step
        self.row = row or Schedule(())
        self.state = LoopState(every=every if row else NO_ROWS, rows_from=NEVER)
        ended = RawComponent.ended.offset  # pyrefly: ignore[missing-attribute]
        places = [ctypes.addressof(instance.events) + ended for instance in telling]
        places += [stops.ctypes.data + k * stops.itemsize for k in range(len(stops))]
        self._ends = (c_void_p * len(places))(*places)  # addresses of times, finite where it ends
        self.state.ends, self.state.end_count = ctypes.addressof(self._ends), len(self._ends)

    def advance(self, steps: int) -> None:
        """Make so many macro steps, up to the end that a component asks for, or to a stop.

        RunError as `Schedule.run`, `state` telling how far it came.
        """
        state, before = self.state, self.state.now
        status = run_loop(self.step.executor, self.row.executor, state, steps)
        now, size = state.now / NS_PER_SECOND, state.size / NS_PER_SECOND
        if state.now > before:
            self.step.arrive(now)
        if status and state.in_row:
            self.row.fail(status, state.failed, now, 0.0, state.written)
        if status:
            self._complete(status, now, size)

    def _complete(self, status: int, now: float, size: float) -> None:
        """Complete the step if it is one in which an FMU asks for the end; `Schedule.fail` if not.

        What it left out as it did not seem to end at a row is read now.
        """
        state, step = self.state, self.step
        at_row = state.since + 1 >= state.every or state.now + state.size >= state.rows_from
        step.complete(status, state.failed, now, size, state.noted)
        if not at_row:
            done = step.operations[: state.failed]
            reading = [o for o in done if isinstance(o, op.Get | op.GetTyped) and o.in_rows]
            Schedule(reading).run(now, size)
        step.arrive(now + size)
        state.now += state.size
        state.noted += 1
        state.since += 1


NOT_A_NUMBER = -1
GET, SET, SET_DERIVATIVES, DO_STEP, SAVE, RESTORE, COMBINE, MONITOR, CALL, BEGIN_STEP = range(10)
CHOOSE, CHOOSE_CELLS = 10, 11


class RawOperation(ctypes.Structure):
    """`m4e_operation` of loop.h."""

    _fields_ = [
        ("kind", c_int32),
        ("count", c_uint32),
        ("terms", c_uint32),
        ("component", c_void_p),
        ("function", c_void_p),
        ("references", c_void_p),
        ("orders", c_void_p),
        ("state", c_void_p),
        ("weights", c_void_p),
        ("source", c_void_p),
        ("offset", c_void_p),
        ("past", c_void_p),
        ("values", c_void_p),
        ("stride", c_uint64),
        ("start", c_double),
        ("length", c_double),
        ("own", c_double),
        ("origin", c_int64),
        ("period", c_int64),
        ("in_rows", c_int32),
        ("unchecked", c_int32),
        ("warned", c_void_p),
    ]


class LoopState(ctypes.Structure):
    """`m4e_loop_state` of loop.h."""

    _fields_ = [
        ("step", c_void_p),
        ("row", c_void_p),
        ("step_count", c_uint64),
        ("row_count", c_uint64),
        ("now", c_int64),
        ("size", c_int64),
        ("rows_from", c_int64),
        ("every", c_uint64),
        ("since", c_uint64),
        ("noted", c_uint64),
        ("written", c_uint64),
        ("failed", c_uint64),
        ("in_row", c_int32),
        ("ends", c_void_p),
        ("end_count", c_uint64),
        ("halt", c_int32),
    ]


@cache
def loop_library() -> ctypes.CDLL:
    """The C library, which performs all operations; RunError without it."""
    found = library()
    found.m4e_perform.argtypes = (
        c_void_p, c_size_t, c_double, c_double, c_uint64, POINTER(c_uint64),
    )  # fmt: skip
    found.m4e_loop.argtypes = (POINTER(LoopState), c_uint64)
    return found


class NativeExecutor:
    """Performs a list of operations in one call, without the interpreter's lock."""

    def __init__(self, operations: Sequence[Operation]) -> None:
        self._kept = [(operation, *_translated(operation)) for operation in operations]
        order = _begun_early(operations)
        self._places = [abs(place) - 1 for place in order]
        self.count = len(order)
        self.array = (RawOperation * self.count)(*map(self._raw, order))
        self._failed = c_uint64()
        self._perform = loop_library().m4e_perform

    def perform(self, time: float, size: float, row: int) -> tuple[int, int]:
        """Status and index of the operation that failed; (0, 0) if none did."""
        failed = self._failed
        status = self._perform(self.array, self.count, time, size, row, failed)
        return (status, self.place(failed.value)) if status else (0, 0)

    def place(self, performed: int) -> int:
        """The index of an operation by its place among all that are performed."""
        return self._places[performed]

    def _raw(self, place: int) -> RawOperation:
        operation, raw, _ = self._kept[abs(place) - 1]
        if place > 0:
            return raw
        assert isinstance(operation, op.DoStep)
        raw = RawOperation.from_buffer_copy(raw)
        raw.kind, raw.function = BEGIN_STEP, operation.instance.step_beginner()
        return raw


def _begun_early(operations: Sequence[Operation]) -> list[int]:
    """Numbers of the operations (from 1) in their order, negative where a step only begins.

    A step in another process begins as soon as all earlier operations on its component are done. So
    components step in parallel unless they wait for each other's values.
    """
    first: list[int] = []
    behind: list[list[int]] = []
    last: dict[int, list[int]] = {}  # by component: what begins behind its last operation
    for number, operation in enumerate(operations, 1):
        behind.append([])
        instance = getattr(operation, "instance", None)
        if instance is None:
            continue
        if isinstance(operation, op.DoStep) and instance.step_beginner():
            last.get(id(instance), first).append(-number)
        last[id(instance)] = behind[-1]
    return first + [n for number, begun in enumerate(behind, 1) for n in (number, *begun)]


Translated = tuple[RawOperation, tuple[np.ndarray, ...]]
"""An operation for the C library, and what of it nothing else holds."""


_known: WeakKeyDictionary[Operation, Translated] = WeakKeyDictionary()


def _translated(operation: Operation) -> Translated:
    """The same for the same operation, which may be in many lists, and many times in one."""
    found = _known.get(operation)
    if found is None:
        found = _known[operation] = _translation(operation)
        due = getattr(operation, "due", None)
        if due:
            found[0].origin, found[0].period = due.origin, due.period
    return found


def _translation(operation: Operation) -> Translated:
    match operation:
        case op.Get() | op.Set() | op.SetDerivatives():
            return _reals(operation)
        case op.DoStep(instance, start, length, own):
            raw = _call(DO_STEP, instance.raw(operation.function))
            raw.start, raw.length, raw.own = start, length, own
            raw.warned = ctypes.addressof(instance.warned)
        case op.Save(instance) | op.Restore(instance):
            kind = SAVE if isinstance(operation, op.Save) else RESTORE
            raw = _call(kind, instance.raw(operation.function))
            raw.state = ctypes.addressof(instance.slot())
        case op.Gather():
            raw = _gather(operation)
        case op.Combine():
            raw = _combine(operation)
        case op.Monitor(into, source, gate, past):
            raw = _filling(into, kind=MONITOR, terms=len(source), source=_address(source))
            raw.weights, raw.past = _address(gate), _address(past)
        case op.GetTyped(_, access, cells):
            raw = _filling(cells, kind=CALL, component=access.address)
            raw.function, raw.in_rows = runtime_function("m4e_get_typed"), operation.in_rows
        case op.SetTyped(_, access, cells):
            raw = _filling(cells, kind=CALL, component=access.address)
            raw.function = runtime_function("m4e_set_typed")
        case op.Choose(_, _, into, readings, changed):
            kind = CHOOSE if into.dtype == np.float64 else CHOOSE_CELLS
            raw = _filling(into, kind=kind, source=readings.ctypes.data)
            raw.terms = readings.strides[0] // readings.itemsize
            raw.past = None if changed is None else _address(changed)
            raw.unchecked = not operation.checked
    return raw, ()


def _reals(operation: op.Reals) -> Translated:
    call = operation.instance.raw(operation.function, operation.names)
    match operation:
        case op.Get(_, _, values):
            raw = _call(GET, call, values)
            raw.in_rows, raw.unchecked = operation.in_rows, not operation.checked
        case op.Set(_, _, values):
            raw = _call(SET, call, values)
        case op.SetDerivatives(_, _, values, order):
            raw = _call(SET_DERIVATIVES, call, values)
            orders = np.array([order], dtype=np.int32)
            raw.orders = _address(orders)
            return raw, (call.references, orders)
    return raw, (call.references,)


def _gather(operation: op.Gather) -> RawOperation:
    """Copies 8 bytes for each value, also for cells."""
    source, index = operation.source, operation.index
    raw = _filling(operation.into, kind=COMBINE, source=_address(source))
    if len(index) and (np.diff(index.astype(np.int64)) == 1).all():  # one after the other
        raw.source = _address(source) + int(index[0]) * source.itemsize
    else:
        raw.references = _address(index)
    return raw


def _combine(operation: op.Combine) -> RawOperation:
    into, index, weight = operation.into, operation.index, operation.weight
    assert index.dtype == np.uint32
    assert index.shape == weight.shape == (len(index), into.shape[-1])
    raw = _filling(into, kind=COMBINE, terms=len(index), references=_address(index))
    raw.weights, raw.source = _address(weight), _address(operation.source)
    raw.offset = None if operation.offset is None else _address(operation.offset)
    return raw


def _call(kind: int, call: RawCall, values: np.ndarray | None = None) -> RawOperation:
    given = {"kind": kind, "component": call.component, "function": call.function}
    raw = RawOperation(**given) if values is None else _filling(values, **given)
    raw.references = _address(call.references)
    return raw


def _filling(values: np.ndarray, **given: int | None) -> RawOperation:
    """An operation with the place of its values."""
    raw = RawOperation(count=values.shape[-1], values=_address(values), **given)
    raw.stride = values.shape[1] if values.ndim == 2 else 0
    return raw


def _address(array: np.ndarray) -> int:
    assert array.flags.c_contiguous
    assert array.dtype in (np.float64, np.uint32, np.int32, np.int64)
    return array.ctypes.data


def run_loop(step: NativeExecutor, row: NativeExecutor, state: LoopState, steps: int) -> int:
    """So many steps, fewer if an operation fails, its status then, if a component has asked for the
    end, or another thread for a halt, after one at least. `state` tells how far it came.
    """
    state.step, state.step_count = ctypes.addressof(step.array), step.count
    state.row, state.row_count = ctypes.addressof(row.array), row.count
    status = loop_library().m4e_loop(state, steps)
    state.failed = (row if state.in_row else step).place(state.failed) if status else 0
    return status
