"""Jacobi with inputs held at the mean of their linear extrapolation: second order.

An example of an algorithm in one file, used by `tests/unit/cosim/algorithms`.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Combine, Operation, setting
from m4e_fmi.cosim.stepping.algorithm import Scheduled
from m4e_fmi.coupling_algorithms import AlgorithmDescriptor, LinkDelay


class ExtrapolatedJacobi(Scheduled):
    """One step of each component per macro step, with inputs y₀ + (y₀ − y₋) H/(2 H₋)."""

    order = 2

    def __init__(self, network: Network) -> None:
        sources = np.array([network.index(link.source) for link in network.links], dtype=np.uint32)
        index = np.array([network.now + sources, network.before + sources], dtype=np.uint32)
        held = np.zeros(len(sources))
        self._combine = Combine(held, network.values, index, np.zeros(index.shape))
        operations: list[Operation] = [self._combine]
        for name, instance in network.instances.items():
            own = network.input_slice(name)
            if links := network.links_to(name):
                operations += setting(instance, links, held[own])
            operations += [*network.steps(name), *network.arrival(name)]
        super().__init__(network, operations, held)

    def prepare(self, size: float) -> None:
        """Weights for this size, and that of the step before."""
        ahead = size / (2 * self.network.last) if self.network.last else 0.0
        self._combine.weight[0], self._combine.weight[1] = 1.0 + ahead, -ahead


ALGORITHM = AlgorithmDescriptor(
    name="extrapolated_jacobi",
    summary="all components step at once, with extrapolated inputs",
    order=ExtrapolatedJacobi.order,
    link_delay=LinkDelay.ONE_STEP,
    solves_loops=False,
    needs_rollback=False,
    stability=0,
    make=ExtrapolatedJacobi,
)
