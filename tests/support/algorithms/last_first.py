"""Jacobi with its components in another order, the last first: of first order, too.

An algorithm in one file, used by `tests/unit/cosim/algorithms`.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Operation, gather
from m4e_fmi.cosim.stepping.algorithm import Scheduled
from m4e_fmi.coupling_algorithms import AlgorithmDescriptor, LinkDelay


class LastFirst(Scheduled):
    """One step of each component per macro step, all from the values at its start."""

    order = 1

    def __init__(self, network: Network) -> None:
        held = np.zeros(len(network.inputs))
        operations: list[Operation] = [gather(held, network.inputs, range(len(held)))]
        for name in reversed(list(network.instances)):
            operations += network.whole_step(name)
        super().__init__(network, operations, held)

    def prepare(self, size: float) -> None:
        """Nothing depends on the size."""


ALGORITHM = AlgorithmDescriptor(
    name="last_first",
    summary="all components step at once, the last first",
    order=LastFirst.order,
    link_delay=LinkDelay.ONE_STEP,
    needs_rollback=False,
    stability=0,
    make=LastFirst,
)
