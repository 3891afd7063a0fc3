"""Values carried over in initialization mode, along declared dependencies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from m4e_fmi.cosim.connections.links import Port, Wiring
from m4e_fmi.cosim.connections.structure import AlgebraicLoop, Structure, Transfer
from m4e_fmi.cosim.exchange.discrete import Discrete
from m4e_fmi.cosim.exchange.instance import WARNING, Instance
from m4e_fmi.cosim.exchange.newton import LoopEquations
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
        for transfer in self._transfers:
            if isinstance(transfer, AlgebraicLoop):
                loop = LoopEquations(self._instances, transfer, self._sources)
                loop.solve()
                self.found.update(zip(loop.outputs, loop.output_values.tolist(), strict=True))
                self.given.update(zip(loop.inputs, loop.input_values.tolist(), strict=True))
            elif transfer.discrete:
                self.discrete.perform(transfer)
                self._note_arrival(transfer)
            elif transfer.action == "get":
                self._read(self._instances[transfer.component], transfer.variables)
                self._note_arrival(transfer)
            else:
                self._set(self._instances[transfer.component], transfer.variables)

    def _read(self, instance: Instance, names: Sequence[str]) -> None:
        """Read outputs; RunError if one is nan or infinite."""
        values = np.zeros(len(names))
        status = instance.getter(names, values)()
        if status > WARNING:
            instance.fail(status, "fmi2GetReal")
        if not np.isfinite(values).all():
            instance.not_finite(names, values)
        ports = (Port(instance.name, name) for name in names)
        self.found.update(zip(ports, values.tolist(), strict=True))

    def _set(self, instance: Instance, names: Sequence[str]) -> None:
        """Set inputs and parameters to the values of their sources."""
        ports = [Port(instance.name, name) for name in names]
        values = np.array([self.found[self._sources[port]] for port in ports])
        self.given.update(zip(ports, values.tolist(), strict=True))
        status = instance.setter(names, values)()
        if status > WARNING:
            instance.fail(status, "fmi2SetReal")

    def _note_arrival(self, transfer: Transfer) -> None:
        """Let the outputs arrive of an FMU that was initialised by this transfer."""
        component = transfer.component
        version = self._instances[component].description.version
        if version == "1.0" and transfer.action == "get" and component not in self.arrived:
            self._arrive(component, self.given)
            self.arrived.add(component)
