"""An FMI 3.0 FMU in this process, by FMPy's own classes: independent of m4e_fmi's master."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import fmpy
from fmpy import fmi3

Value = float | Sequence[float]


class Instance3:
    """An instance of the FMU at `path`, unpacked into `folder`; variables are called by name.

    `kind` is CoSimulation or ModelExchange. Arrays are sequences of numbers, row by row. Use it as
    a context manager: it is freed and its folder deleted at the end.
    """

    def __init__(
        self, path: Path, folder: Path, *, kind: str = "CoSimulation", **arguments: Any
    ) -> None:
        self.kind = kind
        self.messages: list[tuple[int, str]] = []
        self.folder = folder
        self.description: Any = fmpy.read_model_description(str(path))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.references = {name: v.valueReference for name, v in self.variables.items()}
        fmpy.extract(str(path), str(folder))
        exchange = kind == "ModelExchange"
        self.fmu: Any = (fmi3.FMU3Model if exchange else fmi3.FMU3Slave)(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="instance",
        )
        self.fmu.instantiate(**{"loggingOn": True, "logMessage": self._log, **arguments})

    def _log(self, _environment: Any, status: int, _category: Any, text: bytes) -> None:
        self.messages.append((status, text.decode("utf-8")))

    def __enter__(self) -> Instance3:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)

    def initialise(self, start: Mapping[str, Value] | None = None, **experiment: Any) -> Instance3:
        """Set `start` values and go through initialization mode."""
        self.set(start or {})
        self.fmu.enterInitializationMode(**experiment)
        self.fmu.exitInitializationMode()
        return self

    def size(self, name: str) -> int:
        """Number of elements of a variable."""
        count = 1
        for dimension in self.variables[name].shape:
            count *= dimension
        return count

    def set(self, values: Mapping[str, Value]) -> None:
        for name, value in values.items():
            numbers = [value] if isinstance(value, int | float) else list(value)
            self.fmu.setFloat64([self.references[name]], numbers)

    def all(self, name: str) -> list[float]:
        """Every element of a variable."""
        return self.fmu.getFloat64([self.references[name]], nValues=self.size(name))

    def __getitem__(self, name: str) -> float:
        (value,) = self.all(name)
        return value

    def numbers(self) -> list[str]:
        """Names of the variables of type Float64."""
        return [name for name, v in self.variables.items() if v.type == "Float64"]

    def step(self, t: float, h: float) -> tuple[bool, bool, bool, float]:
        """Event handling needed, end wanted, early return, time reached."""
        return self.fmu.doStep(t, h)

    def call(self, name: str, *arguments: Any) -> int:
        """Status of ``fmi3<name>``, which FMPy's checks of the status do not see."""
        function: Callable[..., int] = getattr(self.fmu.dll, f"fmi3{name}")
        return function(ctypes.c_void_p(self.fmu.component), *arguments)

    @property
    def last_error(self) -> str:
        return self.fmu.getString([self.references["last_error"]])[0]
