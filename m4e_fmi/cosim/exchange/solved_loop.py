"""An algebraic loop within the exchange at a communication point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from m4e_fmi.cosim.connections.structure import AlgebraicLoop
from m4e_fmi.cosim.exchange.newton import LoopEquations

if TYPE_CHECKING:
    from m4e_fmi.cosim.exchange.network import Network


class SolvedLoop:
    """A loop whose solution goes into the values and inputs of a network."""

    def __init__(self, network: Network, loop: AlgebraicLoop) -> None:
        sources = {link.target: link.source for link in network.links}
        self._network = network
        self.equations = LoopEquations(network.instances, loop, sources)
        outputs = [network.index(port) for port in self.equations.outputs]
        inputs = [network.place(port) for port in self.equations.inputs]
        self._outputs = np.array(outputs, dtype=np.intp)
        self._inputs = np.array(inputs, dtype=np.intp)

    def run(self, _time: float) -> None:
        """Solve the loop at the present point; RunError if it fails, or is singular at first."""
        is_first = not self.equations.is_started
        self.equations.solve()
        if is_first:
            self.equations.check_regular()
        self._network.roughness = max(self._network.roughness, self.equations.roughness)
        self._network.values[self._outputs] = self.equations.output_values
        self._network.inputs[self._inputs] = self.equations.input_values
