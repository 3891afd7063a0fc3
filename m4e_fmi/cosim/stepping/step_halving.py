"""Error estimate for any algorithm: each step is made whole, and again in two halves.

Two halves of an algorithm of order p differ from the whole step by 2ᵖ − 1 times their own error in
it. The halves count; `change` is their error. All FMUs must be able to go back.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.stepping.algorithm import Algorithm, AlgorithmSnapshot

PLACE = 1
"""Where the FMUs keep their states at the start of a step."""


class StepHalving:
    """Steps of `algorithm` on `network`, with the estimate of their error."""

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
