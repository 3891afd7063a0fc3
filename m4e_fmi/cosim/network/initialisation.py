"""Values carried over in initialization mode, along declared dependencies."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from m4e_fmi.cosim.network.discrete import Discrete
from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.newton import LoopEquations
from m4e_fmi.cosim.network.operations import Get, setting
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmi.cosim.wiring.structure import AlgebraicLoop, Structure, Transfer, transfers_of
from m4e_fmi.fmu.importer.calls import Texts


class Initialisation:
    """The transfers of initialization mode.

    After `run`, `found` has the Real outputs in their own units, `discrete` the others; `given` are
    the values that links to Real inputs have carried, in the units of their sources. FMUs of FMI
    1.0 are initialised by their first transfer that reads outputs: right after that, `arrive` is
    called with the component's name and `given`, and these components are in `arrived`.
    """

    def __init__(
        self,
        instances: Mapping[str, Instance],
        wiring: Wiring,
        structure: Structure,
        texts: Texts,
        arrive: Callable[[str, Mapping[Link, float]], None],
    ) -> None:
        self._instances, self._arrive, self._wiring = instances, arrive, wiring
        self._transfers = structure.initial
        by_target = {link.target: link for link in wiring.all_links}
        self.discrete = Discrete(instances, structure.initial, by_target, texts)
        self.found: dict[Port, float] = {}
        self.given: dict[Link, float] = {}
        self.arrived: set[str] = set()

    def run(self) -> None:
        """Perform all transfers; RunError where an FMU fails or a loop is not solved."""
        for part in self._transfers:
            reading = (t.component for t in transfers_of((part,)) if t.action == "get")
            for instance in (self._instances[component] for component in reading):
                if instance.description.version == "1.0":
                    instance.exit_initialization()  # before that, it gives no values
            if isinstance(part, AlgebraicLoop):
                self._solve(part)
                continue
            if part.discrete:
                self.discrete.perform(part)
            elif part.action == "get":
                self._read(part)
            else:
                self._set(part)
            if part.action == "get":
                self._note_arrival(part.component)

    def _solve(self, part: AlgebraicLoop) -> None:
        prompt = [link for link in self._wiring.all_links if not link.delayed]
        loop = LoopEquations(self._instances, part, prompt)
        loop.solve({link: self.found[link.source] for link in loop.known})
        self.found.update(zip(loop.outputs, loop.output_values.tolist(), strict=True))
        self.given.update(zip(loop.links, loop.input_values.tolist(), strict=True))

    def _read(self, transfer: Transfer) -> None:
        """Read outputs; RunError if one is nan or infinite."""
        instance, values = self._instances[transfer.component], np.zeros(len(transfer.variables))
        Schedule([Get(instance, transfer.variables, values)]).run(instance.time)
        ports = (Port(instance.name, name) for name in transfer.variables)
        self.found.update(zip(ports, values.tolist(), strict=True))

    def _set(self, transfer: Transfer) -> None:
        """Set inputs and parameters to the values of their sources."""
        instance, into = self._instances[transfer.component], self._wiring.into
        targets = [Port(instance.name, name) for name in transfer.variables]
        links = [link for port in targets for link in into[port] if not link.delayed]
        values = np.array([self.found[link.source] for link in links])
        self.given.update(zip(links, values.tolist(), strict=True))
        Schedule(setting(instance, links, values)).run(instance.time)

    def keep_constants(self) -> None:
        """Have links add what others beside them have carried once into the same variables."""
        once = set(self._wiring.initial_links)
        for port, links in self._wiring.into.items():
            constant = [link for link in links if link in once]
            carried = [link for link in links if link not in once]
            if constant and carried:
                added = sum(k.factor * self.found[k.source] + k.offset for k in constant)
                self._instances[port.component].scales.add(carried[0].ends, added)

    def _note_arrival(self, component: str) -> None:
        """Let the outputs arrive of an FMU that was initialised by this transfer."""
        version = self._instances[component].description.version
        if version == "1.0" and component not in self.arrived:
            self._arrive(component, self.given)
            self.arrived.add(component)
