"""Operations performed by the C library, on the FMUs' own functions: see the runtime's loop.h."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, c_double, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p

import numpy as np

from m4e_fmi.cosim.operations import Combine, DoStep, Get, Operation, Set
from m4e_fmi.cosim.standards import RawCall

NOT_A_NUMBER = -1
GET, SET, DO_STEP, COMBINE = range(4)


class RawOperation(ctypes.Structure):
    """`m4e_operation` of loop.h."""

    _fields_ = [
        ("kind", c_int32),
        ("count", c_uint32),
        ("terms", c_uint32),
        ("component", c_void_p),
        ("function", c_void_p),
        ("references", c_void_p),
        ("weights", c_void_p),
        ("source", c_void_p),
        ("offset", c_void_p),
        ("values", c_void_p),
        ("stride", c_uint64),
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
                call = self._call(GET, instance.raw("fmi2GetReal", names))
            case Set(instance, names, into):
                call = self._call(SET, instance.raw("fmi2SetReal", names))
            case DoStep(instance):
                return RawOperation(**self._call(DO_STEP, instance.raw("fmi2DoStep")))
            case Combine():
                return self._combination(operation)
        return RawOperation(**call, **self._target(into))

    def _call(self, kind: int, raw: RawCall) -> dict[str, int]:
        references = self._references(raw.references)
        function, component = raw.function, raw.component
        call = {"function": function, "component": component, "references": references}
        return {"kind": kind, **call}

    def _combination(self, o: Combine) -> RawOperation:
        terms = len(o.index)
        assert o.index.shape == o.weight.shape == (terms, o.into.shape[-1])
        return RawOperation(
            kind=COMBINE,
            terms=terms,
            references=self._references(o.index),
            weights=self._address(o.weight),
            source=self._address(o.source),
            offset=None if o.offset is None else self._address(o.offset),
            **self._target(o.into),
        )

    def _target(self, into: np.ndarray) -> dict[str, int]:
        stride = into.shape[1] if into.ndim == 2 else 0
        return {"count": into.shape[-1], "values": self._address(into), "stride": stride}

    def _references(self, array: np.ndarray) -> int:
        assert array.dtype == np.uint32
        return self._address(array)

    def _address(self, array: np.ndarray) -> int:
        assert array.flags.c_contiguous
        assert array.dtype in (np.float64, np.uint32)
        self._kept.append(array)
        return array.ctypes.data


def run(step: NativeExecutor, row: NativeExecutor, state: State, steps: int) -> int:
    """So many steps, fewer if an operation fails: its status. `state` tells how far it came."""
    state.step, state.step_count = ctypes.addressof(step.array), step.count
    state.row, state.row_count = ctypes.addressof(row.array), row.count
    return step.loop(state, steps)
