"""Instability of a coupled run: when it is stopped, and the message.

Exchanged outputs are checked at intervals. When one has become `HUGE`, the run ends.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.coupling_algorithms import algorithm_descriptor, algorithm_names, listed
from m4e_fmi.errors import RunError

HUGE = 1e20
"""Times its nominal value, or 1: no quantity of a working system is so large."""
SPARSE, FARTHEST = 64, 4096
"""Looks are a sixty-fourth of the steps so far apart, and at most so many steps."""


class Instability:
    """Looks at the exchanged outputs of `network`, which runs by `simulation`.

    The `next` look is after so many steps of the run.
    """

    def __init__(self, network: Network, simulation: Simulation) -> None:
        self._network, self._simulation = network, simulation
        self._nominals = np.array([max(1.0, network.nominal(port)) for port in network.outputs])
        self.next = 0

    def look(self, steps: int) -> None:
        """Look at the present values after so many steps, at times; RunError if one is huge."""
        network, count = self._network, len(self._nominals)
        if steps < self.next or not count:
            return
        self.next = steps + min(FARTHEST, steps // SPARSE + 1)
        sizes = np.abs(network.values[network.now : network.now + count]) / self._nominals
        worst = int(np.argmax(sizes))
        if sizes[worst] > HUGE:
            port = network.outputs[worst]
            variable = network.instances[port.component].description.variables[port.variable]
            about = f" ({variable.description})" if variable.description else ""
            value = f"{network.values[network.now + worst]:.3g} {variable.unit}".rstrip()
            when = f"at t = {network.time:.9g} s"
            raise RunError(f"unstable: {port}{about} is {value} {when}", self._remedy())

    def _remedy(self) -> str:
        """Remedies, the likeliest first."""
        settings = self._simulation
        rank = algorithm_descriptor(settings.algorithm).stability
        others = [n for n in algorithm_names() if algorithm_descriptor(n).stability > rank]
        advice = [f"try step_size: {settings.step_size / 4:g}"]
        advice += [f"take algorithm: {listed(others)}"] if others else []
        own = "look at the signs of its feedback, stiffness and damping, or give it damping"
        return "; ".join([*advice, f"if neither helps, the system itself is unstable: {own}"])
