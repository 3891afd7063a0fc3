"""The coupled instances at run time: one array of all exchanged values, and the calls that fill it.

An algorithm steps every component from `now`; `advance` then makes the new point the present one.
`layout` describes the blocks of `values`.

Outputs that do not depend on connected inputs within an instant are read straight after the last
step of their component (`arrival`), before any of its inputs is set: some FMUs lose them then. They
are in `stepped` when `advance` begins; the others are read by the exchange, and of FMUs not built
here by `reread`, too. Behind the blocks are outputs that are not exchanged, but wanted by results
or observers, and then the readings of those that are read twice.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from itertools import count
from typing import Any, TypeVar
from weakref import WeakSet

import numpy as np

from m4e_fmi.cosim.connections.early_outputs import Arrivals, Groups, following
from m4e_fmi.cosim.connections.links import Link, Port
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.connections.structure import AlgebraicLoop, Exchange, Transfer
from m4e_fmi.cosim.exchange.discrete import Discrete
from m4e_fmi.cosim.exchange.initialisation import Initialisation
from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.layout import BLOCKS, OWN_PLACES, ExchangedVariables, NetworkSnapshot
from m4e_fmi.cosim.exchange.newton import LoopEquations
from m4e_fmi.cosim.exchange.operations import (
    LOST,
    Choose,
    DoStep,
    Get,
    GetTyped,
    Operation,
    Transferring,
    gather,
    setting,
)
from m4e_fmi.cosim.exchange.rereading import ROWS, Rereading, rereadings
from m4e_fmi.cosim.exchange.schedule import Schedule
from m4e_fmi.cosim.scenario.scenario import Scenario
from m4e_fmi.cosim.system.simulation import ComponentStep
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.calls import Texts
from m4e_fmi.shown import listing

Made = TypeVar("Made")
Change = tuple[str, Mapping[str, Value]]
"""A component, and values of variables of it by name."""
TWICE, HALF = 2.0, 0.5
"""Length of the steps of the error estimate, over that of the simulation."""


class Network(ExchangedVariables):
    """Instances of a prepared system, in listing order, with the values that pass between them.

    `time` is the present communication point [s]. `last` is the size [s] of the step that led there
    from the one before, 0 where nothing before it counts (at the start, after a jump); `size` that
    of the step being made, set by algorithms. `coarse` is the length of the steps being made over
    the simulation's step, which an algorithm must know when it is made.
    `values` (five blocks of outputs, and further outputs) are in the units of the FMUs; `inputs[k]`
    is the value of the connected input `targets[k]` at the present point, in the unit of its
    source. All these are Real; other values are in `discrete`. `roughness` is the largest share of
    an input's size by which it still misses its source where algebraic loops are solved. `left` are
    the values (n,) before the scenario's actions at this point, in the same units, if it has acted
    (None: it has not). `pause` is called between steps that are not part of the run, and raises to
    end them early. `recorded` are the outputs by component that results will have; those that are
    not exchanged are read too, and all others if they are `watched`.
    """

    def __init__(
        self,
        prepared: Prepared,
        instances: Mapping[str, Instance],
        *,
        recorded: Mapping[str, Collection[str]],
        watched: bool = False,
    ) -> None:
        super().__init__(prepared)
        self.instances = dict(instances)
        self._apart = [one for name, one in instances.items() if name in prepared.hosts]
        wiring = prepared.wiring
        once = set(wiring.initial_links)
        for links in wiring.into.values():
            scales = self.instances[links[0].target.component].scales
            mixed = not (once.isdisjoint(links) or once.issuperset(links))
            for link in links:
                if link.is_real and not link.is_plain:
                    scales.set(link.ends, link.factor, link.offset)
                if mixed:
                    scales.follow(link.ends)
        self.scenario = Scenario(prepared, self)
        self._points: WeakSet[NetworkSnapshot] = WeakSet()
        self.time = prepared.system.simulation.start_time
        self.coarse = 1.0
        self.pause: Callable[[], None] = lambda: None
        self.last = self.size = 0.0
        self.left: np.ndarray | None = None
        self.roughness = 0.0
        self.inputs = np.zeros(len(self.targets))
        exchange = prepared.structure.exchange
        recorded = self.scenario.with_watched(recorded)
        self._arrivals = Arrivals(self._descriptions, exchange, recorded, watched=watched)
        by_target = {link.target: link for link in wiring.links}
        self.discrete = Discrete(self.instances, exchange, by_target, Texts(), self._arrivals)
        first_seen, size = BLOCKS * len(self.outputs), len(self.outputs)
        self._seen_index = {port: first_seen + k for k, port in enumerate(self._arrivals.ports)}
        late = {name: self._arrivals.twice(name, discrete=False) for name in instances}
        places = first_seen + len(self._seen_index)
        self.values = np.zeros(places + ROWS * sum(map(len, late.values())))
        self._rereadings = rereadings(late, self.values[places:], self._read)
        for one in self._rereadings.values():
            one.block[3] = np.nan  # nothing was read before
        block = self.values[self.before : self.stepped]
        shift: list[Operation] = [gather(block, self.values, range(size))] if size else []
        self._shift = Schedule([*shift, *self.discrete.shift])
        self._exchange = tuple(self._exchanged(exchange))
        self._loops = [p.equations for p in self._exchange if isinstance(p, SolvedLoop)]

    @property
    def stops(self) -> np.ndarray:
        """One value (1,) [1] that a change makes finite, to stop steps that are made at once.

        Empty where all values are Real.
        """
        return self.discrete.changed if self.discrete else np.zeros(0)

    def read(self, name: str) -> Any:
        """The present value of ``component.variable``, exchanged or not, in its own type.

        UnknownNameError, a KeyError, if there is none of this name.
        """
        port = self.port(name)
        place = self.known(port)
        if place is not None:
            return float(self.values[place])
        cell = self.discrete.known(port)
        if cell is not None:
            return self.discrete.value(port, cell)
        return self.instances[port.component].value(port.variable)

    def known(self, port: Port) -> int | None:
        """Place in `values` of the present value of an output; None if only its FMU has it.

        That is so for outputs that are neither exchanged nor recorded, for those of FMUs built here
        that depend on inputs but are not exchanged, and for FMUs with event mode, which may have
        changed them since.
        """
        if self._descriptions[port.component].has_events:
            return None
        place = self._index.get(port)
        return self._seen_index.get(port) if place is None else self.now + place

    def arrival(self, component: str) -> list[Get | GetTyped]:
        """The operations that read early outputs straight after the component's last step."""
        early, names = self.early(component), self._arrivals.early(component)
        found = [self._reading(component, names, self.stepped + early.start)] if names else []
        return [*found, *self.seeing(component)]

    def seeing(self, component: str) -> list[Get | GetTyped]:
        """The part of `arrival` that reads the outputs that are not Real, or not exchanged."""
        reals = self._unexchanged(component, self._arrivals.further(component))
        found = [replace(reading, in_rows=True) for reading in reals]
        return [*found, *self.discrete.arrival(component, self.due(component))]

    def _unexchanged(self, component: str, groups: Groups) -> Iterator[Get]:
        """Reads Real outputs that are recorded, which must be finite, and others."""
        for names, checked in zip(groups[:2], (True, False), strict=True):
            if names:
                start = self._seen_index[Port(component, names[0])]
                yield replace(self._reading(component, names, start), checked=checked)

    def reread(self, component: str, held: Iterable[Transferring]) -> list[Transferring]:
        """Reads outputs that depend on inputs straight after the last step, and once more.

        In between, `held` sets connected inputs to the values that they have. Of FMUs that were
        built here nothing is read.
        """
        found = self.rereadings(component)
        if not found:
            return []
        first = [operation for one in found for operation in (one.kept, one.first)]
        again = (*held, *(one.second for one in found))
        return [replace(o, due=self.due(component)) for o in (*first, *again)]

    def hold(
        self, component: str, values: np.ndarray, moved: Collection[str] = ()
    ) -> tuple[Transferring, ...]:
        """Sets a component's connected inputs to the values that they have, but those `moved`.

        Those of its Real inputs are `values` (n_inputs,), in the units of their sources.
        """
        links = self.links_to(component)
        places = [k for k, link in enumerate(links) if link.target.variable not in moved]
        if not places:
            return tuple(self.discrete.held(component))
        own, held = np.zeros(len(places)), [links[k] for k in places]
        reals = gather(own, values, places), *setting(self.instances[component], held, own)
        return (*reals, *self.discrete.held(component))

    def read_late(self, component: str, reading: Get) -> tuple[Transferring, ...]:
        """A `reading` of consecutive outputs that depend on inputs, with new ones."""
        one = self._rereadings.get(component)
        return one.new(reading) if one else (reading,)

    def _read(self, component: str, names: Sequence[str], into: np.ndarray) -> Get:
        return Get(self.instances[component], tuple(names), into, checked=False)

    def moved(self, component: str) -> dict[str, str]:
        """Inputs that a component moves along others, their rates, each carried by one link."""
        names = [link.target.variable for link in self.links_to(component)]
        rates = self._descriptions[component].input_derivatives
        return {w: u for w, u in rates.items() if names.count(w) == names.count(u) == 1}

    @property
    def lost(self) -> dict[str, list[str]]:
        """Outputs by component that setting inputs to the values that they have has changed."""
        found = {n: [o for one in self.rereadings(n) for o in one.lost] for n in self.instances}
        return {name: sorted(outputs) for name, outputs in found.items() if outputs}

    def rereadings(self, component: str) -> list[Rereading]:
        """Outputs of a component that are read twice: Reals, and others."""
        both = self._rereadings, self.discrete.rereadings
        return [found[component] for found in both if component in found]

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

    def whole_step(self, component: str) -> tuple[Operation, ...]:
        """A component's macro step with its inputs as the last exchange has set them."""
        held = self.hold(component, self.inputs[self.input_slice(component)])
        reading = (*self.arrival(component), *self.reread(component, held))
        return (*self.steps(component), *reading)

    def steps(self, component: str) -> list[DoStep]:
        """The operations that make a component's macro step."""
        instance, rate = self.instances[component], self.rates.get(component)
        if rate is None:
            return [DoStep(instance)]
        if rate.is_longer:
            return [DoStep(instance, own=rate.step, due=self.due(component))]
        pieces, steps = self.pieces(rate)
        count = pieces * steps
        return [DoStep(instance, k / count, 1 / count, rate.step) for k in range(count)]

    def pieces(self, rate: ComponentStep) -> tuple[int, int]:
        """The number of pieces in which a component makes the macro step, and of steps in each.

        A piece has several steps where the macro step is longer than the simulation's.
        """
        return rate.pieces, int(max(self.coarse, 1.0))

    def advance(self, time: float) -> tuple[Port, ...]:
        """Make `time` [s], which all instances have reached by a step, the present point.

        Returns the outputs that are not Real and have changed there, actions of the scenario among
        them.
        """
        self.time, self.last = time, self.size
        self._shift.run(time)
        self._run_exchange()
        acted = self._act()
        return (*self.settle(), *acted)

    def _act(self) -> tuple[Port, ...]:
        """Let the scenario act at the present point; the actions that have begun or ended."""
        if not self.scenario:
            return ()
        before = self.values.copy()
        acted = self.scenario.act(self.time)
        self.left = before if acted.ports else None
        for component, names in acted.changes.items():
            self._read_again(component, names)
        if acted.again:
            self._run_exchange()
        if acted.ports:
            self.last = 0.0
        return acted.ports

    def within_step(self, ports: Iterable[Port]) -> list[Port]:
        """The outputs among `ports` that may change anywhere within a step, not only at its end."""
        own = [port for port in ports if port in self.scenario.late]
        return own + [
            port
            for port in ports
            if port.component in self.instances
            and not self._descriptions[port.component].has_events
            and not self.due(port.component)
        ]

    def settle(self) -> tuple[Port, ...]:
        """After an exchange: the outputs that are not Real and have changed, which is a jump."""
        changed = tuple(self.discrete.settle()) if self.discrete else ()
        if changed:
            self.last = 0.0
        return changed

    def change(self, changes: Sequence[Change]) -> None:
        """Set variables at the present point, and exchange again."""
        for component, values in changes:
            self.instances[component].set_values(values)
        self.refresh(changes)

    def made(self, make: Callable[[Network], Made], length: float) -> Made:
        """The result of `make` for steps of this `length`, over the simulation's step."""
        self.coarse = length
        try:
            return make(self)
        finally:
            self.coarse = 1.0

    def forget(self) -> None:
        """Drop the points before the step being made, in which a value has jumped."""
        self.size = 0.0

    def refresh(self, changes: Iterable[Change]) -> None:
        """Exchange again at the present point, after variables were set in FMUs."""
        self.values[self.stepped : self.middle] = self.values[self.now : self.before]
        names: dict[str, set[str]] = {}
        for component, values in changes:
            names.setdefault(component, set()).update(values)
        for component, changed in names.items():
            self._read_again(component, changed)
        self._run_exchange()
        self.settle()

    def _read_again(self, component: str, changed: Collection[str]) -> None:
        """Read the outputs that may depend on `changed` variables; others may be lost by now."""
        may_change = following(self._descriptions[component], changed)
        for reading in self.arrival(component):
            before = reading.into.copy()
            Schedule([reading]).run(self.time)
            stays = [not may_change(name) for name in reading.names]
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
        """The operations of `advance`; None with a scenario, or where loops are solved."""
        parts = [part for part in self._exchange if isinstance(part, Schedule)]
        if self.scenario or len(parts) < len(self._exchange):
            return None
        return tuple(o for part in (self._shift, *parts) for o in part.operations)

    def snapshot(self, place: int) -> NetworkSnapshot:
        """The present point, instead of the one kept before in the same place."""
        for instance in self.instances.values():
            instance.save_state(place)
        loops = tuple(part.snapshot() for part in self._loops)
        copies = self.values.copy(), self.inputs.copy(), self.discrete.kept()
        rest = self.roughness, self.scenario.snapshot()
        return NetworkSnapshot(place, self.time, self.last, *copies, loops, *rest)

    def keep(self) -> NetworkSnapshot:
        """The present point, in a place of its own, which is free again when nothing holds it."""
        held = {point.place for point in self._points}
        point = self.snapshot(next(k for k in count(OWN_PLACES) if k not in held))
        self._points.add(point)
        return point

    def adopt(self, point: NetworkSnapshot) -> None:
        """Hold the place of a point of another process, in which the FMUs have its states."""
        self._points.add(point)

    def restore(self, point: NetworkSnapshot) -> None:
        """Return to a point; an FMU that answered Fatal meanwhile cannot, which is a RunError."""
        for instance in self.instances.values():
            instance.restore_state(point.time, point.place)
        self.time, self.last = point.time, point.last
        self.values[:] = point.values
        self.inputs[:] = point.inputs
        self.discrete.bring(point.discrete)
        self.roughness = point.roughness
        self.scenario.restore(point.scenario)
        for loop, kept in zip(self._loops, point.loops, strict=True):
            loop.restore(kept)

    @contextmanager
    def rehearsing(self) -> Generator[None]:
        """A context for steps that are not part of the run: messages of the FMUs are dropped."""
        with ExitStack() as stack:
            for instance in self.instances.values():
                stack.enter_context(instance.rehearsing())
            yield

    def initialise(self) -> None:
        """In initialization mode: carry over parameters, then outputs, along declared dependencies.

        Afterwards, out of it, everything is exchanged once at the start time. Inputs that come
        late have their start values, and then the values that their sources had with these.
        """
        for instance in self.instances.values():
            instance.enter_initialization()
        start = Initialisation(
            self.instances, self._wiring, self._structure, self.discrete.texts, self._arrive
        )
        start.run()
        start.keep_constants()
        for component, instance in self.instances.items():
            instance.exit_initialization()
            if component not in start.arrived:
                self._arrive(component, start.given)
        for link in self.links:
            self.values[self.before + self.index(link.source)] = start.found[link.source]
        self.discrete.begin(start.discrete)
        self._run_exchange()
        self._act()
        self.settle()
        self.values[self.before : self.stepped] = self.values[self.now : self.before]
        self.flush()

    def flush(self) -> None:
        """Have all FMUs take the values that were set; RunError if one refuses."""
        for instance in self._apart:
            instance.flush()

    def _arrive(self, component: str, given: Mapping[Link, float]) -> None:
        """Perform `arrival` and `reread` at once; the links `given` carry these values."""
        links = [link for link in self.links_to(component) if link in given]
        values = np.array([given[link] for link in links])
        held = setting(self.instances[component], links, values) if links else ()
        reading = (*self.arrival(component), *self.reread(component, held))
        Schedule([replace(o, due=None) for o in reading]).run(self.time)

    def _exchanged(self, transfers: Exchange) -> Iterator[Schedule | SolvedLoop]:
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
            yield SolvedLoop(self, transfer)
        for component in self.instances:
            for reading in self._unexchanged(component, self._arrivals.late(component)):
                operations += self.read_late(component, reading)
            operations += self.discrete.seen(component, self.due(component))
        yield Schedule(operations)

    def _transfer(self, transfer: Transfer) -> tuple[Transferring, ...]:
        if transfer.discrete:
            return self.discrete.operations(transfer)
        instance, names = self.instances[transfer.component], transfer.variables
        if transfer.action == "get":
            start = self.index(Port(transfer.component, names[0]))
            reading = Get(instance, names, self.values[start : start + len(names)])
            return self.read_late(transfer.component, reading)
        links = [
            link for link in self.links_to(transfer.component) if link.target.variable in names
        ]
        start = self.place(links[0])
        view = self.inputs[start : start + len(links)]
        return (
            gather(view, self.values, list(map(self.present, links))),
            *setting(instance, links, view),
        )

    def __repr__(self) -> str:
        title = f"Network at t = {self.time:.9g} s"
        return listing(title, components=self.instances, inputs=[str(p) for p in self.targets])


class SolvedLoop:
    """An algebraic loop within the exchange, whose solution goes into values and inputs."""

    def __init__(self, network: Network, loop: AlgebraicLoop) -> None:
        self._network = network
        self.equations = LoopEquations(network.instances, loop, network.links)
        outputs = [network.index(port) for port in self.equations.outputs]
        inputs = [network.place(link) for link in self.equations.links]
        self._outputs = np.array(outputs, dtype=np.intp)
        self._inputs = np.array(inputs, dtype=np.intp)
        self._readings = [
            (transfer, one.part(transfer.variables))
            for transfer in loop.gets
            for one in network.rereadings(transfer.component)[:1]
            if transfer.variables[0] in one.names
        ]
        self._choose = Schedule(
            [
                Choose(
                    network.instances[transfer.component],
                    transfer.variables,
                    np.zeros(len(transfer.variables)),
                    readings,
                    checked=False,
                )
                for transfer, readings in self._readings
            ]
        )

    def run(self, time: float) -> None:
        """Solve the loop at the present point, `time` [s].

        RunError if it fails, is singular at first, or setting its inputs loses outputs.
        """
        is_first = not self.equations.is_started
        network = self._network
        self.equations.solve({k: network.values[network.present(k)] for k in self.equations.known})
        if is_first:
            self.equations.check_regular()
        self._network.roughness = max(self._network.roughness, self.equations.roughness)
        self._network.values[self._outputs] = self.equations.output_values
        self._network.inputs[self._inputs] = self.equations.input_values
        for transfer, readings in self._readings:
            start = self._network.index(Port(transfer.component, transfer.variables[0]))
            readings[3] = self._network.values[start : start + len(transfer.variables)]
        self._choose.run(time)
        for transfer, (first, second, before, _, size, lost) in self._readings:
            gross = np.isfinite(before) & ~(np.abs(second - first) <= LOST * size)
            for name in np.array(transfer.variables)[(lost > 0) & gross]:
                raise RunError(
                    f"{transfer.component}.{name} at t = {time:.9g} s is lost when inputs are set, "
                    "so that the algebraic loop through it has no solution",
                    f"list the inputs on which it really depends under `dependencies` of "
                    f"{transfer.component} in the system file, as {{{name}: []}}",
                )
            lost[:] = 0  # noise of the FMU, with which the solution counts
