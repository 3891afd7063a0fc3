"""`Prepared`: a system that can run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from m4e_fmi.cosim.connections.links import Link, Wiring
from m4e_fmi.cosim.connections.overview import overview
from m4e_fmi.cosim.connections.recording import chosen
from m4e_fmi.cosim.connections.structure import Structure
from m4e_fmi.cosim.connections.timing import Timing, timings
from m4e_fmi.cosim.system.component_step import ComponentStep
from m4e_fmi.cosim.system.component_steps import ComponentSteps
from m4e_fmi.cosim.system.system import System
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.shown import listing


@dataclass(frozen=True)
class Prepared:
    """A system with its FMUs built, its connections resolved, its loops and component steps known.

    `system` has the step that meets the points of all components. `descriptions` are those of the
    FMUs by component, with probed dependencies; `rates` the steps of the components that have their
    own, `hosts` the conditions of those that run in processes of their own. `notes` say what
    preparation has changed or found, `warnings` what seems to be wrong: missing connections, FMUs
    whose saved states fail; one line each. `recorded` are the variables by component that results
    of a run have: none in a run without results.
    """

    system: System
    descriptions: dict[str, Description] = field(repr=False)
    wiring: Wiring = field(repr=False)
    structure: Structure = field(repr=False)
    rates: ComponentSteps = field(repr=False)
    hosts: Mapping[str, Host] = field(default_factory=dict, repr=False)
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    recorded: Mapping[str, Sequence[Variable]] = field(default_factory=dict, repr=False)

    def recording(self, patterns: Sequence[str] = ()) -> Prepared:
        """The same system, whose runs record what `patterns` choose: see `chosen`."""
        found = chosen(self.descriptions, patterns, self.wiring.sources)
        return replace(self, recorded=found)

    @property
    def columns(self) -> int:
        """The number of values in a row of the results, including the time."""
        return 1 + sum(map(len, self.recorded.values()))

    @property
    def longer(self) -> dict[str, ComponentStep]:
        """Steps that are longer than the system's, of components that are not sampled.

        A sampled component, as a digital controller, is known by its connected outputs (its
        outputs, if none is connected): all are discrete, so that its step is a part of what it is.
        All others are continuous systems, of which a longer step is an approximation.
        """
        return {
            name: rate
            for name, rate in self.rates.items()
            if rate.is_longer and "continuous" in self._variabilities(name)
        }

    @property
    def halved(self) -> dict[str, ComponentStep]:
        """Those `longer` steps at half their length, where the FMUs make such steps."""
        return {
            name: replace(rate, step=rate.step / 2)
            for name, rate in self.longer.items()
            if not rate.constant and self.descriptions[name].internal_step is None
        }

    def _variabilities(self, component: str) -> set[str]:
        """Those of the connected Real outputs of a component, or of all if none is connected."""
        outputs = self.descriptions[component].of_causality("output")
        connected = {p.variable for p in self.wiring.sources if p.component == component}
        given = [v for v in outputs if v.name in connected] or outputs
        return {v.variability for v in given if v.type == "Real"}

    @property
    def timings(self) -> dict[Link, Timing]:
        """The timing of every link, under the system's algorithm."""
        algorithm = self.system.simulation.algorithm
        return timings(self.descriptions, self.wiring, self.structure, algorithm, self.rates)

    def __str__(self) -> str:
        return overview(self)

    def __repr__(self) -> str:
        return listing(
            f"Prepared system {self.system.name!r}: {len(self.wiring.links)} connected variables",
            components=self.descriptions,
            connections=self.system.connections,
            notes=self.notes,
        )
