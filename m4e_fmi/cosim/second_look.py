"""Outputs that were found to follow no input at once, read again while the run goes on.

Probing tells of a few points only. At communication points, ever more rarely, such outputs are
read once more, when all inputs are set: one that has changed since it was exchanged follows an
input, and what was exchanged was late.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from m4e_fmi.cosim.connect import Port
from m4e_fmi.cosim.dependence import PROBED
from m4e_fmi.cosim.network import Action, Network

RARER = 8
"""After n steps, the next look is n over this many steps later."""


class SecondLook:
    """Looks at the probed outputs of a `network`; `notes` tell of those that have changed."""

    REMEMBERED = ("_next", "_seen")

    def __init__(self, network: Network) -> None:
        self._network = network
        self._next = 0
        self._parts: list[tuple[tuple[Port, ...], np.ndarray, Action]] = []
        for name, instance in network.instances.items():
            how = instance.description.resolved
            ports = network.outputs[network.output_slice(name)]
            own = tuple(port for port in ports if how.get(port.variable) == PROBED)
            if own:
                view = np.zeros(len(own))
                read = network.reader(name, [port.variable for port in own], view)
                self._parts.append((own, view, read))
        self._seen: Mapping[Port, str] = {}

    @property
    def notes(self) -> tuple[str, ...]:
        """One line for each output that does follow its inputs, after all."""
        return tuple(self._seen.values())

    @property
    def wanted(self) -> bool:
        """True if there are probed outputs."""
        return bool(self._parts)

    def look(self, steps: int, *, last: bool) -> None:
        """At the present point, after so many steps of the run, if it is time or the `last` one."""
        if steps < self._next and not last:
            return
        self._next = steps + 1 + steps // RARER
        network = self._network
        for ports, view, read in self._parts:
            read()
            for port, value in zip(ports, view.tolist(), strict=True):
                if value != network.values[network.index(port)] and port not in self._seen:
                    self._seen = {**self._seen, port: self._told(port)}

    def _told(self, port: Port) -> str:
        network = self._network
        needs = network.instances[port.component].description.dependencies[port.variable]
        connected = network.targets[network.input_slice(port.component)]
        names = [p.variable for p in connected if p.variable not in needs]
        return (
            f"{port} has changed at t = {network.time:.9g} s when "
            f"{' or '.join(names)} was set, though probing has found no dependence: its value was "
            f"late; write what it depends on under `dependencies` of {port.component}"
        )
