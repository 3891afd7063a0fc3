"""The coupled instances at run time: one array of all exchanged values, and the calls that fill it.

`values` holds five blocks of the same layout, all outputs that are exchanged, component by
component:

====================  ==========================================================================
``values[now:]``      at the present communication point, consistent with one another
``values[before:]``   at the communication point before (equal to `now` at the start)
``values[stepped:]``  at the end of the step being made, of the components that have made it
``values[middle:]``   in the middle of the step being made, where an algorithm looks there
``values[earlier:]``  in the middle of the step before, likewise
====================  ==========================================================================

An algorithm steps every component from `now`; `advance` then makes the new point the present one.

Outputs that do not depend on connected inputs within an instant are read straight after the last
step of their component (`arrival`), before any of its inputs is set: there are FMUs that lose them
then. They are in `stepped` when `advance` begins; the others are read by the exchange. Behind the
five blocks are outputs that are not exchanged, but wanted by results or observers (`arrivals`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, TypeVar
from weakref import finalize

import numpy as np

from m4e_fmi.cosim.connections.early_outputs import Arrivals, following
from m4e_fmi.cosim.connections.links import Link, Port, Wiring
from m4e_fmi.cosim.connections.structure import AlgebraicLoop, Structure, Transfer, derivative_chain
from m4e_fmi.cosim.exchange.discrete import Discrete, Kept
from m4e_fmi.cosim.exchange.instance import WARNING, Call, Instance
from m4e_fmi.cosim.exchange.newton import LoopEquations
from m4e_fmi.cosim.exchange.operations import (
    Combine,
    DoStep,
    Due,
    Gather,
    Get,
    GetTyped,
    Operation,
    Set,
    SetTyped,
    gather,
    setting,
)
from m4e_fmi.cosim.exchange.snapshot import Memory, recall, remember
from m4e_fmi.cosim.exchange.step_loop import Schedule
from m4e_fmi.cosim.system.component_step import ComponentStep
from m4e_fmi.cosim.system.component_steps import ComponentSteps
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.errors import UnknownNameError
from m4e_fmi.fmu.importer.calls import Texts
from m4e_fmi.shown import listing

Made = TypeVar("Made")
Action = Callable[[], None]
Change = tuple[str, Mapping[str, Value]]
"""A component, and values of variables of it by name."""
OWN_PLACES = 2
"""Where FMUs keep states while steps are made: by algorithms (0), `doubling` (1); points that are
kept have places from here on."""
TWICE, HALF = 2.0, 0.5
"""How much longer than the simulation's the steps are that tell its error."""


@dataclass(frozen=True)
class NetworkSnapshot:
    """A communication point to which a network can return; the FMUs keep their states in `place`.

    `values`, `inputs` and those that are not Real (`discrete`) are copies of the network's, `loops`
    what its algebraic loops start from, `roughness` how well they were solved.
    """

    place: int
    time: float
    last: float
    values: np.ndarray
    inputs: np.ndarray
    discrete: Kept
    loops: tuple[Memory, ...]
    roughness: float


class Network:
    """Instances, in listing order, with the values that pass between them.

    `time` is the present communication point [s]. `last` is the size [s] of the step that led there
    from the one before, 0 where nothing before it counts (at the start, after a jump); `size` that
    of the step being made, as algorithms tell it. `rates` are those of the components with a step
    of their own; `coarse` times the simulation's step is made at once, which an algorithm must know
    when it is made.
    `execution_order` is the order in which a Gauss–Seidel algorithm steps the components.
    `inputs[k]` is the value of the connected input `targets[k]` at the present point, in the unit
    of its source, and `links[k]` what leads there; inputs of one component are consecutive
    (`input_slice`), and so are its outputs (`output_slice`, within a block of `values`).
    `has_loops` tells of algebraic loops, which are solved at each point; `roughness` is the largest
    share of an input's size by which it still misses its source where inputs are solved for.
    `judged` are the outputs by which the coupling is judged, each with the number of a connection
    that it belongs to: the sources of all links, and what comes of them where they end.
    All that is so far is Real; what is not, and what takes such values, is `discrete`.
    `pause` is called between steps that are none of the run, and raises what ends them early.
    `recorded` are the outputs by component that results will have (None: all scalars); those that
    are not exchanged are read too, and all others if they are `watched`.
    """

    def __init__(
        self,
        instances: Mapping[str, Instance],
        wiring: Wiring,
        structure: Structure,
        rates: ComponentSteps,
        *,
        time: float,
        recorded: Mapping[str, Collection[str]] | None = None,
        watched: bool = False,
    ) -> None:
        self.instances = dict(instances)
        for link in (*wiring.initial_links, *wiring.links):
            if link.is_real and not link.is_plain:
                instance = self.instances[link.target.component]
                instance.scale_input(link.target.variable, link.factor, link.offset)
        self._free: list[int] = []
        self._places = count(OWN_PLACES)
        self.rates = rates
        self._origin = round(time * NS_PER_SECOND)
        self.coarse = 1.0
        self.pause: Callable[[], None] = lambda: None
        self.time = time
        self.last = self.size = 0.0
        self.execution_order = structure.execution_order
        self._wiring = wiring
        self._structure = structure
        self.outputs = _grouped(structure.exchange, "get", self.instances)
        self.targets = _grouped(structure.exchange, "set", self.instances)
        by_target = {link.target: link for link in wiring.links}
        self.links: list[Link] = [by_target[target] for target in self.targets]
        self.has_loops = bool(structure.loops)
        self.roughness = 0.0
        self.monitored_outputs = tuple(_judged(self.links, structure.ends, wiring.links))
        size = len(self.outputs)
        self.now, self.before, self.stepped, self.middle, self.earlier, first_seen = (
            k * size for k in range(6)
        )
        self.inputs = np.zeros(len(self.targets))
        self._index = {port: k for k, port in enumerate(self.outputs)}
        self._place = {port: k for k, port in enumerate(self.targets)}
        self._output_ranges, self._input_ranges = _ranges(self.outputs), _ranges(self.targets)
        self._descriptions = {name: i.description for name, i in self.instances.items()}
        self._arrivals = Arrivals(self._descriptions, structure.exchange, recorded, watched=watched)
        self.discrete = Discrete(
            self.instances, structure.exchange, by_target, Texts(), self._arrivals
        )
        self._seen_index = {port: first_seen + k for k, port in enumerate(self._arrivals.ports)}
        self.values = np.zeros(first_seen + len(self._seen_index))
        block = self.values[self.before : self.stepped]
        shift: list[Operation] = [gather(block, self.values, range(size))] if size else []
        self._shift = Schedule([*shift, *self.discrete.shift])
        self._exchange = tuple(self._exchanged(structure.exchange))

    @property
    def sources(self) -> tuple[Port, ...]:
        """The outputs that connections carry, of all types."""
        return self._wiring.sources

    @property
    def stops(self) -> np.ndarray:
        """What becomes finite where steps that are made at once have to stop: at a change."""
        return self.discrete.changed if self.discrete else np.zeros(0)

    def read(self, name: str) -> Any:
        """The present value of ``component.variable``, exchanged or not, in its own type.

        UnknownNameError, a KeyError, if there is none of this name.
        """
        component, _, variable = name.partition(".")
        description = self._descriptions.get(component)
        if description is None or variable not in description.variables:
            known = [f"{c}.{v}" for c, d in self._descriptions.items() for v in d.variables]
            raise UnknownNameError.of("no variable is called", [name], known)
        port = Port(component, variable)
        place = self.known(port)
        if place is not None:
            return float(self.values[place])
        cell = self.discrete.known(port)
        if cell is not None:
            return self.discrete.value(port, cell)
        return self.instances[component].value(variable)

    def known(self, port: Port) -> int | None:
        """Where in `values` the present value of an output is; None if only its FMU can tell it.

        So it is of outputs that nobody wanted, of those that follow inputs but are not exchanged,
        and of FMUs with event mode, which may have changed them since.
        """
        if self._descriptions[port.component].has_events:
            return None
        place = self._index.get(port)
        return self._seen_index.get(port) if place is None else self.now + place

    def arrival(self, component: str) -> list[Get | GetTyped]:
        """Reads what a component gives before its inputs are set; to follow its last step."""
        early, names = self.early(component), self._arrivals.early(component)
        found = [self._reading(component, names, self.stepped + early.start)] if names else []
        return [*found, *self.seeing(component)]

    def seeing(self, component: str) -> list[Get | GetTyped]:
        """The part of `arrival` that reads the outputs that are not Real, or not exchanged."""
        recorded, watched = self._arrivals.further(component)
        found: list[Get | GetTyped] = []
        for names, checked in ((recorded, True), (watched, False)):
            if names:
                start = self._seen_index[Port(component, names[0])]
                reading = self._reading(component, names, start)
                found.append(replace(reading, in_rows=True, checked=checked))
        return [*found, *self.discrete.arrival(component, self.due(component))]

    def recorded(self, component: str) -> tuple[str, ...]:
        """Outputs that are not exchanged, but read for results before any input is set."""
        return self._arrivals.further(component)[0]

    def early(self, component: str) -> slice:
        """Places of the exchanged outputs that a component gives before its inputs are set."""
        start = self.output_slice(component).start
        return slice(start, start + len(self._arrivals.early(component)))

    def _reading(self, component: str, names: tuple[str, ...], start: int) -> Get:
        view = self.values[start : start + len(names)]
        return Get(self.instances[component], names, view, due=self.due(component))

    def due(self, component: str) -> Due | None:
        """When the component has a point, if not at every communication point."""
        rate = self.rates.get(component)
        if rate is None or not rate.is_sampled:
            return None
        return Due(self._origin, round(rate.step * NS_PER_SECOND))

    def steps(self, component: str) -> list[DoStep]:
        """The steps of a component that make its macro step."""
        instance, rate = self.instances[component], self.rates.get(component)
        if rate is None:
            return [DoStep(instance)]
        if rate.is_sampled:
            return [DoStep(instance, own=rate.step, due=self.due(component))]
        pieces, steps = self.pieces(rate)
        count = pieces * steps
        return [DoStep(instance, k / count, 1 / count, rate.step) for k in range(count)]

    def pieces(self, rate: ComponentStep) -> tuple[int, int]:
        """The pieces in which a component with this rate makes the macro step, and steps of each.

        Those are its own; where half of the simulation's step is made at once, half as long.
        """
        return rate.pieces, int(max(self.coarse, 1.0))

    def index(self, output: Port) -> int:
        """Place of an output in a block of `values`."""
        return self._index[output]

    def place(self, target: Port) -> int:
        """Place of a connected input in `inputs`."""
        return self._place[target]

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
        return self._output_ranges.get(component, slice(0, 0))

    def input_slice(self, component: str) -> slice:
        return self._input_ranges.get(component, slice(0, 0))

    def advance(self, time: float) -> tuple[Port, ...]:
        """Make `time` [s], which all instances have reached by a step, the present point.

        The outputs that are not Real and have changed there.
        """
        self.time, self.last = time, self.size
        self._shift.run(time)
        self._run_exchange()
        return self.settle()

    def within_step(self, ports: Iterable[Port]) -> list[Port]:
        """Those of some outputs that may change anywhere within a step, and not at its end."""
        return [
            port
            for port in ports
            if not self._descriptions[port.component].has_events and not self.due(port.component)
        ]

    def settle(self) -> tuple[Port, ...]:
        """After an exchange: outputs that are not Real and have changed. That is a jump."""
        changed = tuple(self.discrete.settle()) if self.discrete else ()
        if changed:
            self.last = 0.0
        return changed

    def change(self, changes: Sequence[Change]) -> None:
        """Set these at the present point, and exchange again."""
        for component, values in changes:
            self.instances[component].set_values(values)
        self.refresh(changes)

    def made(self, make: Callable[[Network], Made], length: float) -> Made:
        """What `make` makes of this network for steps of this `length` over the simulation's."""
        self.coarse = length
        try:
            return make(self)
        finally:
            self.coarse = 1.0

    def forget(self) -> None:
        """Something has jumped in the step being made: the points before it tell nothing more."""
        self.size = 0.0

    def refresh(self, changes: Iterable[Change]) -> None:
        """Exchange again at the present point, after these were set in FMUs."""
        self.values[self.stepped : self.middle] = self.values[self.now : self.before]
        names: dict[str, set[str]] = {}
        for component, values in changes:
            names.setdefault(component, set()).update(values)
        for component, changed in names.items():
            self._read_again(component, changed)
        self._run_exchange()
        self.settle()

    def _read_again(self, component: str, changed: Collection[str]) -> None:
        """Read outputs that may follow variables which were set; the others may be lost by that."""
        follows = following(self._descriptions[component], changed)
        for reading in self.arrival(component):
            before = reading.into.copy()
            Schedule([reading]).run(self.time)
            stays = [not follows(name) for name in reading.names]
            reading.into[stays] = before[stays]

    def _run_exchange(self) -> None:
        over = [
            i for i in self.instances.values() if i.has_ended and i.description.version == "2.0"
        ]
        for part in self._exchange:
            if over and isinstance(part, Schedule):
                part = part.without_sets(over)
            part.run(self.time)

    @property
    def operations(self) -> tuple[Operation, ...] | None:
        """What `advance` does, once all components have stepped; None where loops are solved."""
        parts = [part for part in self._exchange if isinstance(part, Schedule)]
        if len(parts) < len(self._exchange):
            return None
        return tuple(o for part in (self._shift, *parts) for o in part.operations)

    def held_place(self, link: Link) -> int | None:
        """Where in `values` the value is that a link carries all through a step, if it is known.

        That is so for those that are delayed.
        """
        return self.before + self.index(link.source) if link.delayed else None

    def snapshot(self, place: int) -> NetworkSnapshot:
        """The present point, instead of the one kept before in the same place."""
        for instance in self.instances.values():
            instance.save_state(place)
        loops = tuple(remember(part) for part in self._exchange)
        copies = self.values.copy(), self.inputs.copy(), self.discrete.kept()
        return NetworkSnapshot(place, self.time, self.last, *copies, loops, self.roughness)

    def keep(self) -> NetworkSnapshot:
        """The present point, in a place of its own, which is free again when nothing holds it."""
        place = self._free.pop() if self._free else next(self._places)
        point = self.snapshot(place)
        finalize(point, self._free.append, place)
        return point

    def restore(self, point: NetworkSnapshot) -> None:
        """Return to a point; an FMU that answered Fatal meanwhile cannot, which is a RunError."""
        for instance in self.instances.values():
            instance.restore_state(point.time, point.place)
        self.time, self.last = point.time, point.last
        self.values[:] = point.values
        self.inputs[:] = point.inputs
        self.discrete.bring(point.discrete)
        self.roughness = point.roughness
        for part, memory in zip(self._exchange, point.loops, strict=True):
            recall(part, memory)

    @contextmanager
    def rehearsing(self) -> Iterator[None]:
        """Within this, steps are made that are none of the run: what FMUs say is not heard."""
        with ExitStack() as stack:
            for instance in self.instances.values():
                stack.enter_context(instance.rehearsing())
            yield

    def initialise(self) -> None:
        """In initialization mode: carry over parameters, then outputs, along declared dependencies.

        Afterwards, out of it, everything is exchanged once at the start time. Inputs that come
        late have their start values, and then what their sources have shown with these.
        """
        for instance in self.instances.values():
            instance.enter_initialization()
        links = (*self._wiring.initial_links, *self._wiring.links)
        sources = {link.target: link.source for link in links if not link.delayed}
        found: dict[Port, float] = {}
        everything = {k.target: k for k in (*self._wiring.initial_links, *self._wiring.links)}
        others = Discrete(self.instances, self._structure.initial, everything, self.discrete.texts)
        arrived: set[str] = set()
        for transfer in self._structure.initial:
            if isinstance(transfer, AlgebraicLoop):
                loop = LoopEquations(self.instances, transfer, sources)
                loop.solve()
                found.update(zip(loop.outputs, loop.output_values.tolist(), strict=True))
                continue
            instance = self.instances[transfer.component]
            if transfer.discrete:
                others.perform(transfer)
                self._arrive_at_once(transfer, arrived)
                continue
            ports = [Port(transfer.component, name) for name in transfer.variables]
            view = np.zeros(len(ports))
            if transfer.action == "get":
                self.reader(transfer.component, transfer.variables, view)()
                found.update(zip(ports, view.tolist(), strict=True))
                self._arrive_at_once(transfer, arrived)
            else:
                view[:] = [found[sources[port]] for port in ports]
                self._checked(instance, instance.setter(transfer.variables, view), "fmi2SetReal")()
        for component, instance in self.instances.items():
            instance.exit_initialization()
            if component not in arrived:
                self._arrive(component)
        for link in self.links:
            self.values[self.before + self.index(link.source)] = found[link.source]
        self.discrete.begin(others)
        self._run_exchange()
        self.settle()
        self.values[self.before : self.stepped] = self.values[self.now : self.before]

    def _arrive_at_once(self, transfer: Transfer, arrived: set[str]) -> None:
        """Read the outputs of an FMU that was initialised by this transfer, and note that."""
        component = transfer.component
        version = self.instances[component].description.version
        if version == "1.0" and transfer.action == "get" and component not in arrived:
            self._arrive(component)
            arrived.add(component)

    def _arrive(self, component: str) -> None:
        Schedule([replace(o, due=None) for o in self.arrival(component)]).run(self.time)

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

    @staticmethod
    def _checked(instance: Instance, call: Call, function: str) -> Action:
        def action() -> None:
            status = call()
            if status > WARNING:
                instance.fail(status, function)

        return action

    def _exchanged(
        self, transfers: Sequence[Transfer | AlgebraicLoop]
    ) -> Iterator[Schedule | _SolvedLoop]:
        """The exchange at a communication point: schedules, and the loops between them."""
        now, places = self.values[: self.before], np.arange(len(self.outputs))
        for component in self.instances:
            places[self.early(component)] += self.stepped
        operations: list[Operation] = [gather(now, self.values, places)] if len(places) else []
        for transfer in transfers:
            if isinstance(transfer, Transfer):
                if self._arrivals.has(transfer):
                    continue
                due = self.due(transfer.component)
                operations += [replace(o, due=due) for o in self._transfer(transfer)]
                continue
            yield Schedule(operations)
            operations = []
            yield _SolvedLoop(self, transfer)
        yield Schedule(operations)

    def _transfer(
        self, transfer: Transfer
    ) -> tuple[Get | Set | Combine | Gather | GetTyped | SetTyped, ...]:
        if transfer.discrete:
            return (self.discrete.operation(transfer, None),)
        instance, names = self.instances[transfer.component], transfer.variables
        first, count = Port(transfer.component, names[0]), len(names)
        if transfer.action == "get":
            start = self.index(first)
            return (Get(instance, names, self.values[start : start + count]),)
        start = self._place[first]
        view = self.inputs[start : start + count]
        links = self.links[start : start + count]
        sources = [
            self.index(k.source) if (held := self.held_place(k)) is None else held for k in links
        ]
        return (gather(view, self.values, sources), *setting(instance, names, view))

    def __repr__(self) -> str:
        title = f"Network at t = {self.time:.9g} s"
        return listing(title, components=self.instances, inputs=[str(p) for p in self.targets])


def _judged(
    links: Sequence[Link], ends: Sequence[Port], everything: Sequence[Link]
) -> Iterator[tuple[int, Port]]:
    into = {link.target.component: link.connection for link in reversed(everything)}
    yield from ((link.connection, link.source) for link in links)
    yield from ((into[port.component], port) for port in ends)


class _SolvedLoop:
    """An algebraic loop within an exchange."""

    SNAPSHOT = ("_loop",)

    def __init__(self, network: Network, loop: AlgebraicLoop) -> None:
        sources = {link.target: link.source for link in network.links}
        self._network = network
        self._loop = solved = LoopEquations(network.instances, loop, sources)
        self._outputs = np.array([network.index(port) for port in solved.outputs], dtype=np.intp)
        places = [network.place(port) for port in solved.inputs]
        self._inputs = np.array(places, dtype=np.intp)

    def run(self, _time: float) -> None:
        self._loop.solve()
        self._network.roughness = max(self._network.roughness, self._loop.roughness)
        self._network.values[self._outputs] = self._loop.output_values
        self._network.inputs[self._inputs] = self._loop.input_values


def _grouped(
    steps: Sequence[Transfer | AlgebraicLoop], action: str, components: Mapping[str, Instance]
) -> list[Port]:
    """All variables of the transfers of one kind, by component and within it by call."""
    found: dict[str, list[Port]] = {component: [] for component in components}
    for step in steps:
        for transfer in (*step.sets, *step.gets) if isinstance(step, AlgebraicLoop) else (step,):
            if transfer.action == action and not transfer.discrete:
                found[transfer.component] += [
                    Port(transfer.component, name) for name in transfer.variables
                ]
    return [port for ports in found.values() for port in ports]


def _ranges(ports: Sequence[Port]) -> dict[str, slice]:
    """Component → its places among `ports`, which are consecutive."""
    found: dict[str, slice] = {}
    for k, port in enumerate(ports):
        first = found[port.component].start if port.component in found else k
        found[port.component] = slice(first, k + 1)
    return found
