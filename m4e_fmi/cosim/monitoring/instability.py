"""Instability of a coupled run: when it is stopped, and the message.

Exchanged outputs are checked at intervals. When one has become `HUGE`, the run ends. When an FMU
fails, or returns no number, the error says which output has grown so much before
(`m4e_fmi.results.growth`). If the coupling error of the run is small, the steps are not the cause,
and the remedy does not concern them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.coupling_algorithms import algorithm_descriptor, algorithm_names, listed
from m4e_fmi.errors import RunError
from m4e_fmi.results.growth import FACTOR, Growth

HUGE = 1e20
"""Times its nominal value, or 1: no quantity of a working system is so large."""
SPARSE, FARTHEST = 64, 4096
"""Looks are a sixty-fourth of the steps so far apart, and at most so many steps."""
SMALL = 0.03
"""Coupling error over the range up to which the steps are not the cause."""
OWN = "look at the signs of its feedback, stiffness and damping, or give it damping"


class Instability:
    """Looks at the exchanged outputs of `network`, which runs by `simulation`.

    `stated` gives the largest coupling error up to the present point, over the range; None if it is
    not known.
    """

    def __init__(
        self, network: Network, simulation: Simulation, stated: Callable[[], float | None]
    ) -> None:
        self._network, self._simulation, self._stated = network, simulation, stated
        self._nominals = np.array([max(1.0, network.nominal(port)) for port in network.outputs])
        self.start_over(0)

    def start_over(self, steps: int) -> None:
        """Forget what was seen: the run is at a point after so many steps."""
        self._largest = self._present()
        # until half of the steps at the last two doublings of their number
        self._former = [(self._network.time, self._largest)] * 2
        self._doubled, self._next = max(1, steps), steps

    def look(self, steps: int) -> None:
        """Look at the present values after so many steps, at times; RunError if one is huge."""
        if steps < self._next or not len(self._nominals):
            return
        self._next = steps + min(FARTHEST, steps // SPARSE + 1)
        present = self._present()
        self._largest = np.maximum(self._largest, present)
        if (present > HUGE * self._nominals).any():
            worst = int(np.argmax(present / self._nominals))
            raise RunError(f"unstable: {self._text(worst, present)}", self._remedy())
        if steps >= 2 * self._doubled:
            self._former = [self._former[1], (self._network.time, self._largest)]
            self._doubled = steps

    def explained(self, error: RunError) -> RunError:
        """`error`, with the output that has grown most before it, if one has."""
        network, count = self._network, len(self._nominals)
        both = np.array([network.values[k : k + count] for k in (network.before, network.now)])
        present = np.where(np.isfinite(both), np.abs(both), 0.0).max(axis=0)
        least = np.maximum(FACTOR * self._former[0][1], self._nominals)
        if not (present > least).any():
            return error
        text = self._text(int(np.argmax(present / least)), present)
        remedy = "; ".join(filter(None, (error.remedy, f"if it is unstable: {self._remedy()}")))
        return RunError(f"{error.message}; before that {text}", remedy)

    def _present(self) -> np.ndarray:
        first = self._network.now
        return np.abs(self._network.values[first : first + len(self._nominals)])

    def _text(self, place: int, present: np.ndarray) -> str:
        port = self._network.outputs[place]
        variable = self._network.instances[port.component].description.variables[port.variable]
        since, low = self._former[0]
        sizes = since, float(low[place]), self._network.time, float(present[place])
        return Growth(str(port), *sizes).text(variable.description, variable.unit)

    def _remedy(self) -> str:
        """Remedies, the likeliest first."""
        error, settings = self._stated(), self._simulation
        if error is not None and error <= SMALL:
            return (
                f"the steps are not the cause, as the coupling error is {error:.1e} of range: the "
                f"model itself grows: {OWN}"
            )
        rank = algorithm_descriptor(settings.algorithm).stability
        others = [n for n in algorithm_names() if algorithm_descriptor(n).stability > rank]
        advice = [f"try step_size: {settings.step_size / 4:g}"]
        advice += [f"take algorithm: {listed(others)}"] if others else []
        own = f"if neither helps, the system itself is unstable: {OWN}"
        return "; ".join([*advice, own])
