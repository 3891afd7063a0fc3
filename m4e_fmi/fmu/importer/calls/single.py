"""Present values of single variables by name, each by a call that is prepared once."""

from __future__ import annotations

from collections.abc import Callable
from typing import NoReturn

import numpy as np

from m4e_fmi.fmu.importer.calls.functions import WARNING, Status
from m4e_fmi.fmu.importer.calls.standard import Call, Standard, Value
from m4e_fmi.fmu.importer.calls.texts import Texts
from m4e_fmi.fmu.importer.calls.typed import Access, value_in


class SingleValues:
    """Values of single variables of an instance, in the FMU's own units."""

    def __init__(self, fmu: Standard) -> None:
        self._fmu = fmu
        self._reals: dict[str, tuple[Call, np.ndarray]] = {}
        self._typed: dict[str, tuple[Access, np.ndarray]] = {}
        self._texts = Texts()

    def real(self, name: str) -> float:
        """The value of a Real."""
        if name not in self._reals:
            place = np.zeros(1)
            self._reals[name] = self._fmu.getter([name], place), place
        call, value = self._reals[name]
        self._fmu.check(call(), "fmi2GetReal")
        return float(value[0])

    def value(self, name: str, failed: Callable[[Status, Access, np.ndarray], NoReturn]) -> Value:
        """The value of a variable of another type; an item of an enumeration by number.

        `failed` raises for an access (status, access, cells (1,), int64 codes) that fails.
        """
        if name not in self._typed:
            cells = np.zeros(1, dtype=np.int64)
            self._typed[name] = self._fmu.typed([name], self._texts), cells
        access, cells = self._typed[name]
        status = access.get(cells)
        if not 0 <= status <= WARNING:
            failed(status, access, cells)
        (variable,) = self._fmu.variables([name])
        return value_in(int(cells[0]), variable, self._texts)
