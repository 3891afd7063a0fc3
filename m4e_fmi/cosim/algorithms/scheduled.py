"""Base of the algorithms that do the same in every step: their step is a schedule."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.cosim.exchange.events import has_events, telling
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.exchange.operations import Operation
from m4e_fmi.cosim.exchange.step_loop import Schedule, StepLoop

if TYPE_CHECKING:
    from m4e_fmi.cosim.algorithms import Algorithm


class Scheduled(ABC):
    """`operations` make a step, once it is prepared; `held` is what they hold at the inputs.

    Inputs are held all through a step, unless `followed` says otherwise.
    """

    order: int

    def __init__(self, network: Network, operations: Sequence[Operation], held: np.ndarray) -> None:
        self.network = network
        self.operations = tuple(operations)
        self.held = held
        self.followed = np.zeros(len(held))
        self.notes: tuple[str, ...] = ()

    @abstractmethod
    def prepare(self, size: float) -> None:
        """Make `operations` those of a step of `size` [s] after the network's last one."""

    def repeats(self, size: float) -> bool:
        """Whether `operations`, which are prepared then, make any number of steps of `size` [s]."""
        same = size == self.network.last
        if same:
            self.prepare(size)
        return same

    @cached_property
    def _schedule(self) -> Schedule:
        return Schedule(self.operations)

    def step(self, time: float, size: float) -> None:
        """Step all components from `time` by `size` [s]."""
        self.network.size = size
        self.prepare(size)
        self._schedule.run(time, size)


def looped(
    algorithm: Algorithm,
    network: Network,
    noted: Sequence[Operation],
    rows: Schedule | None = None,
    *,
    every: int = 1,
) -> StepLoop | None:
    """The operations of a step, to be repeated while the algorithm `repeats`, and `noted` after it.

    None where no step is like another: the algorithm is not `Scheduled`, loops are solved, or FMUs
    may have events. It ends where a value changes that is no Real.
    """
    exchange = network.operations
    if exchange is None or not isinstance(algorithm, Scheduled):
        return None
    if has_events(network.instances.values()):
        return None
    step = Schedule([*algorithm.operations, *exchange, *noted])
    told = telling(network.instances.values())
    return StepLoop(step, rows, every=every, telling=told, stops=network.stops)
