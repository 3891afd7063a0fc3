"""One instance of an FMI 2.0 co-simulation FMU, called directly in its shared library.

FMPy loads the library; the calls of the time loop go to its functions with addresses prepared once,
which costs a third of FMPy's own methods.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import partial
from typing import Any, NoReturn

import numpy as np
from fmpy import fmi2

from m4e_fmi.cosim.binary import Binary
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.messages import STATUS, Messages
from m4e_fmi.fmu.reading import Description

WARNING, DISCARD, ERROR, FATAL = 1, 2, 3, 4
LAST_ERROR = "last_error"
"""Name of the string variable in which an FMU may explain what went wrong."""

Status = int
Call = Callable[[], Status]

_GET_OR_SET = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p
)
_DO_STEP = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int
)
_SET_DERIVATIVES = ctypes.CFUNCTYPE(
    ctypes.c_int,
    ctypes.c_void_p,
    ctypes.c_void_p,
    ctypes.c_size_t,
    ctypes.c_void_p,
    ctypes.c_void_p,
)
_SAVE = _RESTORE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)


class DiscardedError(RunError):
    """An FMU discarded a step; `reached` is the time [s] up to which it could, None if not told."""

    def __init__(self, message: str, remedy: str, reached: float | None) -> None:
        super().__init__(message, remedy)
        self.reached = reached


class Instance:
    """An instance named `name` of a loaded FMU; `close` it, or use it as a context manager.

    `scales` are factor and offset of the inputs that are set otherwise than by their own values.

    Every method raises RunError with component, time, the FMU's own words and a remedy when the
    FMU answers with more than a warning. After Fatal the FMU is never called again.
    """

    def __init__(self, name: str, description: Description, binary: Binary) -> None:
        self.name = name
        self.description = description
        self._messages = Messages()
        self.time = 0.0
        self._broken = False
        self._initialised = False
        self._kept: list[Any] = []
        self.scales: dict[str, tuple[float, float]] = {}
        self._states: dict[int, ctypes.c_void_p] = {}
        self._fmu: Any = None
        try:
            self._open(binary)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _open(self, binary: Binary) -> None:
        self._binary = binary
        self._fmu = copy(binary.functions)
        self._fmu.instanceName = self.name
        binary.in_use += 1
        try:
            self._fmu.instantiate(callbacks=self._messages.callbacks, loggingOn=True)
        except Exception as error:
            self._fmu.component = None
            message = f"{self._origin}: cannot be instantiated{self._own_words()}"
            raise RunError(message, "check the FMU alone: `fmpy simulate` on the file") from error
        dll = self._fmu.dll
        self._component = self._fmu.component
        self._get_real = _prototype(_GET_OR_SET, dll.fmi2GetReal)
        self._set_real = _prototype(_GET_OR_SET, dll.fmi2SetReal)
        self._do_step = _prototype(_DO_STEP, dll.fmi2DoStep)

    @property
    def _origin(self) -> str:
        return f"{self.name} ({self.description.path.name})"

    def setup(self, *, start: float, stop: float, tolerance: float | None) -> None:
        """Tell the experiment: times [s], relative tolerance (None: the FMU's own)."""
        self.time = start
        self._checked(
            "fmi2SetupExperiment",
            int(tolerance is not None),
            tolerance or 0.0,
            start,
            fmi2.fmi2True,
            stop,
        )

    def set_values(self, values: Mapping[str, float | int | bool | str]) -> None:
        """Set variables of any type by name, as far as FMI lets them be set at this time."""
        kinds = {
            "Real": ("fmi2SetReal", fmi2.fmi2Real),
            "Integer": ("fmi2SetInteger", fmi2.fmi2Integer),
            "Enumeration": ("fmi2SetInteger", fmi2.fmi2Integer),
            "Boolean": ("fmi2SetBoolean", fmi2.fmi2Boolean),
            "String": ("fmi2SetString", fmi2.fmi2String),
        }
        for name, value in values.items():
            variable = self.description.variables[name]
            function, kind = kinds[variable.type]
            data = (kind * 1)(value.encode("utf-8") if isinstance(value, str) else value)
            reference = (ctypes.c_uint * 1)(variable.value_reference)
            self._checked(function, reference, 1, data)

    def enter_initialization(self) -> None:
        self._checked("fmi2EnterInitializationMode")

    def exit_initialization(self) -> None:
        self._checked("fmi2ExitInitializationMode")
        self._initialised = True

    def _checked(self, function: str, *arguments: Any) -> None:
        if self._broken:
            raise RunError(f"{self._origin} has failed before and cannot be used any more")
        status = getattr(self._fmu.dll, function)(self._component, *arguments)
        if status > WARNING:
            self.fail(status, function)

    def scale_input(self, name: str, factor: float, offset: float) -> None:
        """From now on, calls that set or read `name` carry v where the FMU has factor·v + offset.

        So the master's values are in the unit of the input's source. `read` tells the FMU's own.
        """
        self.scales[name] = factor, offset

    def scales_of(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray] | None:
        """Factors and offsets of variables of `scale_input`; None if all are as they are."""
        if not any(name in self.scales for name in names):
            return None
        factor, offset = np.array([self.scales.get(name, (1.0, 0.0)) for name in names]).T
        return factor, offset

    def getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that reads the Real variables `names` into `view` (float64, contiguous)."""
        scales = self.scales_of(names)
        if scales is None:
            return self.own_getter(names, view)
        factor, offset = scales
        own = np.zeros(len(names))
        call = self.own_getter(names, own)

        def get() -> Status:
            status = call()
            view[:] = (own - offset) / factor
            return status

        return get

    def setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that sets the Real variables `names` from `view` (float64, contiguous)."""
        scales = self.scales_of(names)
        if scales is None:
            return self.own_setter(names, view)
        factor, offset = scales
        own = np.zeros(len(names))
        call = self.own_setter(names, own)

        def set_() -> Status:
            np.multiply(view, factor, out=own)
            np.add(own, offset, out=own)
            return call()

        return set_

    def own_getter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """As `getter`, in the FMU's own units."""
        return self._bound(self._get_real, names, view)

    def own_setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """As `setter`, in the FMU's own units."""
        return self._bound(self._set_real, names, view)

    @property
    def handle(self) -> int:
        """The FMU's component: first argument of its functions."""
        return self._component

    def address(self, function: str) -> int:
        """Address of a function of FMI in the FMU's library."""
        address = ctypes.cast(getattr(self._fmu.dll, function), ctypes.c_void_p).value
        assert address
        return address

    def references(self, names: Sequence[str]) -> np.ndarray:
        """Value references of variables, uint32."""
        variables = self.description.variables
        return np.array([variables[name].value_reference for name in names], dtype=np.uint32)

    def _bound(self, function: Any, names: Sequence[str], view: np.ndarray) -> Call:
        assert view.dtype == np.float64
        assert view.flags.c_contiguous
        assert view.shape == (len(names),)
        variables = self.description.variables
        references = (ctypes.c_uint * len(names))(*(variables[n].value_reference for n in names))
        self._kept += [references, view]
        address = ctypes.addressof(references)
        return partial(function, self._component, address, len(names), view.ctypes.data)

    def stepper(self) -> Callable[[float, float, int], Status]:
        """The call ``(t, h, 1) -> status`` that steps from t to t + h [s], never to be undone."""
        return partial(self._do_step, self._component)

    def own_derivative_setter(self, names: Sequence[str], view: np.ndarray) -> Call:
        """A call that gives inputs two time derivatives for the next step, in the FMU's own units.

        `view` holds, for each of the Real inputs `names`, its first, then its second derivative.
        """
        assert view.dtype == np.float64
        assert view.flags.c_contiguous
        assert view.shape == (2 * len(names),)
        references = self.references(names).repeat(2)
        orders = np.tile(np.array((1, 2), dtype=np.int32), len(names))
        self._kept += [references, orders, view]
        function = _prototype(_SET_DERIVATIVES, self._fmu.dll.fmi2SetRealInputDerivatives)
        addresses = (references.ctypes.data, len(references), orders.ctypes.data)
        return partial(function, self._component, *addresses, view.ctypes.data)

    def slot(self, place: int = 0) -> ctypes.c_void_p:
        """Where the FMU's state is that is kept in a place; nothing at first."""
        return self._states.setdefault(place, ctypes.c_void_p())

    def saver(self) -> Call:
        """A call that keeps the FMU's state as `save_state` does."""
        function = _prototype(_SAVE, self._fmu.dll.fmi2GetFMUstate)
        return partial(function, self._component, ctypes.addressof(self.slot()))

    def restorer(self) -> Call:
        """A call that brings the FMU back as `restore_state` does, where no step has failed."""
        function, slot = _prototype(_RESTORE, self._fmu.dll.fmi2SetFMUstate), self.slot()
        return lambda: function(self._component, slot.value)

    def save_state(self, place: int = 0) -> None:
        """Keep the FMU's state, instead of the one kept before in the same place."""
        self._checked("fmi2GetFMUstate", ctypes.byref(self.slot(place)))

    def restore_state(self, time: float, place: int = 0) -> None:
        """Bring the FMU back to the state kept in a place at `time` [s], also after a failed step.

        It may be restored again. After Fatal there is no way back.
        """
        self._broken = self._fmu.component is None
        self._checked("fmi2SetFMUstate", self.slot(place))
        self.time = time

    def directional_derivative(self, output: str, known: str) -> float:
        """∂output/∂known of two Real variables at the present instant; `known` may be scaled."""
        variables = self.description.variables
        references = [
            (ctypes.c_uint * 1)(variables[name].value_reference) for name in (output, known)
        ]
        seed, value = ctypes.c_double(1.0), ctypes.c_double()
        self._checked(
            "fmi2GetDirectionalDerivative",
            references[0],
            1,
            references[1],
            1,
            ctypes.byref(seed),
            ctypes.byref(value),
        )
        return value.value * self.scales.get(known, (1.0, 0.0))[0]

    def read(self, name: str) -> float:
        """The present value of the Real variable `name`."""
        value = np.zeros(1)
        status = self._bound(self._get_real, [name], value)()
        del self._kept[-2:]
        if status > WARNING:
            self.fail(status, "fmi2GetReal")
        return float(value[0])

    def fail(self, status: Status, function: str, size: float = 0.0) -> NoReturn:
        """Raise what this status of `function` means; `size` is that of a failed step [s]."""
        self._broken = True
        what = f"{function} answered {STATUS.get(status, status)}"
        remedy = "the FMU's own message above tells why"
        if function == "fmi2DoStep":
            what = f"the step from t = {self.time:.9g} s to {self.time + size:.9g} s failed"
            what += f" (fmi2DoStep answered {STATUS.get(status, status)})"
            remedy = f"try a step_size below {size:g} s, or other parameters and start values"
        elif self._initialised:
            what += f" at t = {self.time:.9g} s"
        else:
            what += " during initialisation"
            remedy = "check its parameters and start values"
        words = self._own_words(status)
        if status >= FATAL:
            self._fmu.component = None
        message = f"{self._origin}: {what}{words}"
        if status == DISCARD and function == "fmi2DoStep":
            raise DiscardedError(message, remedy, self._reached())
        raise RunError(message, remedy)

    def _reached(self) -> float | None:
        """Time [s] up to which the step could be made that has just been discarded."""
        value = ctypes.c_double()
        kind = fmi2.fmi2LastSuccessfulTime
        status = self._fmu.dll.fmi2GetRealStatus(self._component, kind, ctypes.byref(value))
        return value.value if status <= WARNING and math.isfinite(value.value) else None

    def not_finite(self, names: Sequence[str], values: np.ndarray) -> NoReturn:
        """Raise for the first of the outputs `names` whose value is nan or infinite."""
        name, value = next(
            (n, v) for n, v in zip(names, values, strict=True) if not math.isfinite(v)
        )
        self._broken = True
        when = f"at t = {self.time:.9g} s" if self._initialised else "during initialisation"
        message = f"{self.name}.{name} {when} is {value}{self._own_words(DISCARD)}"
        raise RunError(message, "try a smaller step_size; check parameters and start values")

    def _own_words(self, status: Status = FATAL) -> str:
        """What the FMU says about its failure, to stand behind our own message."""
        text = self._last_error() if status in (DISCARD, ERROR) else ""
        text = text or self._messages.last()
        return f": {text}" if text else ""

    def _last_error(self) -> str:
        variable = self.description.variables.get(LAST_ERROR)
        if variable is None or variable.type != "String":
            return ""
        reference, value = (ctypes.c_uint * 1)(variable.value_reference), (ctypes.c_char_p * 1)()
        status = self._fmu.dll.fmi2GetString(self._component, reference, 1, value)
        text = value[0]
        return text.decode("utf-8", errors="replace").strip() if status <= WARNING and text else ""

    def close(self) -> None:
        """Terminate and free as far as the FMU's condition allows."""
        fmu, self._fmu = self._fmu, None
        if fmu is not None and fmu.component is not None:
            status = 0
            if self._initialised and not self._broken:
                status = fmu.dll.fmi2Terminate(fmu.component)
            for state in self._states.values():
                if state and not self._broken:
                    fmu.dll.fmi2FreeFMUstate(fmu.component, ctypes.byref(state))
            if status < FATAL:
                fmu.fmi2FreeInstance(fmu.component)
                self._binary.in_use -= 1
        self._kept.clear()


def _prototype(kind: Any, function: Any) -> Any:
    """The same C function with plain integer addresses as arguments, the fastest to convert."""
    return kind(ctypes.cast(function, ctypes.c_void_p).value)
