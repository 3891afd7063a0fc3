"""The algorithm of a run: made for a network by name, with an error estimate where steps adapt."""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.connections.structure import STEPPED, how_known
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.stepping.algorithm import (
    Algorithm,
    AlgorithmSnapshot,
    ErrorEstimating,
    OwnEstimate,
)
from m4e_fmi.coupling_algorithms import DEFAULT_ALGORITHM, algorithm_descriptor
from m4e_fmi.errors import RunError

PLACE = 1
"""Where the FMUs keep their states at the start of a step that is made in two halves."""


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
    algorithm = descriptor.make(network)
    delayed = [str(link) for link in network.links if link.delayed]
    described = {name: instance.description for name, instance in network.instances.items()}
    stepped = dict.fromkeys(
        str(port)
        for port in (link.source for link in network.links)
        if how_known(described[port.component], port.variable) == STEPPED
    )
    notes = [
        f"{late[0]}{f' (and {len(late) - 1} more)' * (len(late) > 1)} {what}: first order, half "
        "the step leaves half the error"
        for late, what in (
            (delayed, "has the value of the previous step"),
            (list(stepped), "shows its FMU's inputs only after the next step"),
        )
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
        self._start = network.snapshot(PLACE)
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
        self._start = network.snapshot(PLACE)
        _, before, echo = network.discrete.kept()
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
        network.discrete.bring((discrete, before, echo))
        network.time = time + half

    def undo(self) -> None:
        """Return all components to the start of the step."""
        self._network.restore(self._start)

    def snapshot(self) -> AlgorithmSnapshot:
        """The snapshot of its algorithm."""
        return self._algorithm.snapshot()

    def restore(self, snapshot: AlgorithmSnapshot) -> None:
        """Continue as from where the snapshot was taken."""
        self._algorithm.restore(snapshot)
