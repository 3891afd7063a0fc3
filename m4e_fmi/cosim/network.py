"""The coupled instances at run time: one array of all exchanged values, and the calls that fill it.

`values` holds three blocks of the same layout, all outputs that are exchanged, component by
component:

====================  ==========================================================================
``values[now:]``      at the present communication point, consistent with one another
``values[before:]``   at the communication point before (equal to `now` at the start)
``values[stepped:]``  at the end of the step being made, of the components that have made it
====================  ==========================================================================

An algorithm steps every component from `now`; `advance` then makes the new point the present one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.connect import Link, Port, Wiring
from m4e_fmi.cosim.instance import WARNING, Call, Instance
from m4e_fmi.cosim.newton import AlgebraicLoop
from m4e_fmi.cosim.structure import Loop, Structure, Transfer, derivative_chain

Action = Callable[[], None]


@dataclass(frozen=True)
class Point:
    """A communication point to which a network can return; the FMUs keep their states in `place`.

    `values` and `inputs` are copies of the network's.
    """

    place: int
    time: float
    values: np.ndarray
    inputs: np.ndarray


class Network:
    """Instances, in listing order, with the values that pass between them.

    `time` is the present communication point [s].
    `sweep` is the order in which a Gauss–Seidel algorithm steps the components.
    `inputs[k]` is the value of the connected input `targets[k]` at the present point, in the unit
    of its source, and `links[k]` what leads there; inputs of one component are consecutive
    (`input_slice`), and so are its outputs (`output_slice`, within a block of `values`).
    """

    def __init__(
        self,
        instances: Mapping[str, Instance],
        wiring: Wiring,
        structure: Structure,
        *,
        time: float,
    ) -> None:
        self.instances = dict(instances)
        for link in (*wiring.initial_links, *wiring.links):
            if not link.is_plain:
                instance = self.instances[link.target.component]
                instance.scale_input(link.target.variable, link.factor, link.offset)
        self.time = time
        self.sweep = structure.sweep
        self._wiring = wiring
        self._structure = structure
        self.outputs = _grouped(structure.exchange, "get", self.instances)
        self.targets = _grouped(structure.exchange, "set", self.instances)
        by_target = {link.target: link for link in wiring.links}
        self.links: list[Link] = [by_target[target] for target in self.targets]
        count = len(self.outputs)
        self.values = np.zeros(3 * count)
        self.now, self.before, self.stepped = 0, count, 2 * count
        self.inputs = np.zeros(len(self.targets))
        self._index = {port: k for k, port in enumerate(self.outputs)}
        self._descriptions = {name: i.description for name, i in self.instances.items()}
        self._exchange = _in_order(self._transfer(t) for t in structure.exchange)

    def read(self, name: str) -> float:
        """The present value of the Real variable ``component.variable``, exchanged or not."""
        component, _, variable = name.partition(".")
        return self.instances[component].read(variable)

    def index(self, output: Port) -> int:
        """Place of an output in a block of `values`."""
        return self._index[output]

    def derivatives(self, output: Port) -> list[Port]:
        """The output itself and its declared first and second time derivative, if there are."""
        return derivative_chain(self._descriptions, output)

    def unit(self, port: Port) -> str:
        """The unit of a variable, as its FMU names it."""
        return self._descriptions[port.component].variables[port.variable].unit

    def to_si(self, port: Port) -> float:
        """SI value over value of a variable, 1 if its FMU gives no unit."""
        dimension = self._descriptions[port.component].variables[port.variable].dimension
        return dimension.factor if dimension else 1.0

    def output_slice(self, component: str) -> slice:
        return _range_of(self.outputs, component)

    def input_slice(self, component: str) -> slice:
        return _range_of(self.targets, component)

    def advance(self, time: float) -> None:
        """Make `time` [s], which all instances have reached, the present point."""
        self.time = time
        now, before, stepped = self.now, self.before, self.stepped
        self.values[before:stepped] = self.values[now:before]
        self._exchange()

    def snapshot(self, place: int) -> Point:
        """The present point, instead of the one kept before in the same place."""
        for instance in self.instances.values():
            instance.save_state(place)
        return Point(place, self.time, self.values.copy(), self.inputs.copy())

    def restore(self, point: Point) -> None:
        """Return to a point; an FMU that answered Fatal meanwhile cannot, which is a RunError."""
        for instance in self.instances.values():
            instance.restore_state(point.place)
        self.time = point.time
        self.values[:] = point.values
        self.inputs[:] = point.inputs

    def initialise(self) -> None:
        """In initialization mode: carry over parameters, then outputs, along declared dependencies.

        Afterwards, out of it, everything is exchanged once at the start time.
        """
        for instance in self.instances.values():
            instance.enter_initialization()
        sources = {k.target: k.source for k in (*self._wiring.initial_links, *self._wiring.links)}
        found: dict[Port, float] = {}
        for transfer in self._structure.initial:
            if isinstance(transfer, Loop):
                loop = AlgebraicLoop(self.instances, transfer, sources)
                loop.solve()
                found.update(zip(loop.outputs, loop.output_values.tolist(), strict=True))
                continue
            instance = self.instances[transfer.component]
            ports = [Port(transfer.component, name) for name in transfer.variables]
            view = np.zeros(len(ports))
            if transfer.action == "get":
                self.reader(transfer.component, transfer.variables, view)()
                found.update(zip(ports, view.tolist(), strict=True))
            else:
                view[:] = [found[sources[port]] for port in ports]
                self._checked(instance, instance.setter(transfer.variables, view), "fmi2SetReal")()
        for instance in self.instances.values():
            instance.exit_initialization()
        self._exchange()
        self.values[self.before : self.stepped] = self.values[self.now : self.before]

    def reader(self, component: str, names: Sequence[str], view: np.ndarray) -> Action:
        """An action that reads outputs into `view`; RunError if one is nan or infinite."""
        instance = self.instances[component]
        get, zeros, names = instance.getter(names, view), np.zeros(len(names)), tuple(names)
        dot = view.dot

        def read() -> None:
            status = get()
            if status > WARNING:
                instance.fail(status, "fmi2GetReal")
            if dot(zeros) != 0.0:  # 0·nan and 0·inf are nan
                instance.not_finite(names, view)

        return read

    def writer(self, component: str, view: np.ndarray) -> Action:
        """An action that sets all connected inputs of a component from `view`."""
        instance = self.instances[component]
        names = [port.variable for port in self.targets[self.input_slice(component)]]
        return self._checked(instance, instance.setter(names, view), "fmi2SetReal")

    def derivative_writer(self, component: str, view: np.ndarray) -> Action:
        """An action that gives all connected inputs of a component two derivatives, from `view`."""
        instance = self.instances[component]
        names = [port.variable for port in self.targets[self.input_slice(component)]]
        call = instance.derivative_setter(names, view)
        return self._checked(instance, call, "fmi2SetRealInputDerivatives")

    def stepper(self, component: str) -> Callable[[float, float], None]:
        """The action ``(t, h)`` that steps a component from t to t + h [s]."""
        instance = self.instances[component]
        call = instance.stepper()

        def step(time: float, size: float) -> None:
            status = call(time, size, 1)
            if status > WARNING:
                instance.fail(status, "fmi2DoStep", size)
            instance.time = time + size

        return step

    @staticmethod
    def _checked(instance: Instance, call: Call, function: str) -> Action:
        def action() -> None:
            status = call()
            if status > WARNING:
                instance.fail(status, function)

        return action

    def _loop(self, loop: AlgebraicLoop) -> Action:
        outputs = np.array([self.index(port) for port in loop.outputs], dtype=np.intp)
        inputs = np.array([self.targets.index(port) for port in loop.inputs], dtype=np.intp)

        def solve() -> None:
            loop.solve()
            self.values[outputs] = loop.output_values
            self.inputs[inputs] = loop.input_values

        return solve

    def _transfer(self, transfer: Transfer | Loop) -> Action:
        if isinstance(transfer, Loop):
            sources = {link.target: link.source for link in self.links}
            return self._loop(AlgebraicLoop(self.instances, transfer, sources))
        first = Port(transfer.component, transfer.variables[0])
        count = len(transfer.variables)
        if transfer.action == "get":
            start = self.index(first)
            return self.reader(
                transfer.component, transfer.variables, self.values[start : start + count]
            )
        start = self.targets.index(first)
        view = self.inputs[start : start + count]
        sources = np.array([self.index(k.source) for k in self.links[start : start + count]])
        instance = self.instances[transfer.component]
        call, take = instance.setter(transfer.variables, view), self.values.take

        def carry() -> None:
            take(sources, out=view, mode="clip")
            status = call()
            if status > WARNING:
                instance.fail(status, "fmi2SetReal")

        return carry


def _grouped(
    steps: Sequence[Transfer | Loop], action: str, components: Mapping[str, Instance]
) -> list[Port]:
    """All variables of the transfers of one kind, by component and within it by call."""
    transfers = [
        transfer
        for step in steps
        for transfer in ((*step.sets, *step.gets) if isinstance(step, Loop) else (step,))
    ]
    return [
        Port(transfer.component, name)
        for component in components
        for transfer in transfers
        if transfer.action == action and transfer.component == component
        for name in transfer.variables
    ]


def _range_of(ports: Sequence[Port], component: str) -> slice:
    places = [k for k, port in enumerate(ports) if port.component == component]
    return slice(places[0], places[-1] + 1) if places else slice(0, 0)


def _in_order(actions: Iterable[Action]) -> Action:
    steps = tuple(actions)

    def run() -> None:
        for action in steps:
            action()

    return run
