"""Jacobi: every component steps with its inputs held at their values at the start of the step.

The order of the components does not matter. First order: a held input lags its source by half a
step on average, which feeds energy into an undamped pair of components.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Operation, gather
from m4e_fmi.cosim.stepping.algorithm import Scheduled
from m4e_fmi.coupling_algorithms import AlgorithmDescriptor, LinkDelay


class Jacobi(Scheduled):
    """One step of each component per macro step, all from the values at its start."""

    order = 1

    def __init__(self, network: Network) -> None:
        count = len(network.inputs)
        held = np.zeros(count)  # as set by the last exchange
        noted: list[Operation] = [gather(held, network.inputs, range(count))] if count else []
        steps = [operation for name in network.instances for operation in network.whole_step(name)]
        super().__init__(network, [*noted, *steps], held)

    def prepare(self, size: float) -> None:
        """Nothing depends on the size."""


ALGORITHM = AlgorithmDescriptor(
    name="jacobi",
    summary="all components step at once",
    order=Jacobi.order,
    link_delay=LinkDelay.ONE_STEP,
    needs_rollback=False,
    stability=0,
    make=Jacobi,
)
