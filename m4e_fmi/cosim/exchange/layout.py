"""Layout of the values that are exchanged: their places in the blocks of one array; snapshots.

`Network.values` has blocks of the same layout, all Real outputs that are exchanged, component by
component:

====================  ==========================================================================
``values[now:]``      at the present communication point, consistent with one another
``values[before:]``   at the communication point before (equal to `now` at the start)
``values[stepped:]``  at the end of the step being made, of the components that have made it
``values[middle:]``   in the middle of the step being made, where an algorithm evaluates that
``values[earlier:]``  in the middle of the step before, likewise
====================  ==========================================================================
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.connections.links import Link, Port
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.connections.structure import Exchange, derivative_chain, transfers_of
from m4e_fmi.cosim.exchange.discrete import Kept
from m4e_fmi.cosim.exchange.newton import LoopSnapshot
from m4e_fmi.cosim.exchange.operations import Due
from m4e_fmi.cosim.scenario.scenario import ScenarioSnapshot
from m4e_fmi.errors import UnknownNameError
from m4e_fmi.fmu.importer.reading import Description

BLOCKS = 5
OWN_PLACES = 2
"""Places of FMU states that are reserved: for algorithms (0) and `doubling` (1)."""


@dataclass(frozen=True, eq=False)
class NetworkSnapshot:
    """A communication point to which a network can return; the FMUs keep their states in `place`.

    `values`, `inputs` and those that are not Real (`discrete`) are copies of the network's, `loops`
    the starting points of its algebraic loops, `roughness` how well they were solved; `scenario` is
    what its actions know.
    """

    place: int
    time: float
    last: float
    values: np.ndarray
    inputs: np.ndarray
    discrete: Kept
    loops: tuple[LoopSnapshot, ...]
    roughness: float
    scenario: ScenarioSnapshot


class ExchangedVariables:
    """The Real outputs and inputs that are exchanged, with their places.

    `outputs` and `targets` (connected inputs) are ordered by component, so that those of one are
    consecutive (`output_slice`, `input_slice`); `links[k]` leads to `targets[k]`, which is there
    once for each of its links: they add up. `now`, `before`, `stepped`, `middle` and `earlier` are
    the starts of the blocks.
    `execution_order` is the order in which a Gauss–Seidel algorithm steps the components;
    `has_loops` is True if algebraic loops are solved at each communication point. `rates` are the
    steps of the components that have their own, `sampled` those that are controllers by nature:
    their outputs are discrete.
    `monitored_outputs` are those by which the coupling error is measured, each with the index of a
    connection: the sources of all links, and the outputs of components without connected outputs.
    """

    def __init__(self, prepared: Prepared) -> None:
        self._descriptions = descriptions = prepared.descriptions
        self._wiring, self._structure = wiring, structure = prepared.wiring, prepared.structure
        self.execution_order = structure.execution_order
        self.outputs = _grouped(structure.exchange, "get", descriptions)
        carried = set(wiring.links)
        inputs = _grouped(structure.exchange, "set", descriptions)
        self.links = [k for port in inputs for k in wiring.into[port] if k in carried]
        self.targets = [link.target for link in self.links]
        self.has_loops = bool(structure.loops)
        into = {link.target.component: link.connection for link in reversed(wiring.links)}
        self.monitored_outputs = (
            *((link.connection, link.source) for link in self.links),
            *((into[port.component], port) for port in structure.ends),
        )
        self.now, self.before, self.stepped, self.middle, self.earlier = (
            k * len(self.outputs) for k in range(BLOCKS)
        )
        self.rates = prepared.rates
        self.sampled = frozenset(n for n, rate in self.rates.items() if rate.is_longer) - {
            *prepared.longer
        }
        self._origin = prepared.system.simulation.start_ns
        self._index = {port: k for k, port in enumerate(self.outputs)}
        self._place = {link.ends: k for k, link in enumerate(self.links)}
        self._output_ranges, self._input_ranges = _ranges(self.outputs), _ranges(self.targets)

    def port(self, name: str) -> Port:
        """The port ``component.variable``; UnknownNameError if there is none of this name."""
        port = Port.named(name)
        description = self._descriptions.get(port.component)
        if description is None or port.variable not in description.variables:
            known = [f"{c}.{v}" for c, d in self._descriptions.items() for v in d.variables]
            raise UnknownNameError.of("no variable is called", [name], known)
        return port

    def due(self, component: str) -> Due | None:
        """The times of the component's points; None if it has one at every communication point."""
        rate = self.rates.get(component)
        if rate is None or not rate.is_longer:
            return None
        return Due(self._origin, rate.step_ns)

    @property
    def sources(self) -> tuple[Port, ...]:
        """The outputs that connections carry, of all types."""
        return self._wiring.sources

    def index(self, output: Port) -> int:
        """Place of an output in a block of `values`."""
        return self._index[output]

    def place(self, link: Link) -> int:
        """Place in `inputs` of the value that a link carries."""
        return self._place[link.ends]

    def links_to(self, component: str) -> list[Link]:
        """The links to a component's Real inputs, in the order of their places."""
        return self.links[self.input_slice(component)]

    def held_place(self, link: Link) -> int | None:
        """Place in `values` of the value that a delayed link carries all through a step."""
        return self.before + self.index(link.source) if link.delayed else None

    def present(self, link: Link) -> int:
        """Place in `values` of the value that a link carries to the present point."""
        held = self.held_place(link)
        return self.index(link.source) if held is None else held

    def derivatives(self, output: Port) -> list[Port]:
        """The output itself and its declared first and second time derivative, if there are."""
        return derivative_chain(self._descriptions, output)

    def unit(self, port: Port) -> str:
        """The unit of a variable, as its FMU names it."""
        return self._descriptions[port.component].variables[port.variable].unit

    def nominal(self, port: Port) -> float:
        """The order of magnitude of a variable, in its unit."""
        return self._descriptions[port.component].variables[port.variable].nominal

    def to_si(self, port: Port) -> float:
        """SI value over value of a variable, 1 if its FMU gives no unit."""
        dimension = self._descriptions[port.component].variables[port.variable].dimension
        return dimension.factor if dimension else 1.0

    def output_slice(self, component: str) -> slice:
        """Places of a component's outputs in a block of `values`."""
        return self._output_ranges.get(component, slice(0, 0))

    def input_slice(self, component: str) -> slice:
        """Places in `inputs` of the values of the links to a component."""
        return self._input_ranges.get(component, slice(0, 0))


def _grouped(exchange: Exchange, action: str, components: Mapping[str, Description]) -> list[Port]:
    """All Real variables of the transfers of one kind, by component and within it by call."""
    found: dict[str, list[Port]] = {component: [] for component in components}
    for transfer in transfers_of(exchange):
        if transfer.action == action and not transfer.discrete:
            ports = (Port(transfer.component, name) for name in transfer.variables)
            found[transfer.component] += ports
    return [port for ports in found.values() for port in ports]


def _ranges(ports: Sequence[Port]) -> dict[str, slice]:
    """Component → its places among `ports`, which are consecutive."""
    found: dict[str, slice] = {}
    for k, port in enumerate(ports):
        first = found[port.component].start if port.component in found else k
        found[port.component] = slice(first, k + 1)
    return found
