"""Instability of a coupled run: when it is stopped, and the message (criterion: results/growth).

Exchanged outputs are checked at intervals. When one has become `HUGE` by growth without bound
(`m4e_fmi.results.growth`), the run ends. When an FMU fails, or returns no number, these checks
and the rows of the results show if an output had grown so before. A run that reaches its stop
time while an output grows gives a warning. If the coupling error of the run is small, the
steps are not the cause, and the remedy does not concern them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.restorable import Restorable
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.cosim.wiring.links import Link, Port
from m4e_fmi.coupling_algorithms import algorithm_descriptor, algorithm_names, listed
from m4e_fmi.errors import RunError
from m4e_fmi.results.growth import Growth, largest_growth
from m4e_fmi.units import BASE_UNITS

HUGE = 1e20
"""Times its nominal value, or 1: no quantity of a working system is so large."""
LARGE = 1e6
"""Likewise: growth to less is not worth a word at the end of a run."""
STOPS, FAILED = 6.0, 4.0
"""Decades of growth that tell an unstable system: while it runs, and where something has failed."""
LOOKS = 512
"""Looks that are kept; the older ones are thinned out."""
SPARSE, FARTHEST = 64, 4096
"""Looks are a sixty-fourth of the steps so far apart, and at most so many steps."""
ROWS = 4096
"""Rows of the results that are examined where something has failed."""
ACCELERATION = {"m": 1, "s": -2}, {"rad": 1, "s": -2}, {"s": -2}
FAST = 30.0
"""Steps for a factor of ten; what grows in fewer does so because of the steps."""
SMALL = 0.03
"""Coupling error over the range up to which the steps are not the cause."""
OWN = "look at the signs of its feedback, stiffness and damping, or give it damping"


class Instability(Restorable):
    """Looks at the exchanged outputs of `network`, which runs by `simulation`.

    `stated` gives the largest coupling error up to the present point, over the range; None if it is
    not known.
    """

    restored = ("_times", "_looks", "_next")

    def __init__(
        self, network: Network, simulation: Simulation, stated: Callable[[], float | None]
    ) -> None:
        self._network, self._simulation, self._stated = network, simulation, stated
        count = len(network.outputs)
        self._outputs = slice(network.now, network.now + count)
        self._before = slice(network.before, network.before + count)
        nominals = [max(1.0, network.nominal(port)) for port in network.outputs]
        self._nominals = np.array(nominals)
        self._times: list[float] = []
        self._looks: list[np.ndarray] = []
        self._next = 0
        self.look(0)

    def look(self, steps: int) -> None:
        """Look at the present values after so many steps, at times; RunError if one is huge."""
        if steps < self._next or not len(self._nominals):
            return
        self._next = steps + min(FARTHEST, steps // SPARSE + 1)
        self._keep(self._network.time, self._outputs)
        last = self._looks[-1]
        grown = self._grown(STOPS, HUGE) if last.dot(last) > HUGE**2 else None
        if grown:
            raise RunError(f"unstable: {self._text(grown)}", self._remedy(grown))

    def is_lost(self) -> bool:
        """True if something has grown without bound that is LARGE already, looked at just now."""
        if not len(self._nominals):
            return False
        self._keep(self._network.time, self._outputs)
        return self._grown(STOPS, LARGE) is not None

    def back(self, time: float, steps: int) -> None:
        """The run has gone back to a time [s], after so many steps."""
        count = int(np.searchsorted(self._times, time))
        del self._times[count:], self._looks[count:]
        self._next = steps

    def warning(self) -> str:
        """The warning of growth without bound at the end of the run; empty if nothing grows so."""
        if (
            not len(self._nominals)
            or not (np.abs(self._network.values[self._outputs]) > LARGE * self._nominals).any()
        ):
            return ""
        self._keep(self._network.time, self._outputs)
        grown = self._grown(STOPS, LARGE)
        if not grown:
            return ""
        return f"{self._text(grown)}: this seems to be unstable; {self._remedy(grown)}"

    def explained(self, error: RunError, results: ResultsWriter | None) -> RunError:
        """`error`, or if something had grown without bound before it, what says so."""
        known = {str(port) for port in self._network.outputs}
        network = self._network
        self._keep(network.time - network.last, self._before)
        self._keep(network.time, self._outputs)
        found = [self._grown(FAILED, 1.0)]
        if results is not None:
            times, rows = results.recent(ROWS)
            exchanged = {name: values for name, values in rows.items() if name in known}
            found.append(largest_growth(times, exchanged or rows, decades=FAILED))
        grown = max((one for one in found if one), key=lambda one: one.decades, default=None)
        if grown is None or grown.high < self._nominal(grown.name):
            return error
        message = f"unstable: {self._text(grown)}; then {error.message}"
        return RunError(message, self._remedy(grown))

    def _keep(self, time: float, values: slice) -> None:
        """Keep the values at a time [s], if it is later than all that are kept."""
        if self._times and time <= self._times[-1]:
            return
        self._times.append(time)
        self._looks.append(self._network.values[values].copy())
        if len(self._times) == LOOKS:
            half = LOOKS // 2
            self._times[:half] = self._times[:half:2]
            self._looks[:half] = self._looks[:half:2]

    def _grown(self, decades: float, least: float) -> Growth | None:
        """The largest growth of an exchanged output that has become so many times its nominal."""
        if not self._looks:
            return None
        looks = np.abs(self._looks)
        large = np.flatnonzero(looks[-1] > least * self._nominals)
        columns = {str(self._network.outputs[k]): looks[:, k] for k in large}
        return largest_growth(np.array(self._times), columns, decades=decades)

    def _nominal(self, name: str) -> float:
        return max(1.0, self._network.nominal(Port.named(name)))

    def _text(self, grown: Growth) -> str:
        port = Port.named(grown.name)
        instance = self._network.instances[port.component]
        variable = instance.description.variables[port.variable]
        return grown.text(variable.description, variable.unit)

    def _remedy(self, grown: Growth) -> str:
        """Remedies, the likeliest first."""
        error = self._stated()
        if error is not None and error <= SMALL:
            return (
                f"the steps are not the cause, as the coupling error is {error:.1e} of range: the "
                f"model itself grows: {OWN}"
            )
        settings = self._simulation
        steps = grown.tenfold / settings.step_size
        rank = algorithm_descriptor(settings.algorithm).stability
        others = [n for n in algorithm_names() if algorithm_descriptor(n).stability > rank]
        advice: list[str] = []
        carried = _acceleration(self._network.links, self._network)
        if carried is not None:
            advice.append(
                f"{carried} carries an acceleration: if its force is an added mass, let it be part "
                "of the mass matrix instead (added_mass: true of the body, and a connection "
                "'SOURCE.added_mass -> MODEL.added_mass')"
            )
        if others:
            advice.append(f"take algorithm: {listed(others)}")
        if steps < FAST:
            advice.insert(0 if carried is None else 1, f"try step_size: {settings.step_size / 4:g}")
        else:
            advice.insert(
                0,
                f"the growth takes {steps:.2g} steps for a factor of ten: if half the step_size "
                f"leaves it as it is, the system itself is unstable: {OWN}",
            )
        return "; ".join(advice)


def _acceleration(links: Sequence[Link], network: Network) -> Link | None:
    """A connection that carries an acceleration to a component that gives something back."""
    back = {(link.source.component, link.target.component) for link in links}
    for link in links:
        source = link.source
        variable = network.instances[source.component].description.variables[source.variable]
        if variable.dimension is None or (link.target.component, source.component) not in back:
            continue
        powers = zip(BASE_UNITS, variable.dimension.exponents, strict=True)
        if {name: power for name, power in powers if power} in ACCELERATION:
            return link
    return None
