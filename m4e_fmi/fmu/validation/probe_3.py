"""Calling an FMI 3.0 FMU as `Probe` calls one of FMI 2.0: the same methods, other functions.

Value references are the keys of `elements`. Where only some elements of an array are set, the
others get what they were last set to, or their start values: FMI sets whole arrays only.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from fmpy import fmi3

from m4e_fmi.fmu.importer.elements import locate
from m4e_fmi.fmu.importer.messages import Messages
from m4e_fmi.fmu.validation.probe import OK, REALS, TOLERANCE, WARNING, Probe, RefusedError


class Probe3(Probe):
    """One instance of an FMI 3.0 FMU, without event mode in co-simulation unless asked for."""

    _PREFIX = "fmi3"
    BYTE = ctypes.c_uint8
    _BOOLEAN = ctypes.c_bool
    _RENAMED: ClassVar[dict[str, str]] = {
        "GetDerivatives": "GetContinuousStateDerivatives",
        "GetFMUstate": "GetFMUState",
        "SetFMUstate": "SetFMUState",
        "FreeFMUstate": "FreeFMUState",
        "SerializedFMUstateSize": "SerializedFMUStateSize",
        "SerializeFMUstate": "SerializeFMUState",
        "DeSerializeFMUstate": "DeserializeFMUState",
    }

    def _instantiate(self, name: str, guid: str) -> Any:
        self._messages = Messages()
        self._stop: float | None = None
        self._reached = self.time
        self._held: dict[int, np.ndarray] = {}
        folder = self.library.subject.folder / "resources"
        resources = f"{folder}/".encode() if folder.is_dir() else None
        first = (name.encode("utf-8"), guid.encode("utf-8"), resources, False, True)
        log = self._log = fmi3.fmi3LogMessageCallback(self._messages.add_3)
        if self.exchange:
            return self._dll.fmi3InstantiateModelExchange(*first, None, log)
        none = fmi3.fmi3IntermediateUpdateCallback()
        how = (self._events, False, None, 0, None, log, none)
        return self._dll.fmi3InstantiateCoSimulation(*first, *how)

    # ---- the book ----

    def setup(self, *, stop: float | None = None) -> None:
        self.time = self._reached = self.library.subject.start_time
        self._stop = stop

    def enter_initialization(self) -> None:
        end = (self._stop is not None, self._stop or 0.0)
        note = f"start={self.time:g}, stop={self._stop}"
        self.must("EnterInitializationMode", True, TOLERANCE, self.time, *end, note=note)

    def settle(self) -> None:
        for _ in range(100):
            flags = [ctypes.c_bool() for _ in range(5)]
            following = ctypes.c_double()
            self.must("UpdateDiscreteStates", *map(ctypes.byref, (*flags, following)))
            if not flags[0].value:
                return
        raise RefusedError("fmi3UpdateDiscreteStates, 100 times,", WARNING, self.words())

    def step(self, size: float) -> int:
        note = f"t={self.time:.9g}, h={size:.9g}"
        flags = [ctypes.c_bool() for _ in range(3)]
        reached = ctypes.c_double(np.nan)
        outcome = map(ctypes.byref, (*flags, reached))
        status = self.call("DoStep", self.time, size, False, *outcome, note=note)
        self._reached = reached.value
        if status <= WARNING:
            self.time += size
        return status

    def last_successful_time(self) -> tuple[int, float]:
        return OK, self._reached

    def reset(self) -> None:
        super().reset()
        self._held.clear()

    # ---- values ----

    def set(self, references: Sequence[int], values: np.ndarray, note: str = "") -> int:
        if not len(references):
            return OK
        arrays = {reference: self._last_set(reference) for reference in _arrays(references)}
        for key, value in zip(references, np.asarray(values, dtype=np.float64), strict=True):
            reference, index = locate(key)
            arrays[reference][index] = value
        data = np.concatenate(list(arrays.values()))
        given = _references(list(arrays))
        pointer = data.ctypes.data_as(REALS)
        status = self.call("SetFloat64", given, len(given), pointer, len(data), note=note)
        if status <= WARNING:
            self._held |= arrays
        return status

    def _last_set(self, reference: int) -> np.ndarray:
        held = self._held.get(reference)
        return self.library.subject.array_start(reference) if held is None else held.copy()

    def get(self, references: Sequence[int]) -> tuple[int, np.ndarray]:
        if not len(references):
            return OK, np.zeros(0)
        given, count, places = self._laid_out(references)
        status, found = self._filled("GetFloat64", count, given, len(given))
        return status, found[places]

    def _laid_out(self, keys: Sequence[int]) -> tuple[Any, int, list[int]]:
        """Value references of whole arrays, number of their elements, where the keys are."""
        offsets, count = {}, 0
        for reference in _arrays(keys):
            offsets[reference] = count
            count += len(self.library.subject.array_start(reference))
        places = [offsets[reference] + index for reference, index in map(locate, keys)]
        return _references(list(offsets)), count, places

    def counted(self, count: int) -> tuple[int, ...]:
        return (count,)

    # ---- derivatives ----

    def directional(
        self, unknowns: Sequence[Any], knowns: Sequence[Any], seed: np.ndarray
    ) -> np.ndarray:
        return self._sensitivity("GetDirectionalDerivative", unknowns, knowns, seed)

    def adjoint(
        self, unknowns: Sequence[Any], knowns: Sequence[Any], seed: np.ndarray
    ) -> np.ndarray:
        return self._sensitivity("GetAdjointDerivative", unknowns, knowns, seed, adjoint=True)

    def _sensitivity(
        self,
        function: str,
        unknowns: Sequence[Any],
        knowns: Sequence[Any],
        seed: np.ndarray,
        *,
        adjoint: bool = False,
    ) -> np.ndarray:
        z, n, rows = self._laid_out([v.valueReference for v in unknowns])
        v, m, columns = self._laid_out([v.valueReference for v in knowns])
        if adjoint:
            n, rows, m, columns = m, columns, n, rows
        data = np.zeros(m)
        np.add.at(data, columns, seed)
        arguments = (z, len(z), v, len(v), data.ctypes.data_as(REALS), m)
        status, found = self._filled(function, n, *arguments)
        self.require(status, f"fmi3{function}")
        return found[rows]

    def output_derivatives(self, outputs: Sequence[Any], order: int) -> np.ndarray:
        y, count, places = self._laid_out([v.valueReference for v in outputs])
        orders = (ctypes.c_int32 * len(y))(*[order] * len(y))
        status, found = self._filled("GetOutputDerivatives", count, y, len(y), orders)
        self.require(status, "fmi3GetOutputDerivatives")
        return found[places]


def _arrays(keys: Sequence[int]) -> list[int]:
    return list(dict.fromkeys(locate(key)[0] for key in keys))


def _references(references: Sequence[int]) -> Any:
    return (ctypes.c_uint * len(references))(*references)
