"""Instances of FMUs that are tried before the run, and thrown away."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.loading import Files, opened_binary
from m4e_fmi.cosim.network.operations import DoStep
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.cosim.system.start_values import Value, start_values
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Wiring
from m4e_fmi.fmu.importer.messages import Listener
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.signals import not_lost

TOGETHER = 1e-2
"""By how much inputs are moved all at once, over their sizes."""
SHORTER = 8
"""How much shorter than the component's the steps are that show what is integrated."""
PROBE = "_probe"
"""Suffix of the names that FMUs hear of such instances."""


def driven_inputs(wiring: Wiring) -> dict[str, tuple[str, ...]]:
    """The connected inputs of each component that has any."""
    found: dict[str, set[str]] = {}
    for link in wiring.links:
        found.setdefault(link.target.component, set()).add(link.target.variable)
    return {name: tuple(sorted(inputs)) for name, inputs in found.items()}


Answer = TypeVar("Answer")


class Instances:
    """New instances of a component, initialised with its start values."""

    def __init__(
        self,
        component: Component,
        description: Description,
        simulation: Simulation,
        host: Host | None,
    ) -> None:
        self._component, self._simulation, self._host = component, simulation, host
        self._description = replace(description, path=description.path.absolute())
        own = description.internal_step or simulation.step_size
        self.step = float(component.own_step or own)
        only = description.constant_step or description.internal_step is not None
        self.short_step = self.step if only else self.step / SHORTER

    @contextmanager
    def instance(
        self,
        inputs: Mapping[str, Value] | None = None,
        *,
        suffix: str = PROBE,
        listener: Listener | None = None,
    ) -> Generator[Instance]:
        """One after its initialisation; closed, with its library, at the end of the block.

        `inputs` are set while it is initialised, as connections do; the `suffix` ends the name that
        the FMU hears, a `listener` hears what it logs.
        """
        name, times = self._component.name, self._simulation
        origin = f"{name} ({self._description.path.name})"
        with (
            closing(Files(self._description)) as files,
            opened_binary(self._description, files, origin=origin, host=self._host) as binary,
            Instance(name, self._description, binary, listener, suffix=suffix) as instance,
        ):
            instance.setup(start=times.start_time, stop=times.last_time, tolerance=times.tolerance)
            instance.set_values(start_values(self._component, self._description))
            instance.enter_initialization()
            instance.set_values(inputs or {})
            instance.exit_initialization()
            yield instance


class Trials:
    """Questions to the FMUs of a system, each asked once of a file with the same start values."""

    def __init__(
        self, system: System, descriptions: Mapping[str, Description], hosts: Mapping[str, Host]
    ) -> None:
        self._system, self._descriptions, self._hosts = system, descriptions, hosts
        self._known: dict[object, Any] = {}
        self._notes: dict[str, list[str]] = {}

    def ask(
        self, component: Component, question: Callable[..., Answer], *asked: Hashable
    ) -> Answer:
        """The answer of ``question(new, description, *asked)``, where `new` makes instances."""
        description, host = self._descriptions[component.name], self._hosts.get(component.name)
        start = tuple(sorted((name, str(value)) for name, value in component.start.items()))
        key = question, description.path, start, component.step_size, asked
        if key not in self._known:
            new = Instances(component, description, self._system.simulation, host)
            self._known[key] = question(new, description, *asked)
        return self._known[key]

    def note(self, text: str, component: Component) -> None:
        """Note a text about a component."""
        self._notes.setdefault(text, []).append(component.name)

    def lines(self) -> list[str]:
        """One line for each text, with all components that it is about."""
        return [f"{', '.join(names)}: {text}" for text, names in self._notes.items()]


class Subject:
    """An instance under probe: its outputs, and its inputs with the sizes they are moved by."""

    def __init__(self, instance: Instance, outputs: Sequence[str], inputs: Sequence[str]) -> None:
        self._instance, self._step = instance, Schedule([DoStep(instance)]).executor
        self.outputs, self.inputs = outputs, inputs
        self.start = instance.values(inputs)
        self._known = [instance.description.variables[name] for name in inputs]

    def read(self) -> list[Value]:
        """The outputs."""
        return self._instance.values(self.outputs)

    def set(self, values: Sequence[Value]) -> None:
        """All inputs."""
        self._instance.set_values(dict(zip(self.inputs, values, strict=True)))

    def at(self, values: Sequence[Value]) -> list[Value]:
        """The outputs with these inputs."""
        self.set(values)
        return self.read()

    @not_lost()
    def step(self, size: float) -> None:
        """Make a step of `size` [s]; RunError as the methods of an instance."""
        status, _ = self._step.perform(self._instance.time, size, 0)
        if status:
            self._instance.fail(status, DoStep.function, size)
        self._instance.time += size

    def trajectory(
        self, size: float, count: int, first: Sequence[Value] | None = None
    ) -> list[list[Value]]:
        """The outputs after each of so many steps of `size` [s].

        The inputs get the values `first` before these steps; without, they stay as they are.
        """
        if first is not None:
            self.set(first)
        found: list[list[Value]] = []
        for _ in range(count):
            self.step(size)
            found.append(self.read())
        return found

    def moved_together(self, sign: float = 1.0) -> list[Value]:
        """All inputs moved from their start, each by another share of its size."""
        return self.moved([sign * TOGETHER * (1 + k / 7) for k in range(len(self.inputs))])

    def moved(self, shares: Sequence[float], values: Sequence[Value] | None = None) -> list[Value]:
        """Inputs moved from `values`, or their start, by `shares` of their sizes."""
        rows = zip(self._known, self.start, values or self.start, shares, strict=True)
        return [_moved(v, start, value, share) for v, start, value, share in rows]


def _moved(variable: Variable, start: Value, value: Value, share: float) -> Value:
    """A value moved by a share of its size, back from a limit; another, if it has no size."""
    if not share:
        return value
    if variable.type == "Boolean":
        return not value
    if isinstance(value, str):
        return f"{value}_"
    if variable.type == "Enumeration":
        others = [number for number in variable.items.values() if number != value]
        return others[0] if others else value
    low, high = variable.minimum, variable.maximum
    size = max(abs(float(start)), variable.nominal)
    if np.isfinite(high - low):
        size = min(size, (high - low) / 4)
    change = share * size
    if variable.type == "Integer":
        change = round(change) or (1 if share > 0.0 else -1)
    return value + change if low <= value + change <= high else value - change
