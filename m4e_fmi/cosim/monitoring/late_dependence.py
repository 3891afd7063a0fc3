"""A second look at outputs that were exchanged before all inputs of their FMU were set.

They are said not to follow the inputs that are set later: by their FMU or the system file, which
may be wrong, or by probing at a few points. At communication points, ever more rarely, they are
read once more, when all inputs are set: one that has changed since it was exchanged follows an
input, and the exchanged value was late.

Some FMUs lose outputs when inputs are set. So an output follows inputs only if it differs between
their values at the point before and the present ones, set one after the other. Inputs that are
discrete are not set for that, and nothing in an FMU with event mode: that may be an event, which
outputs may follow whatever they depend on.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Get, setting
from m4e_fmi.cosim.network.restorable import Restorable
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.cosim.wiring.structure import DECLARED, PROBED, STATED, how_known

RARER = 2
"""After n steps, the next look is n over this many steps later."""
NOISE = 1e-9
"""Share of an output by which rounding and iterations may change one that follows no input."""
ROUNDING = 1e-12
"""Likewise, share of the largest output in the same unit: of those that are 0 but for rounding."""


@dataclass(frozen=True)
class _Part:
    """Outputs of a component, which `reading` brings into `view`; `places` of those in `values`.

    `units` (n_outputs,) [1] are equal where units are.
    """

    instance: Instance
    outputs: tuple[str, ...]
    places: np.ndarray
    view: np.ndarray
    reading: Schedule
    units: np.ndarray

    def read(self) -> np.ndarray:
        """The outputs, as they are now."""
        self.reading.run(self.instance.time)
        return self.view.copy()

    def changed(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """True where outputs differ by more than rounding, (n_outputs,) booleans.

        `one` and `other` (n_outputs,) are in the outputs' units.
        """
        sizes = np.maximum(np.abs(one), np.abs(other))
        largest = np.zeros(self.units.max(initial=0) + 1)
        np.maximum.at(largest, self.units, sizes)
        rough = np.maximum(NOISE * sizes, ROUNDING * largest[self.units])
        return np.abs(one - other) > rough


class SecondLook(Restorable):
    """Looks at such outputs of a `network`; `notes` tell of those that have changed."""

    restored = ("_next", "_seen", "_spoilt")

    def __init__(self, network: Network) -> None:
        self._network = network
        self._next = 0
        self._parts = [
            _part(network, instance, outputs)
            for name, instance in network.instances.items()
            if (outputs := tuple(_early(network, name)))
        ]
        self._seen: Mapping[Port, str] = {}
        self._spoilt: set[Port] = set()

    @property
    def notes(self) -> tuple[str, ...]:
        """One line for outputs that do follow their inputs, after all."""
        return tuple(dict.fromkeys(self._seen.values()))

    @property
    def wanted(self) -> bool:
        """True if there are outputs to check."""
        return bool(self._parts)

    def room(self, steps: int) -> int | None:
        """Steps up to the next check, after `steps` steps of the run; None without checks."""
        return max(1, self._next - steps) if self._parts else None

    def look(self, steps: int, *, last: bool) -> None:
        """At the present point, after so many steps of the run, if it is time or the `last` one."""
        if steps < self._next and not last:
            return
        self._next = steps + 1 + steps // RARER
        known = self._seen.keys() | self._spoilt
        for part in self._parts:
            exchanged = self._network.values[part.places]
            values = part.read()
            changed = [
                name
                for name, one, other in zip(part.outputs, exchanged, values, strict=True)
                if one != other and Port(part.instance.name, name) not in known
            ]
            if changed:
                self._note(part, changed, exchanged, values)

    def _note(
        self, part: _Part, changed: Sequence[str], exchanged: np.ndarray, values: np.ndarray
    ) -> None:
        """Report outputs of a component that have changed and follow inputs."""
        component, description = part.instance.name, part.instance.description
        moved = dict(zip(part.outputs, part.changed(exchanged, values), strict=True))
        suspects = [name for name in changed if moved[name]]
        if not suspects or part.instance.has_ended:
            return
        follows = self._following(part, suspects)
        if follows is None:
            return
        exchanged_ports = self._network.outputs
        spoilt = (Port(component, name) for name in suspects if name not in follows)
        self._spoilt |= {port for port in spoilt if port in exchanged_ports}  # others may be old
        for how in (DECLARED, STATED, PROBED):
            own = [name for name in follows if how_known(description, name) == how]
            if own:
                note = self._text(component, own, how)
                self._seen = {**self._seen, **{Port(component, name): note for name in own}}

    def _following(self, part: _Part, outputs: Sequence[str]) -> list[str] | None:
        """Those outputs that follow inputs; None if these are as at the point before."""
        network, instance, known = self._network, part.instance, part.instance.description
        links = [
            link
            for link in network.links_to(instance.name)
            if known.variables[link.target.variable].variability == "continuous"
        ]
        present = network.inputs[[network.place(link) for link in links]]
        former = network.values[[network.before + network.index(link.source) for link in links]]
        if np.array_equal(former, present):
            return None
        if known.saves_state:
            instance.save_state()
        found: list[str] = []
        for name in outputs:  # each by those inputs on which it is not known to depend
            other = [link.target.variable not in known.dependencies[name] for link in links]
            own = [link for link, is_other in zip(links, other, strict=True) if is_other]
            seen: list[np.ndarray] = []
            for values in (former[other], present[other]):
                Schedule(setting(instance, own, values)).run(instance.time)
                seen.append(part.read())
            if part.changed(*seen)[part.outputs.index(name)]:
                found.append(name)
        if known.saves_state:
            instance.restore_state(network.time)
        return found

    def _text(self, component: str, names: Sequence[str], how: str) -> str:
        fmu = self._network.instances[component].description.path.name
        who = {DECLARED: f"its FMU, {fmu}, declares", STATED: "the system file declares"}
        outputs = " and ".join(f"{component}.{name}" for name in names)
        return (
            f"{outputs} changed at t = {self._network.time:.9g} s when inputs were set, though "
            f"{who.get(how, 'probing has found')} no such dependence: the value exchanged was a "
            "step late, which the coupling error told does not contain; write the inputs under "
            f"`dependencies` of {component} in the system file (`m4e-fmi validate {fmu}` lists "
            "them)"
        )


def _early(network: Network, component: str) -> Iterator[str]:
    """Outputs that are exchanged, or recorded, before all connected inputs are set."""
    instance = network.instances[component]
    description = instance.description
    connected = {port.variable for port in network.targets[network.input_slice(component)]}
    exchanged = [port.variable for port in network.outputs[network.output_slice(component)]]
    recorded = network.recorded(component)
    for name in (*exchanged, *recorded):
        declared = how_known(description, name) in (DECLARED, STATED) and not description.has_events
        incomplete = declared and connected - description.dependencies[name]
        if incomplete or (name in exchanged and how_known(description, name) == PROBED):
            yield name


def _part(network: Network, instance: Instance, outputs: tuple[str, ...]) -> _Part:
    ports = [Port(instance.name, name) for name in outputs]
    known = [network.known(port) for port in ports]
    places = [
        network.index(port) if place is None else place
        for port, place in zip(ports, known, strict=True)
    ]
    view = np.zeros(len(outputs))
    names = [instance.description.variables[name].unit for name in outputs]
    units = np.unique(names, return_inverse=True)[1]
    reading = Schedule([Get(instance, outputs, view, checked=False)])
    return _Part(instance, outputs, np.array(places), view, reading, units)
