"""Values carried over in initialization mode, along declared dependencies."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from m4e_fmi.cosim.connections.links import Port, Wiring
from m4e_fmi.cosim.connections.structure import AlgebraicLoop, Structure, Transfer, transfers_of
from m4e_fmi.cosim.exchange.discrete import Discrete
from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.newton import LoopEquations
from m4e_fmi.cosim.exchange.operations import Get, setting
from m4e_fmi.cosim.exchange.step_loop import Schedule
from m4e_fmi.fmu.importer.calls import Texts


class Initialisation:
    """The transfers of initialization mode.

    After `run`, `found` has the Real outputs in their own units, `discrete` the others; `given` are
    the values of Real inputs, in the units of their sources. FMUs of FMI 1.0 are initialised by
    their first transfer that reads outputs: `arrive` is called with the component's name and what
    is `given` straight after that, and these components are in `arrived`.
    """

    def __init__(
        self,
        instances: Mapping[str, Instance],
        wiring: Wiring,
        structure: Structure,
        texts: Texts,
        arrive: Callable[[str, Mapping[Port, float]], None],
    ) -> None:
        links = wiring.all_links
        self._instances, self._arrive, self._transfers = instances, arrive, structure.initial
        self._sources = {link.target: link.source for link in links if not link.delayed}
        by_target = {link.target: link for link in links}
        self.discrete = Discrete(instances, structure.initial, by_target, texts)
        self.found: dict[Port, float] = {}
        self.given: dict[Port, float] = {}
        self.arrived: set[str] = set()

    def run(self) -> None:
        """Perform all transfers; RunError where an FMU fails or a loop is not solved."""
        for part in self._transfers:
            reading = (t.component for t in transfers_of((part,)) if t.action == "get")
            for instance in (self._instances[component] for component in reading):
                if instance.description.version == "1.0":
                    instance.exit_initialization()  # before that, it gives no values
            if isinstance(part, AlgebraicLoop):
                loop = LoopEquations(self._instances, part, self._sources)
                loop.solve()
                self.found.update(zip(loop.outputs, loop.output_values.tolist(), strict=True))
                self.given.update(zip(loop.inputs, loop.input_values.tolist(), strict=True))
            elif part.discrete:
                self.discrete.perform(part)
            else:
                self._perform(part)
            if not isinstance(part, AlgebraicLoop) and part.action == "get":
                self._note_arrival(part.component)

    def _perform(self, transfer: Transfer) -> None:
        """Read outputs, or set inputs and parameters to the values of their sources."""
        instance, names = self._instances[transfer.component], transfer.variables
        ports = [Port(instance.name, name) for name in names]
        if transfer.action == "get":
            values = np.zeros(len(names))
            Schedule([Get(instance, names, values)]).run(instance.time)
            self.found.update(zip(ports, values.tolist(), strict=True))
            return
        values = np.array([self.found[self._sources[port]] for port in ports])
        self.given.update(zip(ports, values.tolist(), strict=True))
        Schedule(setting(instance, names, values)).run(instance.time)

    def _note_arrival(self, component: str) -> None:
        """Let the outputs arrive of an FMU that was initialised by this transfer."""
        version = self._instances[component].description.version
        if version == "1.0" and component not in self.arrived:
            self._arrive(component, self.given)
            self.arrived.add(component)
