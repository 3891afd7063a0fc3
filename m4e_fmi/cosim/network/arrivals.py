"""Outputs that are read straight after the last step of their component, before its inputs are set.

Some FMUs lose or change their outputs when inputs are set. An output that depends on no connected
input within an instant is read straight after the step only. One that does is read again when its
inputs are set. Of FMUs that were not built here both readings are taken (`Rereading`): no trial
before the run can tell which outputs are lost, as the loss may begin at any time. So straight after
the step the outputs are read, their inputs are set to the values that they have, and the outputs
are read again: one that has changed is lost (`Choose`).

Outputs of FMUs with event mode that are not exchanged are left out: setting a discrete input is an
event there, after which all outputs may have other values.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.cosim.network.operations import Choose, Gather, Get, GetTyped, gather
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.cosim.wiring.structure import Exchange, Transfer, transfers_of
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.type_rules import DISCRETE, REAL

Groups = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]
"""Reals that are recorded, other Reals, and outputs that are not Real."""
_NONE: Groups = ((), (), ())
ROWS = 6
"""Readings of an output: see `Choose`."""
Reading = Get | GetTyped
Read = Callable[[str, Sequence[str], np.ndarray], Reading]
"""Component, names, place (n_names,) → the operation that reads these, in their units or cells."""


class Arrivals:
    """Outputs that are read straight after steps: `early` ones, which are exchanged, and `further`.

    The latter are outputs of components with connected inputs that are not exchanged: those
    `recorded` (names by component), and all others if they are `watched`. `late` are outputs of
    FMUs not built here that are not exchanged either, but depend on connected inputs: they are read
    `twice`, as are those exchanged.
    """

    def __init__(
        self,
        descriptions: Mapping[str, Description],
        exchange: Exchange,
        recorded: Mapping[str, Collection[str]],
        *,
        watched: bool,
    ) -> None:
        self._early = _early(exchange)
        inputs, exchanged = _ports(exchange, "set"), _ports(exchange, "get")
        self._bound: dict[tuple[str, bool], tuple[str, ...]] = {}
        for one in transfers_of(exchange):
            if one.action == "get" and not (self.has(one) or descriptions[one.component].is_own):
                of_kind = one.component, one.discrete
                self._bound[of_kind] = (*self._bound.get(of_kind, ()), *one.variables)
        self._further: dict[str, Groups] = {}
        self._late: dict[str, Groups] = {}
        for component, driven in inputs.items():
            description, known = descriptions[component], exchanged.get(component, set())
            if description.has_events:
                continue
            kept = recorded.get(component, ())
            free, bound = list[str](), list[str]()
            for name, needs in description.dependencies.items():
                if name not in known and (name in kept or watched):
                    (bound if needs & driven else free).append(name)
            self._further[component] = _groups(description, free, kept)
            if not description.is_own:
                self._late[component] = _groups(description, bound, kept)

    def early(self, component: str) -> tuple[str, ...]:
        """The early outputs of a component that are exchanged."""
        transfer = self._early.get((component, False))
        return transfer.variables if transfer else ()

    def early_typed(self, component: str) -> Transfer | None:
        """The transfer that reads the early outputs that are not Real."""
        return self._early.get((component, True))

    def further(self, component: str) -> Groups:
        """Outputs of a component that are not exchanged and depend on no connected input."""
        return self._further.get(component, _NONE)

    def late(self, component: str) -> Groups:
        """Those that depend on connected inputs, of an FMU not built here."""
        return self._late.get(component, _NONE)

    def twice(self, component: str, *, discrete: bool) -> tuple[str, ...]:
        """All outputs that depend on connected inputs, of an FMU not built here; Real or not."""
        recorded, watched, typed = self.late(component)
        further = typed if discrete else (*recorded, *watched)
        return *self._bound.get((component, discrete), ()), *further

    @property
    def ports(self) -> list[Port]:
        """All `further` outputs that are Real, component by component, then those that are late."""
        return [
            Port(component, name)
            for found in (self._further, self._late)
            for component, groups in found.items()
            for names in groups[:2]
            for name in names
        ]

    def has(self, transfer: Transfer) -> bool:
        """True if this part of the exchange reads the early outputs of a component."""
        return self._early.get((transfer.component, transfer.discrete)) is transfer


def _groups(description: Description, names: Sequence[str], kept: Collection[str]) -> Groups:
    kinds = [(name, description.variables[name].type) for name in names]
    return (
        tuple(name for name, kind in kinds if kind == REAL and name in kept),
        tuple(name for name, kind in kinds if kind == REAL and name not in kept),
        tuple(name for name, kind in kinds if kind in DISCRETE),
    )


def _early(exchange: Exchange) -> dict[tuple[str, bool], Transfer]:
    """The reads of each component before its inputs are set, by component and discreteness."""
    found: dict[tuple[str, bool], Transfer] = {}
    begun: set[tuple[str, bool]] = set()
    for part in exchange:
        for transfer in transfers_of((part,)):
            of_kind = transfer.component, transfer.discrete
            if of_kind not in begun and part is transfer and transfer.action == "get":
                found[of_kind] = transfer
            both = transfer.action == "set" or part is not transfer
            begun |= {(transfer.component, kind) for kind in (False, True)} if both else {of_kind}
    return found


def _ports(exchange: Exchange, action: str) -> dict[str, set[str]]:
    """Names of the variables that are got or set, by component."""
    found: dict[str, set[str]] = {}
    for transfer in transfers_of(exchange):
        if transfer.action == action:
            found.setdefault(transfer.component, set()).update(transfer.variables)
    return found


def following(description: Description, changed: Collection[str]) -> Callable[[str], bool]:
    """A test of output names: True if setting the variables `changed` may change it at once.

    A parameter may change all outputs, and so may an event (setting a variable in event mode).
    """
    causalities = {description.variables[name].causality for name in changed}
    if causalities - {"input"} or description.has_events:
        return lambda _: True
    return lambda name: not description.dependencies[name].isdisjoint(changed)


NO_ARRIVALS = Arrivals({}, (), {}, watched=False)


@dataclass(frozen=True)
class Rereading:
    """Outputs `names` of a component, with their readings in `block` (6, n), in their units.

    `kept` keeps what was read last, `first` then reads all straight after a step, and `second` when
    inputs are set to the values that they have.
    """

    names: tuple[str, ...]
    block: np.ndarray
    kept: Gather
    first: Reading
    second: Reading

    def new(
        self, reading: Reading, changed: np.ndarray | None = None
    ) -> tuple[Reading | Choose, ...]:
        """A `reading` of consecutive ones with new inputs, and the choice of what counts instead.

        `changed` (1,) [1] is that of `Choose`.
        """
        block = self.part(reading.names)
        made = reading.instance, reading.names, reading.into, block, changed, reading.due
        if isinstance(reading, GetTyped):
            return replace(reading, into=block[3]), Choose(*made)
        return replace(reading, into=block[3], checked=False), Choose(*made, reading.checked)

    def part(self, names: Sequence[str]) -> np.ndarray:
        """The readings (6, n_names) of consecutive ones, in their units."""
        start = self.names.index(names[0])
        return self.block[:, start : start + len(names)]

    @property
    def lost(self) -> list[str]:
        """The outputs that were lost in at least one step."""
        return [name for name, lost in zip(self.names, self.block[-1], strict=True) if lost]


def rereadings(
    names: Mapping[str, tuple[str, ...]], room: np.ndarray, read: Read
) -> dict[str, Rereading]:
    """Those of each component that has outputs among `names`.

    Their readings are in `room` (6*n_names,), in the outputs' units; `read` makes operations that
    read some (n,) of them, in these units.
    """
    found: dict[str, Rereading] = {}
    for component, own in names.items():
        if own:
            block, room = np.split(room, [ROWS * len(own)])
            block = block.reshape(ROWS, -1)
            kept = gather(block[2], block[3], range(len(own)))
            both = (read(component, own, row) for row in block[:2])
            found[component] = Rereading(own, block, kept, *both)
    return found
