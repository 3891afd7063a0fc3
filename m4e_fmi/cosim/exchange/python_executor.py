"""Operations performed by Python: where there is no C library, and what that is checked against."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from m4e_fmi.cosim.exchange import operations as op
from m4e_fmi.cosim.exchange.events import ended
from m4e_fmi.cosim.exchange.instance import WARNING, Call, Instance
from m4e_fmi.cosim.exchange.native_executor import NOT_A_NUMBER, State
from m4e_fmi.cosim.exchange.operations import Operation
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND

Action = Callable[[float, float, int], int]
"""Time [s], step [s], row of blocks → status."""


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


def run(
    step: PythonExecutor,
    row: PythonExecutor,
    state: State,
    steps: int,
    telling: Sequence[Instance],
    stops: np.ndarray,
) -> int:
    """Status of `steps` steps, as of `m4e_loop` of the runtime's loop.h.

    They end early if one of `telling` has asked for the end, another thread for a halt, or one of
    `stops` (n,) [1] is finite.
    """
    for made in range(steps):
        if ended(telling) or (made and state.halt) or np.isfinite(stops).any():
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
            return _plain(instance.own_setter(names, values))
        case op.SetDerivatives(instance, names, values, order):
            return _plain(instance.own_derivative_setter(names[0], order, values))
        case op.DoStep(instance):
            return _step(instance, operation)
        case op.Save(instance):
            return _plain(instance.state_calls()[0])
        case op.Restore(instance):
            return _plain(instance.state_calls()[1])
        case op.GetTyped(_, access, into):
            return lambda _t, _h, row: access.get(_row(into, row))
        case op.SetTyped(_, access, cells):
            return lambda _t, _h, _row: access.set(cells)
        case op.Choose():
            return lambda _t, _h, _row: 0 if op.choose(operation) else NOT_A_NUMBER
        case op.Copy(source, places, into):
            return _take(into, source, places)
        case op.Combine():
            return _combine(operation)
        case op.Gather(into, source, index):
            return _take(into, source, index)
        case op.Monitor():
            return _monitor(operation)


def _step(instance: Instance, operation: op.DoStep) -> Action:
    step, span, warned = instance.stepper(), operation.span, instance.warned

    def do_step(t: float, h: float, _row: int) -> int:
        status = step(*span(t, h), 1)
        if status == WARNING:
            warned.note(t)
        return status

    return do_step


def _plain(call: Call) -> Action:
    return lambda _t, _h, _row: call()


def _get(operation: op.Get) -> Action:
    into, checked = operation.into, operation.checked
    values = into if into.ndim == 1 else np.zeros(len(operation.names))
    call = operation.instance.own_getter(operation.names, values)

    def get(_t: float, _h: float, row: int) -> int:
        status = call()
        if values is not into:
            into[row] = values
        if checked and status <= WARNING and not np.isfinite(values).all():
            return NOT_A_NUMBER
        return status

    return get


SUDDEN, DECAY, GROWTH, SHARE = 4.0, 0.95, 1.5, 1 / 16
"""As in the runtime's monitor.c."""


def _monitor(o: op.Monitor) -> Action:
    """`m4e_monitor` of the runtime's loop.h."""
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


def _take(into: np.ndarray, source: np.ndarray, index: np.ndarray) -> Action:
    def take(_t: float, _h: float, row: int) -> int:
        _row(into, row)[:] = source[index]
        return 0

    return take


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
