"""Operations performed by the C library, on the FMUs' own functions: see the runtime's loop.h."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, c_double, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p
from weakref import WeakKeyDictionary

import numpy as np

from m4e_fmi.cosim.instance import Instance
from m4e_fmi.cosim.operations import (
    Combine,
    DoStep,
    Get,
    Operation,
    Restore,
    Save,
    Set,
    SetDerivatives,
)

NOT_A_NUMBER = -1
GET, SET, SET_DERIVATIVES, DO_STEP, SAVE, RESTORE, COMBINE = range(7)


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
        ("values", c_void_p),
        ("stride", c_uint64),
        ("start", c_double),
        ("length", c_double),
        ("own", c_double),
        ("origin", c_int64),
        ("period", c_int64),
    ]


class State(ctypes.Structure):
    """`m4e_loop_state` of loop.h."""

    _fields_ = [
        ("step", c_void_p),
        ("row", c_void_p),
        ("step_count", c_uint64),
        ("row_count", c_uint64),
        ("now", c_int64),
        ("size", c_int64),
        ("every", c_uint64),
        ("since", c_uint64),
        ("noted", c_uint64),
        ("written", c_uint64),
        ("failed", c_uint64),
        ("in_row", c_int32),
    ]


class NativeExecutor:
    """Performs a list of operations in one call, without the interpreter's lock."""

    def __init__(self, library: ctypes.CDLL, operations: Sequence[Operation]) -> None:
        self._kept = [_translated(operation) for operation in operations]
        self.count = len(operations)
        self.array = (RawOperation * self.count)(*(raw for raw, _ in self._kept))
        self._failed = c_uint64()
        self._perform = library.m4e_perform
        self._perform.argtypes = (
            c_void_p, c_size_t, c_double, c_double, c_uint64, POINTER(c_uint64),
        )  # fmt: skip
        self.loop = library.m4e_loop
        self.loop.argtypes = (POINTER(State), c_uint64)

    def perform(self, time: float, size: float, row: int) -> tuple[int, int]:
        """Status and index of the operation that failed; (0, 0) if none did."""
        failed = self._failed
        status = self._perform(self.array, self.count, time, size, row, failed)
        return (status, failed.value) if status else (0, 0)


Translated = tuple[RawOperation, tuple[np.ndarray, ...]]
"""An operation for the C library, and arrays that it needs."""

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
        case Get(instance, names, values):
            raw, kept = _call(GET, instance, "fmi2GetReal"), [instance.references(names)]
        case Set(instance, names, values):
            raw, kept = _call(SET, instance, "fmi2SetReal"), [instance.references(names)]
        case SetDerivatives(instance, names, values):
            raw = _call(SET_DERIVATIVES, instance, "fmi2SetRealInputDerivatives")
            orders = np.tile(np.array((1, 2), dtype=np.int32), len(names))
            kept = [instance.references(names).repeat(2), orders]
            raw.orders = _address(orders)
        case DoStep(instance, start, length, own):
            raw = _call(DO_STEP, instance, "fmi2DoStep")
            raw.start, raw.length, raw.own = start, length, own
            return raw, ()
        case Save(instance):
            raw = _call(SAVE, instance, "fmi2GetFMUstate")
            raw.state = ctypes.addressof(instance.slot())
            return raw, ()
        case Restore(instance):
            raw = _call(RESTORE, instance, "fmi2SetFMUstate")
            raw.state = ctypes.addressof(instance.slot())
            return raw, ()
        case Combine(values, source, index, weight, offset):
            assert index.shape == weight.shape == (len(index), values.shape[-1])
            raw, kept = RawOperation(kind=COMBINE, terms=len(index)), [index, weight, source]
            raw.weights, raw.source = _address(weight), _address(source)
            raw.offset = None if offset is None else _address(offset)
            kept += [] if offset is None else [offset]
    assert kept[0].dtype == np.uint32
    raw.references = _address(kept[0])
    raw.count, raw.values = values.shape[-1], _address(values)
    raw.stride = values.shape[1] if values.ndim == 2 else 0
    return raw, (*kept, values)


def _call(kind: int, instance: Instance, function: str) -> RawOperation:
    address = instance.address(function)
    return RawOperation(kind=kind, component=instance.handle, function=address)


def _address(array: np.ndarray) -> int:
    assert array.flags.c_contiguous
    assert array.dtype in (np.float64, np.uint32, np.int32)
    return array.ctypes.data


def run(step: NativeExecutor, row: NativeExecutor, state: State, steps: int) -> int:
    """So many steps, fewer if an operation fails: its status. `state` tells how far it came."""
    state.step, state.step_count = ctypes.addressof(step.array), step.count
    state.row, state.row_count = ctypes.addressof(row.array), row.count
    return step.loop(state, steps)
