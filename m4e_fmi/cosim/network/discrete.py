"""Values that pass between components and are not Real: Integers, Booleans, enumerations, Strings.

They are exchanged at communication points, along declared dependencies as Reals are, and held in
between. So algorithms need not know them: an FMU that goes back to the start of a step has the
inputs of that point again. A value that changes is a jump: no step uses values from before it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.network.arrivals import (
    NO_ARRIVALS,
    ROWS,
    Arrivals,
    Rereading,
    rereadings,
)
from m4e_fmi.cosim.network.instance import Instance
from m4e_fmi.cosim.network.operations import Due, Gather, GetTyped, SetTyped, Transferring, gather
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.wiring.links import Link, Port
from m4e_fmi.cosim.wiring.structure import AlgebraicLoop, Transfer
from m4e_fmi.fmu.importer.calls import Access, Taken, Texts, value_in
from m4e_fmi.fmu.importer.type_rules import bounds, is_large

Kept = tuple[np.ndarray, np.ndarray, tuple[Port, ...]]
"""The cells of a point, those of the last settled one, and changes that act a step late."""


class Discrete:
    """The outputs among `steps` that are not Real, and what takes their values by `links`.

    `values` has a cell (see `calls.access`) for each of `outputs`, as it is at the present
    communication point; texts have their places in `texts`. `changed` is 0 from where one changes
    until `settle`, infinite otherwise. After the `values` in `cells` come outputs that are not
    exchanged, but read with them (see `arrivals`); the exchanged values at the point before, where
    connections are delayed; those at the last settled point; those that inputs were set by
    last; the readings of outputs that are read twice.
    """

    def __init__(
        self,
        instances: Mapping[str, Instance],
        steps: Sequence[Transfer | AlgebraicLoop],
        links: Mapping[Port, Link],
        texts: Texts,
        arrivals: Arrivals = NO_ARRIVALS,
    ) -> None:
        self._instances, self._links, self.texts = instances, links, texts
        self._arrivals = arrivals
        transfers = [t for t in steps if isinstance(t, Transfer) and t.discrete]
        self.outputs = [
            Port(t.component, name) for t in transfers if t.action == "get" for name in t.variables
        ]
        seen = {c: arrivals.further(c)[2] for c in instances}
        self._seen_late = {c: arrivals.late(c)[2] for c in instances}
        ports = list(self.outputs)
        for found in (seen, self._seen_late):
            ports += [Port(c, name) for c, names in found.items() for name in names]
        self._index = {port: k for k, port in enumerate(ports)}
        count = len(self.outputs)
        self.changed = np.array([np.inf])
        self._delayed = {k.source for k in links.values() if k.delayed and k.source in self._index}
        self._late = len(ports)
        twice = {c: arrivals.twice(c, discrete=True) for c in instances}
        settled = self._late + (count if self._delayed else 0)
        noted = readings = settled + count
        self._accesses = {transfer: self._access(transfer) for transfer in transfers}
        self._held: dict[Transfer, tuple[range, Access]] = {}
        for one in transfers:
            if one.action == "set":
                places = range(readings, readings + len(one.variables))
                self._held[one] = places, self._access(one, places)
                readings = places.stop
        size = readings + ROWS * sum(map(len, twice.values()))
        self.cells = np.zeros(size, dtype=np.int64)
        self.values, self._before = self.cells[:count], self.cells[settled:noted]
        self._echo: list[Port] = []
        self._seen = {c: instances[c].typed(names, texts) for c, names in seen.items() if names}
        self.rereadings = rereadings(twice, self.cells[readings:], self._reading)

    def __bool__(self) -> bool:
        """True if there are values to exchange."""
        return bool(self.outputs)

    def _reading(self, component: str, names: Sequence[str], into: np.ndarray) -> GetTyped:
        instance = self._instances[component]
        return GetTyped(instance, instance.typed(names, self.texts), into)

    def held(self, component: str) -> list[SetTyped]:
        """Sets the inputs of a component to the values that they were set to last."""
        return [
            SetTyped(self._instances[component], access, self.cells)
            for transfer, (_, access) in self._held.items()
            if transfer.component == component
        ]

    def _sources(self, transfer: Transfer) -> list[Link]:
        return [self._links[Port(transfer.component, name)] for name in transfer.variables]

    def _places(self, transfer: Transfer) -> list[int]:
        """Where in `cells` inputs find their values at a communication point."""
        return [
            self._index[k.source] + (self._late if k.delayed else 0)
            for k in self._sources(transfer)
        ]

    def _access(self, transfer: Transfer, places: Sequence[int] = ()) -> Access:
        """The variables of a transfer; inputs are set from `places`, or those of their sources."""
        instance, names = self._instances[transfer.component], transfer.variables
        if transfer.action == "get":
            return instance.typed(names, self.texts, changed=self.changed)
        each = zip(self._sources(transfer), places or self._places(transfer), strict=True)
        return instance.typed(names, self.texts, taken=[self._taken(*one) for one in each])

    def _taken(self, link: Link, place: int) -> Taken:
        give, take = (
            self._instances[port.component].description.variables[port.variable]
            for port in link.ends
        )
        low, high = bounds(give, take)
        origin, way = str(link.source), (link.factor, link.offset)
        return Taken(place, origin, low, high, *way, is_large(give))

    def _cells(self, transfer: Transfer) -> np.ndarray:
        """Of a transfer that gets values, its own cells; all for one that sets some."""
        if transfer.action == "set":
            return self.cells
        start = self._index[Port(transfer.component, transfer.variables[0])]
        return self.values[start : start + len(transfer.variables)]

    def operations(self, transfer: Transfer) -> tuple[Transferring, ...]:
        """The operations of a transfer at a communication point."""
        instance, access = self._instances[transfer.component], self._accesses[transfer]
        if transfer.action == "set":
            setting = SetTyped(instance, access, self._cells(transfer))
            noted, _ = self._held[transfer]
            into = self.cells[noted.start : noted.stop]
            return setting, gather(into, self.cells, self._places(transfer))
        reading, twice = GetTyped(instance, access, self._cells(transfer)), self._twice(transfer)
        return twice.new(reading, self.changed) if twice else (reading,)

    def _twice(self, transfer: Transfer) -> Rereading | None:
        """The outputs that a transfer reads, if they are read twice."""
        found = self.rereadings.get(transfer.component)
        return found if found and transfer.variables[0] in found.names else None

    def seen(self, component: str, due: Due | None) -> tuple[Transferring, ...]:
        """Reads outputs that depend on inputs and are not exchanged, when these are all set."""
        names = self._seen_late[component]
        if not names:
            return ()
        start = self._index[Port(component, names[0])]
        reading = self._reading(component, names, self.cells[start : start + len(names)])
        return self.rereadings[component].new(replace(reading, due=due))

    def arrival(self, component: str, due: Due | None) -> list[GetTyped]:
        """Reads what a component gives before its inputs are set; to follow its last step."""
        early = self._arrivals.early_typed(component)
        found = [replace(o, due=due) for o in self.operations(early)] if early else []
        if component in self._seen:
            access = self._seen[component]
            start = self._index[Port(component, access.names[0])]
            cells = self.cells[start : start + len(access.names)]
            found.append(GetTyped(self._instances[component], access, cells, due, in_rows=True))
        return [one for one in found if isinstance(one, GetTyped)]

    @property
    def takers(self) -> frozenset[str]:
        """The components that take any of the outputs."""
        outputs = frozenset(self.outputs)
        return frozenset(k.target.component for k in self._links.values() if k.source in outputs)

    def known(self, port: Port) -> int | None:
        """Where in `cells` the present value of an output is; None if only its FMU can tell it."""
        if self._instances[port.component].description.has_events:
            return None
        return self._index.get(port)

    def value(self, port: Port, cell: int) -> int | bool | str:
        """The value in a cell of a port."""
        variable = self._instances[port.component].description.variables[port.variable]
        return value_in(int(self.cells[cell]), variable, self.texts)

    def perform(self, transfer: Transfer) -> None:
        """Perform a transfer now; RunError as of a schedule."""
        Schedule(self.operations(transfer)).run(self._instances[transfer.component].time)

    def settle(self) -> list[Port]:
        """The outputs whose values have changed since the last call, or before it and act late."""
        found: list[Port] = []
        if not self.changed[0]:
            self.changed[0] = np.inf
            places = np.flatnonzero(self.values != self._before)
            self._before[:] = self.values
            found = [self.outputs[k] for k in places]
        late, self._echo = self._echo, [port for port in found if port in self._delayed]
        return [*found, *(port for port in late if port not in found)]

    @property
    def shift(self) -> tuple[Gather, ...]:
        """Makes the values at the last point those of the point before; where they are wanted."""
        if not self._delayed:
            return ()
        count = len(self.outputs)
        return (gather(self.cells[self._late :][:count], self._before, range(count)),)

    def begin(self, initial: Discrete) -> None:
        """Let delayed connections carry what their sources had in initialization mode."""
        for port in self._delayed:
            self.cells[self._late + self._index[port]] = initial.values[initial._index[port]]

    def snapshot(self) -> Kept:
        """Cells (n_cells,) in their units, those of the last settled point, and late changes."""
        return self.cells.copy(), self._before.copy(), tuple(self._echo)

    def restore(self, kept: Kept) -> None:
        """Return to `kept`, cells (n_cells,) in the outputs' units; the FMUs have them already."""
        cells, before, echo = kept
        self.cells[:], self._before[:], self._echo = cells, before, list(echo)
        self.changed[0] = 0.0 if (self.values != self._before).any() else np.inf

    def differs(self, values: np.ndarray) -> bool:
        """True if the FMUs now give others than `values` (n_outputs,), cells in their units."""
        if not self:
            return False
        present, noted = self.values.copy(), self.changed.copy()
        for transfer in self._accesses:
            if twice := self._twice(transfer):
                self._cells(transfer)[:] = twice.part(transfer.variables)[0]
            elif transfer.action == "get" and not self._arrivals.has(transfer):
                self.perform(transfer)
        found = bool((self.values != values).any())
        self.values[:], self.changed[:] = present, noted
        return found
