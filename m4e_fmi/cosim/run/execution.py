"""A run that Python steps: read and set values between the steps, save states and go back."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from m4e_fmi.cosim.run.checkpoint import State
from m4e_fmi.cosim.run.outcome import Outcome
from m4e_fmi.cosim.run.run import Run
from m4e_fmi.cosim.scenario.plan import why_fixed
from m4e_fmi.cosim.system.start_values import Value, value_of
from m4e_fmi.cosim.wiring.connect import Port, Wiring
from m4e_fmi.errors import InputError, RunError, UnknownNameError, suggestion
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import TYPES
from m4e_fmi.shown import listing
from m4e_fmi.units import Quantity


class CommunicationPoint:
    """The present point of a run: `time` [s], and values by ``point["component.variable"]``."""

    def __init__(self, execution: Execution, time: float) -> None:
        self._execution = execution
        self.time = time

    def __getitem__(self, name: str) -> Any:
        """The value of a variable, in its own type and the unit of its FMU.

        An item of an enumeration is its number. RunError once the run is past.
        """
        if self._execution.point is not self:
            raise RunError(
                f"the run has passed t = {self.time:.9g} s: {name} can no longer be read there",
                "read it before the next step",
            )
        return self._execution[name]

    def __repr__(self) -> str:
        return f"CommunicationPoint at t = {self.time:.9g} s"


class Execution:
    """A run in progress, at a communication point: see `start`.

    Iterating over it gives the present point, then makes a step for each further one, to the stop
    time. ``run["component.variable"]`` reads a variable, assigning to it sets it, in the unit of
    its FMU; an item of an enumeration is read by its number. `outcome` is there when the ``with``
    block has ended without an error.
    """

    def __init__(self, run: Run, descriptions: Mapping[str, Description], wiring: Wiring) -> None:
        self._run, self._descriptions = run, descriptions
        links = (*wiring.links, *wiring.initial_links)
        self._sources = {link.target: link.source for link in links}
        self._open = True
        self._outcome: Outcome | None = None
        self.point = CommunicationPoint(self, run.network.time)

    @property
    def time(self) -> float:
        """The simulated time [s] of the present point."""
        return self.point.time

    @property
    def done(self) -> bool:
        """True if the stop time is reached."""
        return self._run.done

    @property
    def outcome(self) -> Outcome:
        """How the run ended, as `run` tells it; its wall time is that of the block."""
        if self._outcome is None:
            raise RunError("the run has no outcome yet", "leave the `with` block first")
        return self._outcome

    def end(self, outcome: Outcome | None = None) -> None:
        """Nothing can be done with the run any more."""
        self._open, self._outcome = False, outcome

    def __iter__(self) -> Iterator[CommunicationPoint]:
        yield self.point
        while not self.done:
            yield self.step()

    def step(self) -> CommunicationPoint:
        """Make one step; the point at its end. RunError at the stop time, or if an FMU fails."""
        self._refresh()
        if self.done:
            raise RunError(f"the run is at its stop time, t = {self.time:.9g} s")
        self._run.step()
        return self._arrived()

    def save(self) -> State:
        """The state of the whole system, to which `restore` returns as often as wanted.

        It is valid until the block ends. RunError naming the FMUs that cannot save theirs.
        """
        self._refresh()
        return self._run.save()

    def restore(self, state: State) -> CommunicationPoint:
        """Return to a state of this run: the point there, from which it goes on bit for bit.

        Values that were set since then are as they were. Results after it are overwritten.
        """
        self._check_open()
        self._run.restore(state)
        return self._arrived()

    def __getitem__(self, name: str) -> Any:
        self._refresh()
        port, variable = self._variable(name)
        if variable.type not in TYPES:
            raise InputError.single(f"{port} is of type {variable.type}", "it cannot be read")
        value = self._run.network.read(name)
        if isinstance(value, float) and not math.isfinite(value):
            raise RunError(f"{port} at t = {self.time:.9g} s is {value}", "check what was set")
        return value

    def __setitem__(self, name: str, given: Value | Quantity) -> None:
        self._check_open()
        port, variable = self._variable(name)
        why = self._why_fixed(port, variable)
        if why:
            remedy = suggestion(name, self.settable, "variables to set")
            raise InputError.single(f"{port} cannot be set between steps: it {why}", remedy)
        try:
            value = value_of(variable, given)
        except ValueError as error:
            raise InputError.single(f"value {given!r} of {port} is wrong", str(error)) from None
        self._run.set(port.component, {port.variable: value})

    @property
    def settable(self) -> list[str]:
        """Variables that may be set between steps: unconnected inputs, tunable parameters."""
        return [str(port) for port, v in self._all() if not self._why_fixed(port, v)]

    def _why_fixed(self, port: Port, variable: Variable) -> str:
        """Why a variable cannot be set between steps; empty if it can."""
        if port in self._sources:
            return f"is connected to {self._sources[port]}"
        return why_fixed(variable)

    def _variable(self, name: str) -> tuple[Port, Variable]:
        port = Port.named(name)
        description = self._descriptions.get(port.component)
        if description is None or port.variable not in description.variables:
            known = [str(one) for one, _ in self._all()]
            raise UnknownNameError.of("no variable is called", [name], known)
        return port, description.variables[port.variable]

    def _all(self) -> Iterator[tuple[Port, Variable]]:
        for component, description in self._descriptions.items():
            for variable in description.variables.values():
                yield Port(component, variable.name), variable

    def _refresh(self) -> None:
        """Bring outputs into agreement with what was set."""
        self._check_open()
        self._run.refresh()

    def _arrived(self) -> CommunicationPoint:
        self.point = CommunicationPoint(self, self._run.network.time)
        return self.point

    def _check_open(self) -> None:
        if not self._open:
            raise RunError("the run has ended", "do this within its `with` block")

    def __repr__(self) -> str:
        state = f"at t = {self.time:.9g} s" if self._open else "which has ended"
        return listing(f"Execution of a run, {state}", components=self._descriptions)
