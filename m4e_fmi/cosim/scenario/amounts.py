"""Amounts of actions on a signal, converted to the unit of its taker."""

from __future__ import annotations

import math

from m4e_fmi.cosim.connections.links import Link
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.units import Quantity, parse_quantity


class Amounts:
    """Converts amounts for the signal that a `link` carries, named by its source or its target.

    `variables` are those of source and target. A number is in the unit of the named variable, a
    text has a unit of its own. ValueError with a remedy for anything else.
    """

    def __init__(self, signal: str, link: Link, variables: tuple[Variable, Variable]) -> None:
        self.link = link
        self._variable = variables[0] if signal == str(link.source) else variables[1]
        self._target = variables[1]
        named_source = signal == str(link.source)
        self._factor, self._offset = (link.factor, link.offset) if named_source else (1.0, 0.0)

    def value(self, amount: object) -> float:
        """A value of the signal, as its taker gets it."""
        found = self._number(amount, offset=self._variable.offset)
        value = found if self._factor == 1.0 else self._factor * found
        value = value + self._offset if self._offset else value
        low, high = self._target.minimum, self._target.maximum
        if not low <= value <= high:
            raise ValueError(f"{self.link.target} takes {low:g} to {high:g} {self._target.unit}")
        return value

    def difference(self, amount: object) -> float:
        """A difference of two values, as the taker gets it."""
        found = self._number(amount, offset=None)
        return found if self._factor == 1.0 else self._factor * found

    def _number(self, amount: object, *, offset: float | None) -> float:
        """The amount in the unit of the named variable; a difference without `offset`."""
        number = (
            self._in_unit(parse_quantity(amount), offset) if isinstance(amount, str) else amount
        )
        assert isinstance(number, int | float)
        if not math.isfinite(number):
            raise ValueError("give a finite number")
        return float(number)

    def _in_unit(self, given: Quantity, offset: float | None) -> float:
        unit = self._variable.dimension
        if unit is None:
            return given.value
        if offset is None:
            return Quantity(given.value, given.unit).in_unit(unit)
        return given.in_unit(unit, offset)
