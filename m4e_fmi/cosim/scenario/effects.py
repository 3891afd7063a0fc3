"""Effects of actions on a signal: what a taker is given in place of the value of its source.

All values are in the taker's unit.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Given:
    """The value of a taker through the next step: ``factor * source + offset``.

    `source` is the present value of its source, in the source's unit.
    """

    factor: float
    offset: float
    source: float

    @property
    def value(self) -> float:
        """The value that the taker is given now."""
        return self.factor * self.source + self.offset

    def held(self, value: float) -> Given:
        """A value that does not follow the source."""
        return Given(0.0, value, self.source)


class Effect(ABC):
    """Effect of one action on one taker of a signal; `memory` is all that it knows of the past.

    `act` is called at every communication point while the action is active; where what it is given
    changes there, it is called again.
    """

    memory: float | None = None

    @abstractmethod
    def act(self, given: Given) -> Given:
        """The value given instead of what would be given without this action."""


class Offset(Effect):
    """Adds an amount."""

    def __init__(self, amount: float) -> None:
        self._amount = amount

    def act(self, given: Given) -> Given:
        return replace(given, offset=given.offset + self._amount)


class Replace(Effect):
    """Gives another value."""

    def __init__(self, value: float) -> None:
        self._value = value

    def act(self, given: Given) -> Given:
        return given.held(self._value)


class Freeze(Effect):
    """Gives the value that there was when the action began."""

    def act(self, given: Given) -> Given:
        self.memory = given.value if self.memory is None else self.memory
        return given.held(self.memory)
