"""Jacobi: every component steps with its inputs held at their values at the start of the step.

The order of the components does not matter. First order: a held input lags its source by half a
step on average, which feeds energy into an undamped pair of components.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.network import Network


class Jacobi:
    """See the module."""

    def __init__(self, network: Network) -> None:
        self._inputs = network.inputs
        self._steps = tuple(network.stepper(name) for name in network.instances)
        self.notes: tuple[str, ...] = ()
        self.order = 1
        self.held = np.zeros_like(network.inputs)

    def step(self, time: float, size: float) -> None:
        """Step all components from `time` by `size` [s]."""
        self.held[:] = self._inputs  # where the exchange before has set them
        for step in self._steps:
            step(time, size)
