"""Ports, the links between them, power bonds, and the wiring that they make together.

A bond has the forces among the links of a connection and the velocities that they work on. Several
sources of a force or moment, or of an element of an added-mass matrix, mean their sum.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.shown import short
from m4e_fmi.units import parse_unit

SAME_UNIT = 1e-9
"""Relative difference below which two conversion factors are the same."""
ELEMENT = re.compile(r"(.+)\[(\d+),(\d+)\]")
"""Name of an element of a matrix, its row and its column."""
Variables = Mapping[str, Mapping[str, Variable]]
"""Variables by component and name."""
AXES = (
    ("force_x", "vx", "x"),
    ("force_y", "vy", "y"),
    ("force_z", "vz", "z"),
    ("moment_x", "omega_x", ""),
    ("moment_y", "omega", "theta"),
    ("moment_z", "omega_z", ""),
    *((f"effort{k}", f"u{k}", f"q{k}") for k in ("", 1, 2, 3)),
)
"""Force, the velocity it works on, and the coordinate of that velocity, in one connector.

Efforts are those of joints. Angular velocities of bodies in space are not the rates of any angles.
"""
_FORCES = {force for force, _, _ in AXES}
LOADS = tuple(map(parse_unit, ("N", "N.m")))
MATRIX = "added_mass"


@dataclass(frozen=True, order=True)
class Port:
    """A variable of a component."""

    component: str
    variable: str

    @classmethod
    def named(cls, text: str) -> Port:
        """The port ``component.variable``."""
        component, _, variable = text.partition(".")
        return cls(component, variable)

    @property
    def connector(self) -> Port:
        """The connector that it is of: its name before the last dot."""
        return Port(self.component, self.variable.rpartition(".")[0])

    def derivatives(self, descriptions: Mapping[str, Description]) -> list[Port]:
        """The output itself and, if its FMU declares them, its first and second derivative."""
        declared = descriptions[self.component].output_derivatives
        chain: list[Port] = [self]
        while len(chain) < 3 and chain[-1].variable in declared:
            chain.append(Port(self.component, declared[chain[-1].variable]))
        return chain

    def __str__(self) -> str:
        return f"{self.component}.{self.variable}"


@dataclass(frozen=True)
class Link:
    """`target` takes `factor` · the value of `source` + `offset`.

    Both include the conversion between the units of the two FMUs. `connection` is the index of the
    connection's text, `kind` the type of the source. A `delayed` link carries the value that its
    source had one communication point before, to a communication point and through the step from
    there.
    """

    source: Port
    target: Port
    connection: int
    factor: float = 1.0
    offset: float = 0.0
    delayed: bool = False
    kind: str = REAL

    @property
    def ends(self) -> Ends:
        """Source and target."""
        return self.source, self.target

    @property
    def is_real(self) -> bool:
        """True if it carries a Real; other values are exchanged at communication points only."""
        return self.kind == REAL

    @property
    def is_plain(self) -> bool:
        """True if the value is carried over without conversion."""
        return self.factor == 1.0 and self.offset == 0.0

    def variables(self, known: Variables) -> tuple[Variable, Variable]:
        """The variables of source and target."""
        source, target = self.ends
        return known[source.component][source.variable], known[target.component][target.variable]

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


Ends = tuple[Port, Port]
"""Source and target of a link, by which it is known while its factor and offset change."""
PLAIN = 1.0, -0.0
"""Factor and offset that leave every value as it is, to the last bit."""


class InputScales:
    """Factor and offset of links whose inputs get factor·v + offset, v in their sources' units.

    A link is known by its ends. Those that are to be followed may change: operations that use them
    change with them.
    """

    def __init__(self) -> None:
        self._of: dict[Ends, tuple[float, float]] = {}
        self._added: dict[Ends, float] = {}
        self._followed: set[Ends] = set()
        self._uses: list[tuple[list[Ends], np.ndarray, np.ndarray | None]] = []

    def set(self, link: Ends, factor: float, offset: float) -> None:
        """From now on, a link gives factor·v + offset, in its input's unit."""
        self._of[link] = factor, offset + self._added.get(link, 0.0)
        for links, factors, offsets in self._uses:
            for k, used in enumerate(links):
                if used == link:
                    factors[k] = factor
                    if offsets is not None:
                        offsets[k] = self._of[link][1]

    def add(self, link: Ends, amount: float) -> None:
        """From now on, a link that is followed gives an `amount` more, in its input's unit."""
        factor, offset = self._of[link]
        self._added[link] = amount
        self.set(link, factor, offset)

    def follow(self, link: Ends) -> None:
        """The factor and the offset of a link are going to change: before they are used."""
        self._of.setdefault(link, PLAIN)
        self._followed.add(link)

    def factor(self, link: Ends) -> float:
        """The factor of a link, in its input's unit over its source's."""
        return self._of.get(link, PLAIN)[0]

    def of(self, links: Sequence[Ends]) -> tuple[np.ndarray, np.ndarray] | None:
        """Factors and offsets (n_links,), in the inputs' over the sources' units; None if plain."""
        if self._of.keys().isdisjoint(links):
            return None
        pairs = np.array([self._of.get(link, PLAIN) for link in links])
        factors, offsets = pairs[:, 0].copy(), pairs[:, 1].copy()
        self._use(links, factors, offsets)
        return factors, offsets

    def of_derivatives(self, links: Sequence[Ends]) -> np.ndarray | None:
        """Factors (n_links,) of a time derivative of each, as `of` has them, in the same units."""
        if self._of.keys().isdisjoint(links):
            return None
        factors = np.array([self.factor(link) for link in links])
        self._use(links, factors, None)
        return factors

    def _use(self, links: Sequence[Ends], factors: np.ndarray, offsets: np.ndarray | None) -> None:
        if not self._followed.isdisjoint(links):
            self._uses.append((list(links), factors, offsets))


@dataclass(frozen=True)
class BondAxis:
    """One direction of a power bond: `force` works on `velocity`, the rate of `position`.

    `share` is the force on the body over the force of the source, both in SI units.
    """

    force: Link
    velocity: Link
    position: Link | None
    share: float = 1.0


@short
@dataclass(frozen=True)
class Bond:
    """A connection that carries power: forces on a body or joint, and velocities they work on.

    `adds` are the components whose forces its source adds up, if all its inputs are forces.
    """

    name: str
    axes: tuple[BondAxis, ...]
    adds: tuple[str, ...] = ()


@short
@dataclass(frozen=True)
class Wiring:
    """All connections of a system, resolved.

    `links` carry values at every communication point, into inputs and tunable parameters;
    `initial_links` carry them into parameters, once. What several carry into one adds up, of which
    `notes` tell. `unconnected` are the inputs without a link.
    """

    links: tuple[Link, ...]
    initial_links: tuple[Link, ...]
    bonds: tuple[Bond, ...]
    unconnected: tuple[Port, ...]
    notes: tuple[str, ...] = ()

    @cached_property
    def into(self) -> dict[Port, tuple[Link, ...]]:
        """The links into each variable, which gets the sum of what they carry."""
        found: dict[Port, tuple[Link, ...]] = {}
        for link in self.all_links:
            found[link.target] = (*found.get(link.target, ()), link)
        return found

    @property
    def all_links(self) -> tuple[Link, ...]:
        """Those that carry values once, then those of every communication point."""
        return *self.initial_links, *self.links

    @property
    def sources(self) -> tuple[Port, ...]:
        """The outputs whose values are carried at every communication point."""
        return tuple(link.source for link in self.links)


def is_varying(give: Variable) -> bool:
    """True for an output that changes during a run."""
    return give.causality == "output" and give.variability != "constant"


def is_carried(give: Variable, take: Variable) -> bool:
    """True if values go over at every communication point; otherwise they do once, at the start."""
    return take.causality == "input" or (is_varying(give) and take.variability == "tunable")


def conversion(give: Variable, take: Variable) -> tuple[float, float]:
    """Factor and offset from the unit of one variable to that of another, of one dimension."""
    if give.dimension is None or take.dimension is None:
        return 1.0, 0.0
    factor = give.dimension.factor / take.dimension.factor
    shift = (give.offset - take.offset) / take.dimension.factor
    return (1.0 if abs(factor - 1) < SAME_UNIT else factor), shift


def power_bonds(
    connections: Sequence[str],
    variables: Variables,
    links: Sequence[Link],
) -> Iterable[Bond]:
    """The power bonds among the links, connection by connection.

    A force is one on a body or joint whose velocity, of the same connector, goes to any component:
    that of the force itself, or one whose force a third component adds to others.
    """
    carried = {link.source: link for link in links}
    found: dict[int, list[BondAxis]] = defaultdict(list)
    for force, velocity, position in AXES:
        for link in links:
            body, last = link.target.component, _last(link.target)
            connector = link.target.variable.removesuffix(last)
            back = carried.get(Port(body, connector + velocity))
            scale, shift = conversion(*link.variables(variables))
            if last == force and back and link.offset == link.factor / scale * shift:
                rate = Port(body, connector + velocity)
                moved = carried.get(Port(body, connector + position))
                # a body's angular velocity about Y that turns about X as well
                if velocity == "omega" and f"{rate.variable}_x" in variables[rate.component]:
                    moved = None
                found[link.connection].append(BondAxis(link, back, moved, link.factor / scale))
    for index, axes in sorted(found.items()):
        sources = {axis.force.source.component for axis in axes}
        given = [link for link in links if link.target.component in sources]
        adds = dict.fromkeys(link.source.component for link in given)
        if not all(_last(link.source) in _FORCES for link in given):
            adds = {}  # its inputs are not forces only: its output is not a mere sum
        yield Bond(connections[index], tuple(axes), tuple(adds))


def _last(port: Port) -> str:
    return port.variable.rpartition(".")[2]


def can_be_summed(give: Variable, take: Variable) -> bool:
    """True of Reals for inputs that are forces or moments, and elements of added-mass matrices."""
    if not give.type == take.type == REAL:
        return False
    matrix = ELEMENT.fullmatch(take.name)
    if matrix and matrix[1].rpartition(".")[2] == MATRIX:
        return True
    dimension = take.dimension
    is_load = dimension is not None and any(dimension.same_dimension(load) for load in LOADS)
    return take.causality == "input" and is_load


def summed(links: Iterable[Link], variables: Variables) -> list[list[list[Link]]]:
    """Groups of targets that take the sum of several links, each target with its links in order.

    Targets of a group are of one connector or matrix, and so are their sources, one by one, which
    all vary or not.
    """
    by_target: dict[Port, list[Link]] = {}
    for link in links:
        by_target.setdefault(link.target, []).append(link)
    groups: dict[tuple[object, ...], list[list[Link]]] = {}
    for target, several in by_target.items():
        if len(several) > 1:
            gives = [link.variables(variables)[0] for link in several]
            sources = tuple((base(k.source), k.connection) for k in several)
            key = base(target), sources, tuple(map(is_varying, gives))
            groups.setdefault(key, []).append(several)
    return list(groups.values())


def sum_note(group: Sequence[Sequence[Link]]) -> str:
    """A line on a group of sums."""
    first, last = group[0][0].target, group[-1][0].target
    into = base(first) if first != last else str(first)
    givers = dict.fromkeys(base(link.source) for several in group for link in several)
    return f"{into} takes the sum of {', '.join(givers)}"


def base(port: Port) -> str:
    """Component and connector of a variable; of an element of a matrix, the matrix."""
    if matrix := ELEMENT.fullmatch(port.variable):
        return f"{port.component}.{matrix[1]}"
    connector = port.connector
    return str(connector) if connector.variable else port.component
