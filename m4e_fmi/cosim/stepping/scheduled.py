"""Base of the algorithms that perform the same operations in every step, and their step loop."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from m4e_fmi.cosim.exchange.events import has_events, telling
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.exchange.operations import Operation
from m4e_fmi.cosim.exchange.step_loop import Schedule, StepLoop
from m4e_fmi.cosim.stepping.algorithm import Algorithm, AlgorithmSnapshot


class Scheduled(ABC):
    """An algorithm whose step is `operations`, once it is prepared; the C library performs them.

    `held` (n_inputs,) is what they hold at the inputs, in the units of their sources: all through
    a step, unless `followed` (n_inputs,) says otherwise.
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
        """True if `operations`, which are prepared then, make any number of steps of `size` [s]."""
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

    def snapshot(self) -> AlgorithmSnapshot:
        """Nothing: all that it knows of the past is the network's."""
        return AlgorithmSnapshot()

    def restore(self, snapshot: AlgorithmSnapshot) -> None:
        """Nothing is to be restored."""
        del snapshot


def step_loop(
    algorithm: Algorithm,
    network: Network,
    noted: Sequence[Operation],
    rows: Schedule | None = None,
    *,
    every: int = 1,
) -> StepLoop | None:
    """The operations of a step, repeated while the algorithm `repeats`, each time with `noted`.

    `rows` fill a row of the results after every so many steps. None where no step is like another:
    the algorithm is not `Scheduled`, loops are solved, or FMUs may have events. The loop ends where
    a value changes that is not Real.
    """
    exchange = network.operations
    if exchange is None or not isinstance(algorithm, Scheduled):
        return None
    if has_events(network.instances.values()):
        return None
    step = Schedule([*algorithm.operations, *exchange, *noted])
    told = telling(network.instances.values())
    return StepLoop(step, rows, every=every, telling=told, stops=network.stops)
