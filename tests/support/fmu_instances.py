"""FMUs in this process, called alike in all versions and kinds, by FMPy's own classes alone.

They are independent of m4e_fmi's master.
"""

from __future__ import annotations

import ctypes
import math
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import fmi2, fmi3
from fmpy.fmi1 import FMICallException
from scipy.integrate import solve_ivp

from m4e_fmi.fmu.importer.messages import Messages

DISCARD, ERROR = 2, 3
Value = float | Sequence[float]


def _listed(value: Value) -> list[float]:
    return [value] if isinstance(value, int | float) else list(value)


def answers(status: int, action: Callable[[], object]) -> None:
    """Assert that a call answers `status`."""
    with pytest.raises(FMICallException) as caught:
        action()
    assert caught.value.status == status


def discarded(call: Callable[[], object]) -> None:
    """Assert that a call answers Discard."""
    answers(DISCARD, call)


def dependency_kinds(unknowns: Iterable[Any]) -> dict[str, dict[str, str]]:
    """The kinds of dependencies by name, of each of FMPy's `unknowns` by name."""
    return {
        u.variable.name: dict(
            zip([v.name for v in u.dependencies], u.dependenciesKind or (), strict=False)
        )
        for u in unknowns
    }


@dataclass(frozen=True)
class Kind:
    """A kind of FMU: natively or in Python, of FMI "2" or "3", for which way of use."""

    native: bool
    fmi: str = "2"
    exchange: bool = False

    @property
    def build(self) -> dict[str, Any]:
        """Options of `build_fmu`."""
        return {"native": self.native, "fmi": self.fmi}


FILES = {
    "python": Kind(native=False),
    "native 2": Kind(native=True),
    "native 3": Kind(native=True, fmi="3"),
}
"""Kinds of FMU files, which all are for co-simulation."""
EXCHANGE = {
    f"{name}, exchange": Kind(native=True, fmi=kind.fmi, exchange=True)
    for name, kind in FILES.items()
    if kind.native
}
KINDS = {**FILES, **EXCHANGE}


class Instance:
    """An instance of the FMU at `path`, unpacked into `folder`; variables are called by name.

    Values of several variables are a list of all their elements, row by row. Use it as a context
    manager: it is freed and its folder deleted at the end. A `description` that was read before
    saves reading it; further `arguments` are those of FMPy's `instantiate`.
    """

    version, numbers = 2, "Real"
    class_names: tuple[str, str] = ("FMU2Slave", "FMU2Model")

    def __init__(
        self,
        path: Path,
        folder: Path,
        *,
        exchange: bool = False,
        name: str = "instance",
        description: Any = None,
        **arguments: Any,
    ) -> None:
        self.folder, self.exchange = folder, exchange
        self.description: Any = description or fmpy.read_model_description(str(path))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.references = {name: v.valueReference for name, v in self.variables.items()}
        self.messages: list[tuple[int, str]] = []
        """Status and text of what was logged since the list was cleared; see `heard`."""
        fmpy.extract(str(path), str(folder))
        made = getattr(fmi2 if self.version == 2 else fmi3, self.class_names[exchange])
        self.fmu: Any = made(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.instantiate(**{"loggingOn": True, **arguments})

    def instantiate(self, **arguments: Any) -> None:
        # FMPy's proxy logs through the logger it was given last, for all FMUs of the process, also
        # once that one is gone: the logger of Messages stays
        self._messages = Messages()
        self.fmu.instantiate(callbacks=self._messages.callbacks, **arguments)

    def heard(self) -> list[tuple[int, str]]:
        """Status and text of what was logged since `messages` was cleared."""
        self.messages += self._messages.take()
        return self.messages

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, *_: object) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)

    # ---- phases ----

    def initialise(self, start: Mapping[str, Value] | None = None, **experiment: Any) -> Instance:
        """Set `start` values and go through initialization mode, in model exchange further on."""
        self.set(start or {})
        self.enter(**experiment)
        self.fmu.exitInitializationMode()
        if self.exchange:
            self.settle()
            self.fmu.enterContinuousTimeMode()
        return self

    def enter(self, **experiment: Any) -> None:
        """Enter initialization mode; `experiment` has startTime, stopTime and tolerance."""
        self.fmu.setupExperiment(**{"startTime": 0.0, **experiment})
        self.fmu.enterInitializationMode()

    def settle(self) -> None:
        """What there is to be done in event mode."""
        assert self.fmu.newDiscreteStates()[:5] == (False,) * 5

    def step(self, t: float, h: float) -> Any:
        """A step; in model exchange by SciPy's DOP853 at a tolerance of 1e-10."""
        if not self.exchange:
            return self.fmu.doStep(t, h)

        def rates(time: float, x: np.ndarray) -> np.ndarray:
            self.fmu.setTime(time)
            self.put_states(x)
            return self.rates()

        if self.states().size:
            start, limit = self.states(), 1e-10
            found = solve_ivp(rates, (t, t + h), start, "DOP853", rtol=limit, atol=limit)
            rates(t + h, found.y[:, -1])
        else:
            self.fmu.setTime(t + h)
        assert tuple(self.fmu.completedIntegratorStep()) == (False, False)
        return None

    # ---- values ----

    def set(self, values: Mapping[str, Value]) -> None:
        references = [self.references[name] for name in values]
        if references:
            self.fmu.setReal(references, [x for value in values.values() for x in _listed(value)])

    def change(self, values: Mapping[str, Value]) -> None:
        """Set values between steps: those of parameters in event mode, if there is one."""
        if not self.exchange:
            return self.set(values)
        self.fmu.enterEventMode()
        self.set(values)
        self.settle()
        return self.fmu.enterContinuousTimeMode()

    def get(self, names: Iterable[str]) -> list[float]:
        return self.fmu.getReal([self.references[name] for name in names])

    def __getitem__(self, name: str) -> float:
        (value,) = self.get([name])
        return value

    def size(self, name: str) -> int:
        """Number of elements of a variable."""
        return math.prod(self.variables[name].shape or ())

    def reals(self, *causalities: str) -> list[str]:
        """Names of the real variables of these causalities, of all if none is given."""
        return [
            name
            for name, v in self.variables.items()
            if v.type == self.numbers and (not causalities or v.causality in causalities)
        ]

    @property
    def last_error(self) -> str:
        text = self.fmu.getString([self.references["last_error"]])[0]
        return text if isinstance(text, str) else text.decode("utf-8")

    # ---- states of the FMU, and of model exchange ----

    def save(self) -> Any:
        return self.fmu.getFMUstate()

    def restore(self, state: Any) -> None:
        self.fmu.setFMUstate(state)

    def pack(self, state: Any) -> bytes:
        return self.fmu.serializeFMUstate(state)

    def unpack(self, content: bytes) -> Any:
        return self.fmu.deSerializeFMUstate(content)

    def _vector(self, function: str, values: Iterable[float] | None = None) -> np.ndarray:
        count = sum(map(self.size, self.state_names))
        array = np.zeros(count) if values is None else np.array(list(values))
        getattr(self.fmu, function)(array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), count)
        return array

    @property
    def state_names(self) -> list[str]:
        return [d.variable.derivative.name for d in self.description.derivatives]

    def states(self) -> np.ndarray:
        return self._vector("getContinuousStates")

    def put_states(self, values: Iterable[float]) -> None:
        self._vector("setContinuousStates", values)

    def rates(self) -> np.ndarray:
        return self._vector("getDerivatives")

    def nominals(self) -> np.ndarray:
        return self._vector("getNominalsOfContinuousStates")

    # ---- derivatives ----

    def slopes(
        self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]
    ) -> list[float]:
        """Directional derivatives of `unknowns` by `knowns`."""
        lists = ([self.references[name] for name in names] for names in (unknowns, knowns))
        return self.fmu.getDirectionalDerivative(*lists, list(seed))

    def output_rates(self, names: Sequence[str], order: int = 1) -> list[float]:
        """Derivatives of outputs by time, of an order."""
        references = [self.references[name] for name in names]
        return self.fmu.getRealOutputDerivatives(references, [order] * len(names))

    def call(self, name: str, *arguments: Any) -> int:
        """Status of ``fmi2<name>`` or ``fmi3<name>``, past FMPy's checks of it."""
        function: Callable[..., int] = getattr(self.fmu.dll, f"fmi{self.version}{name}")
        return function(ctypes.c_void_p(self.fmu.component), *arguments)


class Instance3(Instance):
    """The same of FMI 3.0."""

    version, numbers = 3, "Float64"
    class_names = ("FMU3Slave", "FMU3Model")

    def instantiate(self, **arguments: Any) -> None:
        self.fmu.instantiate(logMessage=self._log, **arguments)

    def _log(self, _environment: Any, status: int, _category: Any, text: bytes) -> None:
        self.messages.append((status, text.decode("utf-8")))

    def heard(self) -> list[tuple[int, str]]:
        return self.messages

    def enter(self, **experiment: Any) -> None:
        self.fmu.enterInitializationMode(**experiment)

    def settle(self) -> None:
        assert not any(self.fmu.updateDiscreteStates()[:5])

    def set(self, values: Mapping[str, Value]) -> None:
        for name, value in values.items():
            self.fmu.setFloat64([self.references[name]], _listed(value))

    def get(self, names: Iterable[str]) -> list[float]:
        listed = list(names)
        references = [self.references[name] for name in listed]
        return list(self.fmu.getFloat64(references, nValues=sum(map(self.size, listed))))

    def save(self) -> Any:
        return self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        self.fmu.setFMUState(state)

    def pack(self, state: Any) -> bytes:
        return self.fmu.serializeFMUState(state)

    def unpack(self, content: bytes) -> Any:
        return self.fmu.deserializeFMUState(content)

    def rates(self) -> np.ndarray:
        return self._vector("getContinuousStateDerivatives")

    def slopes(
        self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]
    ) -> list[float]:
        lists = ([self.references[name] for name in names] for names in (unknowns, knowns))
        count = sum(map(self.size, unknowns))
        return list(self.fmu.getDirectionalDerivative(*lists, list(seed), count))

    def output_rates(self, names: Sequence[str], order: int = 1) -> list[float]:
        n, size = len(names), sum(map(self.size, names))
        references = (ctypes.c_uint * n)(*(self.references[name] for name in names))
        orders, values = (ctypes.c_int32 * n)(*[order] * n), (ctypes.c_double * size)()
        counts = ctypes.c_size_t(n), ctypes.c_size_t(size)
        status = self.call("GetOutputDerivatives", references, counts[0], orders, values, counts[1])
        if status:
            raise FMICallException("fmi3GetOutputDerivatives", status=status)
        return list(values)


def opened(path: Path, folder: Path, kind: Kind, **arguments: Any) -> Instance:
    """An instance of the FMU at `path` in the way of its `kind`."""
    made = Instance3 if kind.fmi == "3" else Instance
    return made(path, folder, exchange=kind.exchange, **arguments)
