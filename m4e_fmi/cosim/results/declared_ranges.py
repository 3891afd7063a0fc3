"""Outputs that leave the range which their FMU declares, in the rows of the results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_fmi.fmu.importer.reading import Variable

ROUNDING = 1e-9
"""Share of its limits, nominal value or value by which an output may be outside by rounding."""


@dataclass
class RangeWatch:
    """The outputs of one component, `variables` in the order of the columns that it sees."""

    component: str
    variables: Sequence[Variable]
    _seen: dict[int, str] = field(default_factory=dict)

    def snapshot(self) -> dict[int, str]:
        """The warnings so far, by column."""
        return dict(self._seen)

    def restore(self, seen: Mapping[int, str]) -> None:
        """Go on after these warnings."""
        self._seen = dict(seen)

    def __post_init__(self) -> None:
        limits = [
            (k, v)
            for k, v in enumerate(self.variables)
            if v.causality in ("output", "local")
            and (math.isfinite(v.minimum) or math.isfinite(v.maximum))
        ]
        self._columns = [k for k, _ in limits]
        self._low = np.array([v.minimum for _, v in limits])
        self._high = np.array([v.maximum for _, v in limits])
        bounds = np.abs(np.array([self._low, self._high]))
        self._scale = np.where(np.isfinite(bounds), bounds, 0.0).max(axis=0, initial=0.0)
        self._scale = np.maximum(self._scale, [v.nominal for _, v in limits])

    def __bool__(self) -> bool:
        return bool(self._columns)

    def look(self, times: np.ndarray, values: np.ndarray) -> None:
        """Keep the first value outside its range of each variable.

        The rows are at `times` (n,) [s]; `values` (n, n_variables) in the variables' units.
        """
        values = values[:, self._columns]
        near = ROUNDING * np.maximum(self._scale, np.abs(values))
        outside = (values < self._low - near) | (values > self._high + near)
        if not outside.any():
            return
        for place in np.flatnonzero(outside.any(axis=0)):
            if place not in self._seen:
                row = int(np.argmax(outside[:, place]))
                self._seen[int(place)] = self._told(int(place), times[row], values[row, place])

    def _told(self, place: int, time: float, value: float) -> str:
        variable = self.variables[self._columns[place]]
        unit = "" if variable.unit in ("", "1") else f" {variable.unit}"
        about = f": {variable.description}" if variable.description else ""
        return (
            f"{self.component}.{variable.name} is {value:.4g}{unit} at t = {time:.9g} s, outside "
            f"{self._low[place]:.4g} to {self._high[place]:.4g}{unit}, the range of its FMU{about}"
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """One line for each output that was outside its range, with the first time."""
        return tuple(self._seen.values())
