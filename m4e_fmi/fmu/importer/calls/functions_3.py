"""C functions of FMI 3.0, for co-simulation and model exchange."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence

import numpy as np
from fmpy import fmi3

from m4e_fmi.fmu.importer.calls.functions import (
    OK,
    Arrays,
    Functions,
    Invoke,
    Status,
    pointer_to,
    references_of,
)
from m4e_fmi.fmu.importer.messages import Messages

_RENAMED = {
    "GetReal": "GetFloat64",
    "SetReal": "SetFloat64",
    "GetDerivatives": "GetContinuousStateDerivatives",
    "GetFMUstate": "GetFMUState",
    "SetFMUstate": "SetFMUState",
    "FreeFMUstate": "FreeFMUState",
    "SerializedFMUstateSize": "SerializedFMUStateSize",
    "SerializeFMUstate": "SerializeFMUState",
    "DeSerializeFMUstate": "DeserializeFMUState",
}


class StepOutcome:
    """Answers of fmi3DoStep besides its status."""

    def __init__(self) -> None:
        self._event, self._end, self._early = (ctypes.c_bool() for _ in range(3))
        self._last = ctypes.c_double()
        places = (self._event, self._end, self._early, self._last)
        self.arguments = tuple(ctypes.byref(place) for place in places)

    def clear(self, reached: float) -> None:
        """Prepare a step; `reached` stays where the FMU does not tell a time."""
        self._event.value = self._end.value = self._early.value = False
        self._last.value = reached

    @property
    def event(self) -> bool:
        """True if an event is to be handled."""
        return self._event.value

    @property
    def end(self) -> bool:
        """True if the FMU asks for the end of the simulation."""
        return self._end.value

    @property
    def early(self) -> bool:
        """True if the FMU returned before the end of the step."""
        return self._early.value

    @property
    def reached(self) -> float:
        """Last successful time [s]."""
        return self._last.value


class DiscreteStates:
    """Answers of fmi3UpdateDiscreteStates besides its status."""

    def __init__(self) -> None:
        self._flags = [ctypes.c_bool() for _ in range(5)]
        self._following = ctypes.c_double()
        self.arguments = tuple(ctypes.byref(place) for place in (*self._flags, self._following))

    @property
    def again(self) -> bool:
        """True if another event iteration is needed."""
        return self._flags[0].value

    @property
    def end(self) -> bool:
        """True if the FMU asks for the end of the simulation."""
        return self._flags[1].value

    @property
    def next_event(self) -> float:
        """Time [s] of the next time event; infinite if none is defined."""
        return self._following.value if self._flags[4].value else math.inf


class Functions3(Functions):
    """Functions of one instance of FMI 3.0; `outcome` is that of the last step."""

    PREFIX = "fmi3"
    BOOLEAN = ctypes.c_bool
    BYTE = ctypes.c_uint8

    def __init__(self, dll: ctypes.CDLL, call: Invoke) -> None:
        super().__init__(dll, call)
        self.outcome = StepOutcome()
        self._experiment = (0.0, None, None)

    def name(self, function: str) -> str:
        return self.PREFIX + _RENAMED.get(function, function)

    def instantiate(
        self,
        name: str,
        token: str,
        resources: bytes | None,
        messages: Messages,
        *,
        exchange: bool = False,
        event_mode: bool = False,
        early_return: bool = False,
    ) -> int | None:
        """The component of a new instance; None if refused.

        `resources` is the path of the FMU's folder, with a separator at its end.
        """
        first = (name.encode("utf-8"), token.encode("utf-8"), resources, False, True)
        log = self._log = fmi3.fmi3LogMessageCallback(messages.add_3)  # kept as long as this is
        if exchange:
            return self._dll.fmi3InstantiateModelExchange(*first, None, log)
        update = fmi3.fmi3IntermediateUpdateCallback()
        how = (event_mode, early_return, (ctypes.c_uint * 0)(), 0, None, log, update)
        return self._dll.fmi3InstantiateCoSimulation(*first, *how)

    def setup(self, *, start: float, stop: float | None, tolerance: float | None) -> Status:
        self._experiment = start, stop, tolerance
        self.outcome.clear(start)
        return OK

    def enter_initialization(self) -> Status:
        start, stop, tolerance = self._experiment
        return self._call(
            "EnterInitializationMode",
            tolerance is not None,
            tolerance or 0.0,
            start,
            stop is not None,
            stop or 0.0,
            note=f"start={start:g}, stop={stop}",
        )

    def do_step(self, time: float, size: float, final: int, reached: float = math.nan) -> Status:
        """As in FMI 2.0; `reached` [s] is the `outcome`'s where the FMU tells no time."""
        self.outcome.clear(reached)
        note = f"t={time:.9g}, h={size:.9g}"
        return self._call("DoStep", time, size, final, *self.outcome.arguments, note=note)

    def last_successful_time(self) -> tuple[Status, float]:
        return OK, self.outcome.reached

    def update_discrete_states(self, states: DiscreteStates) -> Status:
        """One event iteration in event mode, with its answers in `states`."""
        return self._call("UpdateDiscreteStates", *states.arguments)

    def needs_new_discrete_states(self) -> tuple[Status, bool]:
        states = DiscreteStates()
        return self.update_discrete_states(states), states.again

    def arrays(self, keys: Sequence[int], sizes: Mapping[int, int]) -> Arrays:
        return Arrays.of(keys, sizes)

    def get_reals(self, arrays: Arrays, values: np.ndarray) -> Status:
        return self._with_values("GetFloat64", arrays, values, f"{len(values)} values")

    def set_reals(self, arrays: Arrays, values: np.ndarray, note: str = "") -> Status:
        return self._with_values("SetFloat64", arrays, values, note)

    def _with_values(self, function: str, arrays: Arrays, values: np.ndarray, note: str) -> Status:
        count = len(arrays.references)
        arguments = (references_of(arrays), count, pointer_to(values), len(values))
        return self._call(function, *arguments, note=note)

    def directional_derivative(
        self, unknowns: Arrays, knowns: Arrays, seed: np.ndarray, found: np.ndarray
    ) -> Status:
        return self._sensitivity("GetDirectionalDerivative", unknowns, knowns, seed, found)

    def adjoint_derivative(
        self, unknowns: Arrays, knowns: Arrays, seed: np.ndarray, found: np.ndarray
    ) -> Status:
        """Write the derivatives of a weighted sum of the unknowns by the knowns.

        `found` (n_knowns,), and the weights `seed` (n_unknowns,), are in the variables' units.
        """
        return self._sensitivity("GetAdjointDerivative", unknowns, knowns, seed, found)

    def _sensitivity(
        self,
        function: str,
        unknowns: Arrays,
        knowns: Arrays,
        seed: np.ndarray,
        found: np.ndarray,
    ) -> Status:
        return self._call(
            function,
            references_of(unknowns),
            len(unknowns.references),
            references_of(knowns),
            len(knowns.references),
            pointer_to(seed),
            len(seed),
            pointer_to(found),
            len(found),
            note=f"{len(found)} values",
        )

    def output_derivatives(self, outputs: Arrays, order: int, found: np.ndarray) -> Status:
        count = len(outputs.references)
        orders = (ctypes.c_int32 * count)(*[order] * count)
        arguments = (references_of(outputs), count, orders, pointer_to(found), len(found))
        return self._call("GetOutputDerivatives", *arguments, note=f"{len(found)} values")
