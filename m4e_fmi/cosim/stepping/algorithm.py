"""Coupling algorithms: their interface, the base of most, and the choice of one for a run.

An algorithm is made from a Network. Its `step(time, size)` steps every component from the present
communication point, at which all values are consistent, by `size` seconds, which it notes as the
network's `size`; the network's `advance` follows. What it knows of the past is in the network's
`values` and `last`, and in its own snapshot, so that it can go on from another point.

`Scheduled` algorithms perform the same operations in every step: their steps are repeated by a
`step_loop`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Operation
from m4e_fmi.cosim.network.restorable import Restorable, Snapshot
from m4e_fmi.cosim.network.schedule import Schedule, StepLoop
from m4e_fmi.coupling_algorithms import DEFAULT_ALGORITHM, algorithm_descriptor
from m4e_fmi.errors import RunError

BLOCK = 1024
"""Steps that are made at once, at most, and noted before they are evaluated."""
_HALVES = 1
"""Where the FMUs keep their states at the start of a step that is made in two halves."""


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

    def snapshot(self) -> Snapshot:
        """Everything that `restore` needs to continue from here."""
        ...

    def restore(self, snapshot: Snapshot) -> None:
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


class Scheduled(Restorable, ABC):
    """An algorithm whose step is `operations`, once it is prepared; the C library performs them.

    `held` (n_inputs,) is what they hold at the inputs, in the units of their sources: all through
    a step, unless `followed` (n_inputs,) says otherwise. All that it knows of the past is the
    network's.
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
    if not isinstance(algorithm, Scheduled):
        return None
    exchange, instances = network.operations, network.instances.values()
    if exchange is None or any(instance.description.has_events for instance in instances):
        return None
    step = Schedule([*algorithm.operations, *exchange, *noted])
    return StepLoop(step, rows, every=every, telling=network.telling, stops=network.stops)


def made(name: str, network: Network) -> Algorithm:
    """The algorithm `name` for `network`: of first order where values come a step late.

    RunError if it needs rollback that an FMU does not have.
    """
    descriptor = algorithm_descriptor(name)
    stepping = [network.instances[c] for c in network.execution_order if not network.due(c)]
    fixed = [i.name for i in stepping if not i.description.saves_state]
    if descriptor.needs_rollback and fixed:
        raise RunError(
            f"{name} needs FMUs that can roll back (canGetAndSetFMUstate), which "
            f"{' and '.join(fixed)} cannot",
            f"choose algorithm: {DEFAULT_ALGORITHM}, which does not need rollback and also solves "
            "loops",
        )
    algorithm: Algorithm = descriptor.make(network)
    notes = [
        f"{late[0]}{f' (and {len(late) - 1} more)' * (len(late) > 1)} {why}: first order, half "
        "the step leaves half the error"
        for why, late in network.late.items()
        if late
    ]
    if notes:
        algorithm.order = 1
        algorithm.notes = (*algorithm.notes, *notes)
    return algorithm


def error_estimating(name: str, network: Network) -> ErrorEstimating:
    """The algorithm `name` for `network`, with an estimate of its error in each step.

    RunError if an FMU cannot go back.
    """
    fixed = [name for name, i in network.instances.items() if not i.description.saves_state]
    if fixed:
        raise RunError(
            f"coupling_tolerance needs FMUs that can roll back (canGetAndSetFMUstate), which "
            f"{' and '.join(fixed)} cannot",
            "remove coupling_tolerance, and halve step_size to see the error",
        )
    algorithm = made(name, network)
    if isinstance(algorithm, OwnEstimate) and algorithm.estimates and algorithm.order > 1:
        return algorithm
    return StepHalving(network, algorithm)


class StepHalving:
    """Steps of any `algorithm` on `network`, each made whole, and again in two halves.

    Two halves of an algorithm of order p differ from the whole step by 2ᵖ − 1 times their own error
    in it. The halves count; `change` is their error. All FMUs must be able to go back.
    """

    def __init__(self, network: Network, algorithm: Algorithm) -> None:
        self._network = network
        self._algorithm = algorithm
        self._count = len(network.outputs)
        self._start = network.snapshot(_HALVES)
        self.order = algorithm.order
        self.estimate_order = algorithm.order + 1
        self.notes = algorithm.notes
        self.held = np.zeros_like(network.inputs)
        self.followed = (3 + algorithm.followed) / 4  # two means follow by 1 - 1/2²
        self.change = np.zeros(self._count)
        self.end = np.zeros(self._count)

    def step(self, time: float, size: float) -> None:
        """Step all components from `time` by `size` [s], in two halves."""
        network, algorithm = self._network, self._algorithm
        self._start = network.snapshot(_HALVES)
        _, before, echo = network.discrete.snapshot()
        algorithm.step(time, size)
        network.advance(time + size)
        whole = network.values[: self._count].copy()
        network.restore(self._start)
        half = size / 2
        algorithm.step(time, half)
        self.held[:] = algorithm.held / 2
        network.advance(time + half)
        algorithm.step(time + half, half)
        self.held += algorithm.held / 2
        middle, discrete = network.values.copy(), network.discrete.cells.copy()
        network.advance(time + size)
        self.end[:] = network.values[: self._count]
        self.change[:] = (whole - self.end) / (2.0**self.order - 1)
        network.values[:] = middle  # the master makes the end the present point
        network.discrete.restore((discrete, before, echo))
        network.time = time + half

    def undo(self) -> None:
        """Return all components to the start of the step."""
        self._network.restore(self._start)

    def snapshot(self) -> Snapshot:
        """The snapshot of its algorithm."""
        return self._algorithm.snapshot()

    def restore(self, snapshot: Snapshot) -> None:
        """Continue as from where the snapshot was taken."""
        self._algorithm.restore(snapshot)
