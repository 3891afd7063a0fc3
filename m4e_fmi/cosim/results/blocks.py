"""Recorded values of one component: rows in memory, and the operations that fill them.

Outputs are as they were exchanged, or read with those; what the network does not know, the FMU
tells. Reals are in a block of float64; all others in one of cells (`fmu.importer.calls.access`).
Outputs that leave the range which their FMU declares are noted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Get, GetTyped, Operation, gather
from m4e_fmi.cosim.scenario.plan import COMPONENT
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.results.row_file import CELLS, ResultColumn, RowSection
from m4e_fmi.results.series import TEXT, Recorded

ROUNDING = 1e-9
"""Share of its limits, nominal value or value by which an output may be outside by rounding."""
_WIDTHS = {f"{sign}Int{bits}": f"{'u' if sign else 'i'}{bits // 8}"
           for sign in ("", "U") for bits in (8, 16, 32, 64)}  # fmt: skip


class ComponentBlock:
    """Room for `rows` of some variables of a component, Real or not, filled by `operations`.

    `limited` are the columns that have a range; `outside` has a warning for each of them that was
    outside of it.
    """

    def __init__(
        self, network: Network, component: str, variables: Sequence[Variable], rows: int
    ) -> None:
        self._real = all(v.type == "Real" for v in variables)
        self.outside: dict[int, str] = {}
        self._variables = variables
        self.limited = [
            k
            for k, v in enumerate(variables)
            if self._real
            and v.causality in ("output", "local")
            and (math.isfinite(v.minimum) or math.isfinite(v.maximum))
        ]
        self._low = np.array([variables[k].minimum for k in self.limited])
        self._high = np.array([variables[k].maximum for k in self.limited])
        bounds = np.abs(np.array([self._low, self._high]))
        self._scale = np.where(np.isfinite(bounds), bounds, 0.0).max(axis=0, initial=0.0)
        self._scale = np.maximum(self._scale, [variables[k].nominal for k in self.limited])
        rate, instance = network.rates.get(component), network.instances[component]
        columns = tuple(_column(v) for v in variables)
        attributes = {"step_size": f"{rate.step:g} s"} if rate else {}
        kind = "f8" if self._real else CELLS
        self.section = RowSection(component, columns, kind, attributes)
        ask = network.known if self._real else network.discrete.known
        found = [ask(Port(component, v.name)) for v in variables]
        known = [place for place in found if place is not None]
        asked = tuple(v.name for v, p in zip(variables, found, strict=True) if p is None)
        self._known, self._asked = (np.zeros((rows, len(x)), kind) for x in (known, asked))
        order = sorted(range(len(found)), key=lambda k: found[k] is None)
        self._order = np.argsort(order)
        self.operations: list[Operation] = []
        if known:
            source = network.values if self._real else network.discrete.cells
            self.operations.append(gather(self._known, source, known))
        if asked and self._real:
            self.operations.append(Get(instance, asked, self._asked))
        elif asked:
            access = instance.typed(asked, network.discrete.texts)
            self.operations.append(GetTyped(instance, access, self._asked))

    def filled(self, rows: slice) -> np.ndarray:
        """Some of the rows (n_rows, n_variables), in the variables' units."""
        if not self._asked.size:
            return self._known[rows]
        return np.concatenate((self._known[rows], self._asked[rows]), axis=1)[:, self._order]

    def look(self, times: np.ndarray, rows: slice) -> None:
        """Note the first value outside its range of each variable, in rows at `times` (n,) [s]."""
        values = self.filled(rows)[:, self.limited]
        near = ROUNDING * np.maximum(self._scale, np.abs(values))
        outside = (values < self._low - near) | (values > self._high + near)
        for place in np.flatnonzero(outside.any(axis=0)).tolist():
            if place not in self.outside:
                row = int(np.argmax(outside[:, place]))
                self.outside[place] = self._warning(place, times[row], values[row, place])

    def _warning(self, place: int, time: float, value: float) -> str:
        variable = self._variables[self.limited[place]]
        unit = "" if variable.unit in ("", "1") else f" {variable.unit}"
        about = f": {variable.description}" if variable.description else ""
        return (
            f"{self.section.component}.{variable.name} is {value:.4g}{unit} at t = {time:.9g} s, "
            f"outside {self._low[place]:.4g} to {self._high[place]:.4g}{unit}, the range of its "
            f"FMU{about}"
        )


class ScenarioBlock:
    """Room for `rows` of the actions of a network's scenario: true while they are active."""

    def __init__(self, network: Network, rows: int) -> None:
        names, cells = network.scenario.names, network.scenario.cells
        truth = Recorded("Boolean", "i1")
        columns = tuple(
            ResultColumn(n, "", f"true while the action {n} is active", truth) for n in names
        )
        self.section = RowSection(COMPONENT, columns, CELLS)
        self._rows = np.zeros((rows, len(names)), dtype=np.int64)
        self.operations: list[Operation] = [gather(self._rows, cells, range(len(names)))]

    def filled(self, rows: slice) -> np.ndarray:
        """Some of the rows (n_rows, n_actions) [1], 1 for true."""
        return self._rows[rows]


def blocks(
    network: Network, component: str, variables: Sequence[Variable], rows: int
) -> list[ComponentBlock]:
    """The blocks of a component: one of Reals, and one of other variables if there are any."""
    reals = [v for v in variables if v.type == "Real"]
    others = [v for v in variables if v.type != "Real"]
    found = [ComponentBlock(network, component, reals, rows)]
    return [*found, ComponentBlock(network, component, others, rows)] if others else found


def _column(variable: Variable) -> ResultColumn:
    unit = variable.unit or "1" if variable.type == "Real" else ""
    return ResultColumn(variable.name, unit, variable.description, _recorded(variable))


def _recorded(variable: Variable) -> Recorded:
    if variable.type == "Real":
        return Recorded()
    if variable.type == "String":
        return Recorded("String", TEXT)
    if variable.type == "Boolean":
        return Recorded("Boolean", "i1")
    large = any(abs(number) >= 2**31 for number in variable.items.values())
    kind = _WIDTHS.get(variable.fmi_type, "i8" if large else "i4")
    return Recorded(variable.type, kind, dict(variable.items))
