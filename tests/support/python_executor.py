"""Operations of the loop over steps, performed by Python: the oracle of the loop in C.

FMUs are called by the same addresses; of FMI 3.0 and of values that are not Real, these are
functions of the C library.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from ctypes import c_double, c_int, c_size_t, c_void_p

import numpy as np
import pytest

from m4e_fmi.cosim.network import operations as op
from m4e_fmi.cosim.network.instance import WARNING, Instance
from m4e_fmi.cosim.network.operations import LOST, Operation
from m4e_fmi.cosim.network.schedule import NOT_A_NUMBER, LoopState
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.fmu.importer.calls.access import guarded

Action = Callable[[float, float, int], int]
"""Time [s], step [s], row of blocks → status."""
GET_OR_SET = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p)
SET_DERIVATIVES = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p, c_void_p)
DO_STEP = ctypes.CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_int)
SAVE_OR_RESTORE = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p)
NOISE = 1e-9
"""As in the runtime's loop.c."""


def use_python(patch: pytest.MonkeyPatch) -> None:
    """Have all operations be performed by Python from now on."""
    patch.setattr("m4e_fmi.cosim.network.schedule.NativeExecutor", PythonExecutor)
    patch.setattr("m4e_fmi.cosim.network.schedule.run_loop", run_loop)


class PythonExecutor:
    """Performs a list of operations, as `NativeExecutor` does."""

    def __init__(self, operations: Sequence[Operation]) -> None:
        self._actions = tuple(_when_due(operation) for operation in operations)
        self._in_rows = tuple(isinstance(o, op.Get | op.GetTyped) and o.in_rows for o in operations)

    def perform(
        self, time: float, size: float, row: int, *, at_row: bool = True
    ) -> tuple[int, int]:
        """Status and index of the operation that failed; (0, 0) if none did.

        Operations for rows only are performed `at_row`.
        """
        for index, action in enumerate(self._actions):
            if self._in_rows[index] and not at_row:
                continue
            status = action(time, size, row)
            if not 0 <= status <= WARNING:
                return status, index
        return 0, 0


def run_loop(step: PythonExecutor, row: PythonExecutor, state: LoopState, steps: int) -> int:
    """Status of `steps` steps, as of `m4e_loop` of the runtime's loop.h.

    They end early if another thread has asked for a halt, or one of the `ends` is finite.
    """
    ends = (c_void_p * state.end_count).from_address(state.ends) if state.end_count else ()
    for made in range(steps):
        if (made and state.halt) or any(
            math.isfinite(c_double.from_address(end).value) for end in ends if end
        ):
            return 0
        time, size = state.now / NS_PER_SECOND, state.size / NS_PER_SECOND
        at_row = state.since + 1 >= state.every or state.now + state.size >= state.rows_from
        status, state.failed = step.perform(time, size, state.noted, at_row=at_row)
        state.in_row = 0
        if status:
            return status
        state.now += state.size
        state.noted += 1
        state.since += 1
        if state.since < state.every:
            continue
        state.in_row = 1
        status, state.failed = row.perform(0.0, 0.0, state.written)
        if status:
            return status
        state.since = 0
        state.written += 1
    return 0


def _when_due(operation: Operation) -> Action:
    action, due = _action(operation), getattr(operation, "due", None)
    if due is None:
        return action
    return lambda t, h, row: action(t, h, row) if due.at(t + h) else 0


def _action(operation: Operation) -> Action:
    match operation:
        case op.Get():
            return _get(operation)
        case op.Set(instance, names, values):
            return _reals(instance, operation.function, names, values)
        case op.SetDerivatives(instance, names, values, order):
            call = instance.raw(operation.function, names)
            orders = np.array([order], dtype=np.int32)
            references, function = call.references, guarded(SET_DERIVATIVES, call.function)
            return lambda _t, _h, _row: function(
                call.component, references.ctypes.data, 1, orders.ctypes.data, values.ctypes.data
            )
        case op.DoStep(instance):
            return _step(instance, operation)
        case op.Save(instance):
            save, slot = _state_call(instance, operation.function), instance.slot()
            return lambda _t, _h, _row: save(ctypes.addressof(slot))
        case op.Restore(instance):
            restore, slot = _state_call(instance, operation.function), instance.slot()
            return lambda _t, _h, _row: restore(slot.value)
        case op.GetTyped(_, access, into):
            return lambda _t, _h, row: access.get(_row(into, row))
        case op.SetTyped(_, access, cells):
            return lambda _t, _h, _row: access.set(cells)
        case op.Choose():
            return lambda _t, _h, _row: 0 if choose(operation) else NOT_A_NUMBER
        case op.Combine():
            return _combine(operation)
        case op.Gather():
            return _gather(operation)
        case op.Monitor():
            return _monitor(operation)


def _state_call(instance: Instance, function: str) -> Callable[[int | None], int]:
    call = instance.raw(function)
    found = guarded(SAVE_OR_RESTORE, call.function)
    return lambda place: found(call.component, place)


def _step(instance: Instance, operation: op.DoStep) -> Action:
    span, warned = operation.span, instance.warned
    call = instance.raw(operation.function)
    step = guarded(DO_STEP, call.function)

    def do_step(t: float, h: float, _row: int) -> int:
        status = step(call.component, *span(t, h), 1)
        if status == WARNING:
            warned.first = warned.first if warned.count else t
            warned.count, warned.last = warned.count + 1, t
        return status

    return do_step


def _reals(instance: Instance, function: str, names: Sequence[str], values: np.ndarray) -> Action:
    call = instance.raw(function, names)
    found, references = guarded(GET_OR_SET, call.function), call.references

    def move(_t: float, _h: float, _row: int) -> int:
        return found(call.component, references.ctypes.data, len(names), values.ctypes.data)

    return move


def _get(operation: op.Get) -> Action:
    into, checked = operation.into, operation.checked
    values = into if into.ndim == 1 else np.zeros(len(operation.names))
    call = _reals(operation.instance, operation.function, operation.names, values)

    def get(t: float, h: float, row: int) -> int:
        status = call(t, h, row)
        if values is not into:
            into[row] = values
        if checked and status <= WARNING and not np.isfinite(values).all():
            return NOT_A_NUMBER
        return status

    return get


def choose(operation: op.Choose) -> bool:
    """Choose between two readings of each output; False if one is not finite, and should be."""
    first, second, before, new, size, lost = operation.readings
    into, changed = operation.into, operation.changed
    off = _differ(second, first) & _differ(before, first)
    if into.dtype == np.float64:
        np.fmax(size, np.abs(first), out=size, where=np.isfinite(first))
        with np.errstate(invalid="ignore"):
            limit = np.fmax(LOST * np.abs(new - first), NOISE * size)
            off &= ~(np.isfinite(second) & (np.abs(second - first) <= limit))
    found = np.where(off, first, new)
    if changed is not None and (found != into).any():
        changed[0] = 0.0
    into[:] = found
    lost[off] = 1
    return not operation.checked or bool(np.isfinite(into).all())


def _differ(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """True where values differ, (n,) booleans; two that are nan do not."""
    return (a != b) & ~(np.isnan(a) & np.isnan(b))


SUDDEN, DECAY, GROWTH, SHARE = 4.0, 0.95, 1.5, 1 / 16
"""As in the runtime's loop.c."""


def _monitor(o: op.Monitor) -> Action:
    """`monitor` of the runtime's loop.c."""
    value, first, second, third, level, largest = o.past[:-1].reshape(6, -1)
    wait = o.past[-1:]

    def monitor(_t: float, _h: float, row: int) -> int:
        d1 = o.source - value
        d2 = d1 - first
        d3 = d2 - second
        rough = np.abs(d3 - third)
        waits = wait[0] > 0.0
        sudden = (rough > np.maximum(SUDDEN * level, o.gate)) & (not waits)
        calm = np.maximum(rough, 0.0 if waits else DECAY * level)
        level[:] = np.where(sudden, np.maximum(GROWTH * level, SHARE * rough), calm)
        if not waits:
            np.maximum(largest, rough, out=largest)
        value[:], first[:], second[:], third[:] = o.source, d1, d2, d3
        wait[0] -= waits
        o.into[row] = sudden.sum()
        return 0

    return monitor


def _row(into: np.ndarray, row: int) -> np.ndarray:
    """The vector, or the block's row, that an operation fills."""
    return into if into.ndim == 1 else into[row]


def _gather(o: op.Gather) -> Action:
    def gather(_t: float, _h: float, row: int) -> int:
        _row(o.into, row)[:] = o.source[o.index]
        return 0

    return gather


def _combine(o: op.Combine) -> Action:
    into, source, terms = o.into, o.source, tuple(zip(o.weight, o.index, strict=True))
    product = np.zeros(into.shape[-1])

    def combine(_t: float, _h: float, row: int) -> int:
        result = _row(into, row)
        for k, (weight, index) in enumerate(terms):
            to = product if k else result
            np.multiply(weight, source[index], out=to)
            if k:
                result += product
        if o.offset is not None:
            result += o.offset
        return 0

    return combine
