"""Operations performed by the C library, on the FMUs' own functions: see the runtime's loop.h."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, c_double, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p
from dataclasses import replace

import numpy as np

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
from m4e_fmi.cosim.standards import RawCall

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
        self._kept: list[np.ndarray] = []
        self.count = len(operations)
        self.array = (RawOperation * self.count)(*map(self._raw, operations))
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

    def _raw(self, operation: Operation) -> RawOperation:
        match operation:
            case Get(instance, names, into):
                return self._call(GET, instance.raw("fmi2GetReal", names), **self._target(into))
            case Set(instance, names, values):
                return self._call(SET, instance.raw("fmi2SetReal", names), **self._target(values))
            case SetDerivatives(instance, names, values):
                raw = instance.raw("fmi2SetRealInputDerivatives", names)
                raw = replace(raw, references=raw.references.repeat(2))
                orders = self._address(np.tile(np.array((1, 2), dtype=np.int32), len(names)))
                return self._call(SET_DERIVATIVES, raw, orders=orders, **self._target(values))
            case DoStep(instance, start, length):
                raw = instance.raw("fmi2DoStep")
                return self._call(DO_STEP, raw, start=start, length=length)
            case Save(instance):
                state = ctypes.addressof(instance.slot())
                return self._call(SAVE, instance.raw("fmi2GetFMUstate"), state=state)
            case Restore(instance):
                state = ctypes.addressof(instance.slot())
                return self._call(RESTORE, instance.raw("fmi2SetFMUstate"), state=state)
            case Combine():
                return self._combination(operation)

    def _call(self, kind: int, raw: RawCall, **rest: float) -> RawOperation:
        call = {"function": raw.function, "component": raw.component}
        return RawOperation(kind=kind, references=self._address(raw.references), **call, **rest)

    def _combination(self, o: Combine) -> RawOperation:
        terms = len(o.index)
        assert o.index.dtype == np.uint32
        assert o.index.shape == o.weight.shape == (terms, o.into.shape[-1])
        return RawOperation(
            kind=COMBINE,
            terms=terms,
            references=self._address(o.index),
            weights=self._address(o.weight),
            source=self._address(o.source),
            offset=None if o.offset is None else self._address(o.offset),
            **self._target(o.into),
        )

    def _target(self, into: np.ndarray) -> dict[str, int]:
        stride = into.shape[1] if into.ndim == 2 else 0
        return {"count": into.shape[-1], "values": self._address(into), "stride": stride}

    def _address(self, array: np.ndarray) -> int:
        assert array.flags.c_contiguous
        assert array.dtype in (np.float64, np.uint32, np.int32)
        self._kept.append(array)
        return array.ctypes.data


def run(step: NativeExecutor, row: NativeExecutor, state: State, steps: int) -> int:
    """So many steps, fewer if an operation fails: its status. `state` tells how far it came."""
    state.step, state.step_count = ctypes.addressof(step.array), step.count
    state.row, state.row_count = ctypes.addressof(row.array), row.count
    return step.loop(state, steps)
