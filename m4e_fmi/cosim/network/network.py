"""The coupled instances at run time: one array of all exchanged values, and the calls that fill it.

An algorithm steps every component from `now`; `advance` then makes the new point the present one.
`Network.values` has blocks of the same layout, all Real outputs that are exchanged, component by
component:

====================  ==========================================================================
``values[now:]``      at the present communication point, consistent with one another
``values[before:]``   at the communication point before (equal to `now` at the start)
``values[stepped:]``  at the end of the step being made, of the components that have made it
``values[middle:]``   in the middle of the step being made, where an algorithm evaluates that
``values[earlier:]``  in the middle of the step before, likewise
====================  ==========================================================================

Outputs that do not depend on connected inputs within an instant are read straight after the last
step of their component (`arrival`), before any of its inputs is set: some FMUs lose them then. They
are in `stepped` when `advance` begins; the others are read by the exchange, and of FMUs not built
here by `reread`, too. Behind the blocks are outputs that are not exchanged, but wanted by results
or observers, and then the readings of those that are read twice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import count
from operator import attrgetter
from typing import Any, TypeVar
from weakref import WeakSet

import numpy as np

from m4e_fmi.cosim.network.arrivals import (
    ROWS,
    Arrivals,
    Groups,
    Rereading,
    following,
    rereadings,
)
from m4e_fmi.cosim.network.discrete import Discrete, Kept
from m4e_fmi.cosim.network.initialisation import Initialisation
from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.newton import LoopEquations, SolvedLoop
from m4e_fmi.cosim.network.operations import (
    DoStep,
    Due,
    Get,
    GetTyped,
    Operation,
    Transferring,
    gather,
    setting,
)
from m4e_fmi.cosim.network.restorable import Snapshot
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.scenario.scenario import Scenario, ScenarioSnapshot
from m4e_fmi.cosim.system.simulation import ComponentStep
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.cosim.wiring.links import Link, Port
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.cosim.wiring.structure import (
    STEPPED,
    AlgebraicLoop,
    Exchange,
    Transfer,
    how_known,
    transfers_of,
)
from m4e_fmi.errors import UnknownNameError
from m4e_fmi.fmu.importer.calls import Texts
from m4e_fmi.shown import listing

BLOCKS = 5
OWN_PLACES = 2
"""Places of FMU states that are reserved: for algorithms (0), and the error estimate (1)."""
TWICE, HALF = 2.0, 0.5
"""Length of the steps of the error estimate, over that of the simulation."""

_ENDED = attrgetter("ended")

Made = TypeVar("Made")
Change = tuple[str, Mapping[str, Value]]
"""A component, and values of variables of it by name."""


@dataclass(frozen=True, eq=False)
class NetworkSnapshot:
    """A communication point to which a network can return; the FMUs keep their states in `place`.

    `values`, `inputs` and those that are not Real (`discrete`) are copies of the network's, `loops`
    the starting points of its algebraic loops, `roughness` how well they were solved; `scenario` is
    what its actions know.
    """

    place: int
    time: float
    last: float
    values: np.ndarray
    inputs: np.ndarray
    discrete: Kept
    loops: tuple[Snapshot, ...]
    roughness: float
    scenario: ScenarioSnapshot


class Network:
    """Instances of a prepared system, in listing order, with the values that pass between them.

    Exchanged are the Real outputs `outputs` and the connected Real inputs `targets`, ordered by
    component, so that those of one are consecutive (`output_slice`, `input_slice`); `links[k]`
    leads to `targets[k]`, which is there once for each of its links: they add up. `now`, `before`,
    `stepped`, `middle` and `earlier` are the starts of the blocks of `values`, which are in the
    units of the FMUs; `inputs[k]` is the value of the connected input `targets[k]` at the present
    point, in the unit of its source. Values that are not Real are in `discrete`.

    `time` is the present communication point [s]. `last` is the size [s] of the step that led there
    from the one before, 0 where nothing before it counts (at the start, after a jump); `size` that
    of the step being made, set by algorithms. `coarse` is the length of the steps being made over
    the simulation's step, which an algorithm must know when it is made.
    `roughness` is the largest share of an input's size by which it still misses its source where
    algebraic loops are solved. `left` are the values (n,) before the scenario's actions at this
    point, in the same units, if it has acted (None: it has not). `pause` is called between steps
    that are not part of the run, and raises to end them early.

    `execution_order` is the order in which a Gauss–Seidel algorithm steps the components;
    `has_loops` is True if algebraic loops are solved at each communication point. `rates` are the
    steps of the components that have their own, `sampled` those that are controllers by nature:
    their outputs are discrete. `telling` can tell of events and of the end (FMI 3.0).
    `monitored_outputs` are those by which the coupling error is measured, each with the index of a
    connection: the sources of all links, and the outputs of components without connected outputs.
    """

    def __init__(
        self,
        prepared: Prepared,
        instances: Mapping[str, Instance],
        *,
        recorded: Mapping[str, Collection[str]],
        watched: bool = False,
    ) -> None:
        """`recorded` are the outputs by component that results will have.

        Those that are not exchanged are read too, and all others if they are `watched`.
        """
        self.instances = dict(instances)
        self._descriptions = descriptions = prepared.descriptions
        self._wiring, self._structure = wiring, structure = prepared.wiring, prepared.structure
        exchange = structure.exchange
        self.execution_order, self.has_loops = structure.execution_order, bool(structure.loops)
        self.outputs = _ports(exchange, "get", descriptions)
        carried = set(wiring.links)
        inputs = _ports(exchange, "set", descriptions)
        self.links = [k for port in inputs for k in wiring.into[port] if k in carried]
        self.targets = [link.target for link in self.links]
        into = {link.target.component: link.connection for link in reversed(wiring.links)}
        self.monitored_outputs = (
            *((link.connection, link.source) for link in self.links),
            *((into[port.component], port) for port in structure.ends),
        )
        size = len(self.outputs)
        self.now, self.before, self.stepped, self.middle, self.earlier = (
            k * size for k in range(BLOCKS)
        )
        self.rates = prepared.rates
        self.sampled = frozenset(n for n, rate in self.rates.items() if rate.is_longer) - {
            *prepared.longer
        }
        self._origin = prepared.system.simulation.start_ns
        self._index = {port: k for k, port in enumerate(self.outputs)}
        self._place = {link.ends: k for k, link in enumerate(self.links)}
        self._output_ranges, self._input_ranges = _ranges(self.outputs), _ranges(self.targets)
        self._apart = [one for name, one in instances.items() if name in prepared.hosts]
        self.telling = tuple(i for i in instances.values() if i.description.version == "3.0")
        self._events = tuple(instance.events for instance in instances.values())
        self._set_scales()
        self.scenario = Scenario(prepared, self.instances, self._present, self.read)
        self._points: WeakSet[NetworkSnapshot] = WeakSet()
        self.time = prepared.system.simulation.start_time
        self.coarse = 1.0
        self.pause: Callable[[], None] = lambda: None
        self.last = self.size = 0.0
        self.left: np.ndarray | None = None
        self.roughness = 0.0
        self.inputs = np.zeros(len(self.targets))
        recorded = self.scenario.with_watched(recorded)
        self._arrivals = Arrivals(descriptions, exchange, recorded, watched=watched)
        typed = {link.target: link for link in wiring.links if not link.is_real}
        self.discrete = Discrete(self.instances, exchange, typed, Texts(), self._arrivals)
        first_seen = BLOCKS * size
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

    def _set_scales(self) -> None:
        """Have inputs take the values of their sources in their own units."""
        once = set(self._wiring.initial_links)
        for links in self._wiring.into.values():
            scales = self.instances[links[0].target.component].scales
            mixed = not (once.isdisjoint(links) or once.issuperset(links))
            for link in links:
                if link.is_real and not link.is_plain:
                    scales.set(link.ends, link.factor, link.offset)
                if mixed:
                    scales.follow(link.ends)

    # ---- places of exchanged variables ----

    def due(self, component: str) -> Due | None:
        """The times of the component's points; None if it has one at every communication point."""
        rate = self.rates.get(component)
        if rate is None or not rate.is_longer:
            return None
        return Due(self._origin, rate.step_ns)

    def index(self, output: Port) -> int:
        """Place of an output in a block of `values`."""
        return self._index[output]

    def place(self, link: Link) -> int:
        """Place in `inputs` of the value that a link carries."""
        return self._place[link.ends]

    def links_to(self, component: str) -> list[Link]:
        """The links to a component's Real inputs, in the order of their places."""
        return self.links[self.input_slice(component)]

    def held_place(self, link: Link) -> int | None:
        """Place in `values` of the value that a delayed link carries all through a step."""
        return self.before + self.index(link.source) if link.delayed else None

    def _present(self, link: Link) -> int:
        """Place in `values` of the value that a link carries to the present point."""
        held = self.held_place(link)
        return self.index(link.source) if held is None else held

    def derivatives(self, output: Port) -> list[Port]:
        """The output itself and its declared first and second time derivative, if there are."""
        return output.derivatives(self._descriptions)

    def output_slice(self, component: str) -> slice:
        """Places of a component's outputs in a block of `values`."""
        return self._output_ranges.get(component, slice(0, 0))

    def input_slice(self, component: str) -> slice:
        """Places in `inputs` of the values of the links to a component."""
        return self._input_ranges.get(component, slice(0, 0))

    def early(self, component: str) -> slice:
        """Places of the exchanged outputs that a component gives before its inputs are set."""
        start = self.output_slice(component).start
        return slice(start, start + len(self._arrivals.early(component)))

    def recorded(self, component: str) -> tuple[str, ...]:
        """Outputs that are not exchanged, but read for results before any input is set."""
        return self._arrivals.further(component)[0]

    def moved(self, component: str) -> dict[str, str]:
        """Inputs that a component moves along others, their rates, each carried by one link."""
        names = [link.target.variable for link in self.links_to(component)]
        rates = self._descriptions[component].input_derivatives
        return {w: u for w, u in rates.items() if names.count(w) == names.count(u) == 1}

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

    # ---- values at the present point ----

    def read(self, name: str) -> Any:
        """The present value of ``component.variable``, exchanged or not, in its own type.

        UnknownNameError, a KeyError, for an unknown name.
        """
        port = Port.named(name)
        description = self._descriptions.get(port.component)
        if description is None or port.variable not in description.variables:
            known = [f"{c}.{v}" for c, d in self._descriptions.items() for v in d.variables]
            raise UnknownNameError.of("no variable is called", [name], known)
        place = self.known(port)
        if place is not None:
            return float(self.values[place])
        cell = self.discrete.known(port)
        if cell is not None:
            return self.discrete.value(port, cell)
        return self.instances[port.component].values([port.variable])[0]

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

    @property
    def is_over(self) -> bool:
        """True if an FMU has asked for the end of the simulation."""
        return min(map(_ENDED, self._events)) < math.inf

    @property
    def ended(self) -> str:
        """Which FMUs have asked for the end of the simulation, and when; empty if none has."""
        return "; ".join(
            f"{i.name} requested the end of the simulation at t = {i.events.ended:.9g} s"
            for i in self.instances.values()
            if i.has_ended
        )

    @property
    def lost(self) -> dict[str, list[str]]:
        """Outputs by component that setting inputs to the values that they have has changed."""
        found = {n: [o for one in self.rereadings(n) for o in one.lost] for n in self.instances}
        return {name: sorted(outputs) for name, outputs in found.items() if outputs}

    @property
    def late(self) -> dict[str, list[str]]:
        """Links and outputs that bring their values a step late, by the reason."""
        delayed = [str(link) for link in self.links if link.delayed]
        sources = (link.source for link in self.links)
        stepped = dict.fromkeys(
            str(port)
            for port in sources
            if how_known(self._descriptions[port.component], port.variable) == STEPPED
        )
        return {
            "has the value of the previous step": delayed,
            "shows its FMU's inputs only after the next step": list(stepped),
        }

    # ---- operations of one component ----

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

    def rereadings(self, component: str) -> list[Rereading]:
        """Outputs of a component that are read twice: Reals, and others."""
        both = self._rereadings, self.discrete.rereadings
        return [found[component] for found in both if component in found]

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

    # ---- communication points ----

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
        acted = self.scenario.act(self.time, self.values)
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
        instances = self.instances.values()
        over = [i for i in instances if i.has_ended and i.description.version == "2.0"]
        for part in self._exchange:
            if isinstance(part, SolvedLoop):
                part.run(self.time)
                self.roughness = max(self.roughness, part.equations.roughness)
            else:
                (part.without_sets(over) if over else part).run(self.time)

    @property
    def stops(self) -> np.ndarray:
        """One value (1,) [1] that a change makes finite, to stop steps that are made at once.

        Empty where all values are Real.
        """
        return self.discrete.changed if self.discrete else np.zeros(0)

    @property
    def operations(self) -> tuple[Operation, ...] | None:
        """The operations of `advance`; None with a scenario, or where loops are solved."""
        parts = [part for part in self._exchange if isinstance(part, Schedule)]
        if self.scenario or len(parts) < len(self._exchange):
            return None
        return tuple(o for part in (self._shift, *parts) for o in part.operations)

    # ---- states ----

    def snapshot(self, place: int) -> NetworkSnapshot:
        """The present point, instead of the one kept before in the same place."""
        for instance in self.instances.values():
            instance.save_state(place)
        loops = tuple(part.snapshot() for part in self._loops)
        copies = self.values.copy(), self.inputs.copy(), self.discrete.snapshot()
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
        self.discrete.restore(point.discrete)
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

    # ---- the start ----

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
            yield self._solved(transfer)
        for component in self.instances:
            for reading in self._unexchanged(component, self._arrivals.late(component)):
                operations += self.read_late(component, reading)
            operations += self.discrete.seen(component, self.due(component))
        yield Schedule(operations)

    def _solved(self, loop: AlgebraicLoop) -> SolvedLoop:
        """An algebraic loop within the exchange."""
        equations = LoopEquations(self.instances, loop, self.links)
        readings = [
            (transfer, one.part(transfer.variables))
            for transfer in loop.gets
            for one in self.rereadings(transfer.component)[:1]
            if transfer.variables[0] in one.names
        ]
        return SolvedLoop(
            equations,
            self.values,
            self.inputs,
            outputs=[self.index(port) for port in equations.outputs],
            into=[self.place(link) for link in equations.links],
            known={link: self._present(link) for link in equations.known},
            readings=readings,
        )

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
            gather(view, self.values, list(map(self._present, links))),
            *setting(instance, links, view),
        )

    def __repr__(self) -> str:
        title = f"Network at t = {self.time:.9g} s"
        return listing(title, components=self.instances, inputs=[str(p) for p in self.targets])


def _ports(exchange: Exchange, action: str, components: Iterable[str]) -> list[Port]:
    """All Real variables of the transfers of one kind, by component and within it by call."""
    found: dict[str, list[Port]] = {component: [] for component in components}
    for transfer in transfers_of(exchange):
        if transfer.action == action and not transfer.discrete:
            found[transfer.component] += [Port(transfer.component, n) for n in transfer.variables]
    return [port for ports in found.values() for port in ports]


def _ranges(ports: Sequence[Port]) -> dict[str, slice]:
    """Component → its places among `ports`, which are consecutive."""
    found: dict[str, slice] = {}
    for k, port in enumerate(ports):
        first = found[port.component].start if port.component in found else k
        found[port.component] = slice(first, k + 1)
    return found
