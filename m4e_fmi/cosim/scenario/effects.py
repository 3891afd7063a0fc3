"""Effects of actions on a signal: what a taker is given in place of the value of its source.

All values are in the taker's unit, all times in nanoseconds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from m4e_fmi.cosim.scenario.random_numbers import normal, uniform

Memory = tuple[int | float, ...]
"""All that an effect knows of the past."""


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
    """Effect of one action on one taker of a signal.

    At every communication point `watch` is called, then `act` while the action is active; where
    what they are given changes there, both are called again.
    """

    memory: Memory = ()

    def kept(self) -> Memory:
        """The memory that `bring` needs to go on from here."""
        return self.memory

    def bring(self, memory: Memory) -> None:
        """Go on with a memory that was kept."""
        self.memory = memory

    def watch(self, now: int, given: Given, *, active: bool) -> None:
        """Note what would be given without this action, at the time `now`."""
        del now, given, active

    @abstractmethod
    def act(self, now: int, since: int, given: Given) -> Given:
        """The value given instead by an action that is active `since` a time."""


class Offset(Effect):
    """Adds an amount."""

    def __init__(self, amount: float) -> None:
        self._amount = amount

    def act(self, now: int, since: int, given: Given) -> Given:  # noqa: ARG002
        return replace(given, offset=given.offset + self._amount)


class Replace(Effect):
    """Gives another value, which `read` tells."""

    def __init__(self, read: Callable[[], float]) -> None:
        self._read = read

    def act(self, now: int, since: int, given: Given) -> Given:  # noqa: ARG002
        return given.held(self._read())


class Freeze(Effect):
    """Gives the value that there was when the action began."""

    def act(self, now: int, since: int, given: Given) -> Given:  # noqa: ARG002
        self.memory = self.memory or (given.value,)
        return given.held(float(self.memory[0]))


@dataclass(frozen=True)
class Draws:
    """Random drawings of a signal `name`, one every `every` [ns] of an action."""

    seed: int
    name: str
    every: int

    def index(self, now: int, since: int) -> int:
        """The number of the present drawing."""
        return (now - since) // self.every


class Noise(Effect):
    """Adds numbers of a normal distribution."""

    def __init__(self, deviation: float, draws: Draws) -> None:
        self._deviation, self._draws = deviation, draws

    def act(self, now: int, since: int, given: Given) -> Given:
        draws = self._draws
        drawn = self._deviation * normal(draws.seed, draws.name, draws.index(now, since))
        return replace(given, offset=given.offset + drawn)


class Dropout(Effect):
    """Gives the last value that was not lost, or `instead`, where the signal is lost.

    It is lost with the probability `share`.
    """

    def __init__(self, share: float, draws: Draws, instead: float | None) -> None:
        self._share, self._draws, self._instead = share, draws, instead

    def _is_lost(self, now: int, since: int) -> bool:
        draws = self._draws
        return self._share >= uniform(draws.seed, draws.name, draws.index(now, since))[0]

    def watch(self, now: int, given: Given, *, active: bool) -> None:  # noqa: ARG002
        if not active or not self.memory:
            self.memory = (given.value,)

    def act(self, now: int, since: int, given: Given) -> Given:
        if not self._is_lost(now, since):
            self.memory = (given.value,)
            return given
        return given.held(float(self.memory[0]) if self._instead is None else self._instead)


class Delay(Effect):
    """Gives the value of a time ago, interpolated between communication points.

    Before the start of the run the signal counts as constant.
    """

    def __init__(self, time: int) -> None:
        self._time = time
        self._times: deque[int] = deque()
        self._values: deque[float] = deque()

    def kept(self) -> Memory:
        """All times, then all values."""
        return (*self._times, *self._values)

    def bring(self, memory: Memory) -> None:
        """Go on with a history that was kept."""
        half = len(memory) // 2
        self._times = deque(map(int, memory[:half]))
        self._values = deque(map(float, memory[half:]))

    def watch(self, now: int, given: Given, *, active: bool) -> None:  # noqa: ARG002
        while len(self._times) > 1 and self._times[1] <= now - self._time:
            self._times.popleft()
            self._values.popleft()
        if self._times and self._times[-1] == now:
            self._times.pop()
            self._values.pop()
        self._times.append(now)
        self._values.append(given.value)

    def act(self, now: int, since: int, given: Given) -> Given:  # noqa: ARG002
        wanted = now - self._time
        later = bisect_right(self._times, wanted, hi=min(2, len(self._times)))
        if later == 0 or later == len(self._times):
            return given.held(self._values[max(0, later - 1)])
        (begin, end), (first, last) = (_pair(x, later) for x in (self._times, self._values))
        if wanted == begin:
            return given.held(first)
        return given.held(first + (last - first) * ((wanted - begin) / (end - begin)))


def _pair(values: Sequence[float], later: int) -> tuple[float, float]:
    """The value at a place, and the one before it."""
    before, after = islice(values, later - 1, later + 1)
    return before, after
