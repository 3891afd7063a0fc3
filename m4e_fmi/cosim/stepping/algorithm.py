"""Interface of an algorithm.

An algorithm is made from a Network. Its `step(time, size)` steps every component from the present
communication point, at which all values are consistent, by `size` seconds, which it notes as the
network's `size`; the network's `advance` follows. What it knows of the past is in the network's
`values` and `last`, and in its own snapshot, so that it can go on from another point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np


@dataclass(frozen=True)
class AlgorithmSnapshot:
    """Memory of earlier steps that an algorithm has: none, unless a subclass adds fields."""


class Algorithm(Protocol):
    """A way to step all components; `notes` say what it does without because an FMU cannot.

    `held` (n_inputs,) are the values held at the network's inputs during the last step, in their
    order and the units of their sources. `followed` (n_inputs,) is 1 for an input that goes along
    with its source during the step, and 0 for one that is held. In between it is the share of the
    first moment about the mean that the input has of its source's: 1 − 1/n² for n values that are
    held one after the other, each the mean. `order` is the power of the step with which the error
    falls, at least.
    """

    order: int
    notes: tuple[str, ...]

    @property
    def held(self) -> np.ndarray:
        """Values held at the inputs (n_inputs,), in their sources' units."""
        ...

    @property
    def followed(self) -> np.ndarray:
        """Shares (n_inputs,) [1] by which inputs follow their sources."""
        ...

    def step(self, time: float, size: float) -> None:
        """Step all components from `time` by `size` [s]."""
        ...

    def snapshot(self) -> AlgorithmSnapshot:
        """Everything that `restore` needs to continue from here."""
        ...

    def restore(self, snapshot: AlgorithmSnapshot) -> None:
        """Continue as from where the snapshot was taken."""
        ...


@runtime_checkable
class Undoing(Protocol):
    """An algorithm that can take its step back, also one that failed, where all FMUs can."""

    def undo(self) -> None:
        """Return all components to the start of the step."""
        ...


class ErrorEstimating(Algorithm, Undoing, Protocol):
    """An algorithm that estimates the error of its step, and so can have its step chosen.

    `change` (n_outputs,) is the estimated error of the exchanged outputs at the end of the step,
    or a bound of it; it falls with the power `estimate_order` of the step. `end` (n_outputs,) are
    their values there; both in the outputs' units.
    """

    @property
    def estimate_order(self) -> int: ...
    @property
    def change(self) -> np.ndarray:
        """Estimated errors of the outputs (n_outputs,), in their units."""
        ...

    @property
    def end(self) -> np.ndarray:
        """Values of the outputs at the end of the step (n_outputs,), in their units."""
        ...


@runtime_checkable
class OwnEstimate(ErrorEstimating, Protocol):
    """An algorithm with an estimate of its own; `estimates` if that covers all outputs."""

    @property
    def estimates(self) -> bool: ...
