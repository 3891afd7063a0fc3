"""What an engine is to the benchmark: something that prepares a system and evaluates it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from benchmark.systems import System

Numbers = Sequence[float] | NDArray[np.float64]

Batch = Callable[[int], float]
"""CPU seconds that so many evaluations take."""


class UnavailableError(Exception):
    """This engine cannot be measured here; the message says why."""


@dataclass(frozen=True)
class Prepared:
    """A system ready to run: u̇ at (q, u), how to time it at the last state, and what it cost.

    `preparation` is the CPU time [s] from the neutral description to here, compilers included.
    """

    accelerations: Callable[[Sequence[float], Sequence[float]], Numbers]
    batch: Batch
    preparation: float


class Engine(Protocol):
    """`largest` is the number of links beyond which preparing takes minutes, or is not written;
    `largest_with_loads` the same for trees with springs and dampers.
    """

    name: str
    largest: int
    largest_with_loads: int

    def prepare(self, system: System) -> Prepared:
        """Raises UnavailableError."""
        ...
