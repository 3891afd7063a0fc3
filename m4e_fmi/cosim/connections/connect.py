"""From connection texts to pairs of FMU variables, with every check that needs no running FMU.

``a.group <-> b.group`` connects connectors. A group is the part of a variable's name before its
last dot; the word written may be the whole group or its last parts, if that is unique. Members
whose last segments are equal and of which one is an output, the other an input, are connected, both
ways. So is a calculated parameter with a parameter, unless that has a start value or is connected
by ``->``.

``a.variable -> b.variable`` connects one variable, or all elements of an array given by its base
name; `connection` tells how a factor and an offset are written. A calculated parameter is carried
over into a parameter once, at initialisation. An output may lead into a tunable parameter, and is
then carried at every communication point, as into an input (`is_carried`); into a fixed one it may
not. Values are converted where units differ; `type_rules` tells which types fit.

A bus of the system (`bus`) may stand on either side, its signals as a component's variables. Its
name alone is the connector of all its signals that have no dot.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from m4e_fmi.cosim.connections.buses import (
    BUS,
    BusSignal,
    bus_problems,
    bus_variables,
    through_buses,
)
from m4e_fmi.cosim.connections.dependence import dependency_problems
from m4e_fmi.cosim.connections.neutral_mass import unset_masses
from m4e_fmi.cosim.system.connection_text import Connection, parse_connection, unknown_component
from m4e_fmi.cosim.system.start_values import start_problems
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import REAL, misfit
from m4e_fmi.shown import short

AXES = (("force_x", "vx", "x"), ("force_z", "vz", "z"), ("moment_y", "omega", "theta"))
"""Force, the velocity it works on, and the coordinate of that velocity, in one connector."""
CONSTANT_TO_INPUT = ("calculatedParameter", "input")
CARRIED_ONCE = "a calculated parameter is carried over once: connect it to a parameter"
SAME_UNIT = 1e-9
"""Relative difference of two factors that say the same in other digits."""


@dataclass(frozen=True, order=True)
class Port:
    """A variable of a component."""

    component: str
    variable: str

    def __str__(self) -> str:
        return f"{self.component}.{self.variable}"


@dataclass(frozen=True)
class Link:
    """`target` takes `factor` · the value of `source` + `offset`.

    Both include the conversion between the units of the two FMUs. `connection` is the index of the
    text that the link comes from, `kind` the type of the source. One that is `delayed` carries the
    value that its source had one communication point before, to a communication point and through
    the step from there.
    """

    source: Port
    target: Port
    connection: int
    factor: float = 1.0
    offset: float = 0.0
    delayed: bool = False
    kind: str = REAL

    @property
    def ends(self) -> tuple[Port, Port]:
        """Source and target."""
        return self.source, self.target

    @property
    def is_real(self) -> bool:
        """True if it carries a Real; other values are exchanged at communication points only."""
        return self.kind == REAL

    @property
    def is_plain(self) -> bool:
        """Whether the value is carried over as it is."""
        return self.factor == 1.0 and self.offset == 0.0

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


@dataclass(frozen=True)
class Axis:
    """One direction of a power bond: `force` works on `velocity`, the rate of `position`.

    `share` is what the body takes of the force that the source gives, both in SI.
    """

    force: Link
    velocity: Link
    position: Link | None
    share: float = 1.0


@short
@dataclass(frozen=True)
class Bond:
    """A connection that carries power: forces on a body, and the velocities they work on.

    `adds` are the components whose forces its source adds up, if it is given nothing but forces.
    """

    name: str
    axes: tuple[Axis, ...]
    adds: tuple[str, ...] = ()


@short
@dataclass(frozen=True)
class Wiring:
    """All connections of a system, resolved.

    `links` carry values at every communication point, into inputs and tunable parameters;
    `initial_links` carry them into parameters, once.
    `signals` are those of all buses.
    """

    links: tuple[Link, ...]
    initial_links: tuple[Link, ...]
    bonds: tuple[Bond, ...]
    unconnected: tuple[Port, ...]
    signals: tuple[BusSignal, ...] = ()

    @property
    def sources(self) -> tuple[Port, ...]:
        """The outputs whose values are carried at every communication point."""
        return tuple(link.source for link in self.links)


def connect(system: System, descriptions: Mapping[str, Description]) -> Wiring:
    """The wiring of `system`, whose components' FMUs say `descriptions`.

    InputError with all problems found, each at its connection's place.
    """
    problems: list[Problem] = []
    resolved = _resolved(system, descriptions, dict(enumerate(system.connections)), problems)
    if problems:
        raise InputError(problems)
    links, signals, variables = resolved

    def is_steady(link: Link) -> bool:
        return is_carried(*(descriptions[p.component].variables[p.variable] for p in link.ends))

    steady = tuple(filter(is_steady, links))
    driven = {link.target for link in steady}
    inputs = [Port(c, v.name) for c, d in descriptions.items() for v in d.of_causality("input")]
    return Wiring(
        links=steady,
        initial_links=tuple(link for link in links if not is_steady(link)),
        bonds=tuple(_bonds(system, variables, [link for link in steady if link.is_real])),
        unconnected=tuple(port for port in inputs if port not in driven),
        signals=tuple(signals),
    )


def connection_problems(
    system: System, descriptions: Mapping[str, Description], wrong: Collection[str] = ()
) -> list[Problem]:
    """All problems of connections, start values, and of the system's inputs and outputs.

    Components without a description, and those named in `wrong`, are not looked at. Of a connection
    with one of them the other end is looked at alone. Empty connections are passed over.
    """
    unknown = {*wrong, *(c.name for c in system.components)} - {*descriptions}

    def is_unknown(text: str) -> bool:
        return text.partition(".")[0] in unknown

    problems: list[Problem] = []
    whole: dict[int, str] = {}
    for index, text in enumerate(system.connections):
        if not (ends := _ends(text)) or not any(map(is_unknown, ends)):
            whole[index] = text
            continue
        variables = _variables(system, descriptions)
        for end in ends:
            if not is_unknown(end):
                _Connection(system, variables, index, text, problems).look_at(end)
    part = replace(
        system,
        components=tuple(c for c in system.components if c.name in descriptions),
        inputs={
            name: tuple(text for text in texts if not is_unknown(text))
            for name, texts in system.inputs.items()
        },
        outputs={name: text for name, text in system.outputs.items() if not is_unknown(text)},
    )
    _resolved(part, descriptions, {k: text for k, text in whole.items() if text}, problems)
    return problems


def _ends(text: str) -> tuple[str, ...]:
    """The two ends of a connection; none of a text that is no connection."""
    try:
        written = parse_connection(text)
    except ValueError:
        return ()
    return written.left, written.right


def _variables(
    system: System, descriptions: Mapping[str, Description]
) -> dict[str, Mapping[str, Variable]]:
    """The signals of the buses and the variables of the components, by name."""
    signals = bus_variables(system.buses)
    return {**signals, **{name: d.variables for name, d in descriptions.items()}}


def _resolved(
    system: System,
    descriptions: Mapping[str, Description],
    connections: Mapping[int, str],
    problems: list[Problem],
) -> tuple[list[Link], list[BusSignal], Mapping[str, Mapping[str, Variable]]]:
    """Links of the `connections`, given by index, signals of the buses, and all variables.

    Adds to `problems`.
    """
    problems += bus_problems(system)
    variables = _variables(system, descriptions)
    links: list[Link] = []
    for index, text in connections.items():
        links += _Connection(system, variables, index, text, problems).links()
    links = _one_source_each(system, _without_given(system, variables, links), problems)
    links, signals = through_buses(links, system.buses)
    links = [replace(k, kind=variables[k.source.component][k.source.variable].type) for k in links]
    problems += _through_problems(system, variables, links)
    problems += start_problems(system, descriptions)
    problems += dependency_problems(system, descriptions)
    problems += _delay_problems(system, variables, links)
    problems += _frozen_problems(system, variables, links)
    problems += _moved_problems(system, descriptions, links)
    driven = {link.target for link in links}
    problems += _outside_problems(system, descriptions, driven)
    if len(connections) == len(system.connections):
        problems += unset_masses(system, descriptions, {str(port) for port in driven})
    return links, signals, variables


class _Connection:
    """One connection text on its way to links; adds to `problems` what is wrong with it."""

    def __init__(
        self,
        system: System,
        variables: Mapping[str, Mapping[str, Variable]],
        index: int,
        text: str,
        problems: list[Problem],
    ) -> None:
        self._system = system
        self._variables_of = variables
        self._index = index
        self._text = text
        self._problems = problems

    def _reject(self, message: str, remedy: str = "") -> None:
        at = ("connections", self._index)
        self._problems.append(self._system.problem(at, message, remedy))

    def links(self) -> list[Link]:
        try:
            written = parse_connection(self._text)
        except ValueError as error:
            self._reject(*error.args)
            return []
        both_ways = written.both_ways
        left, right = (self._end(text, both_ways) for text in (written.left, written.right))
        if left is None or right is None:
            return []
        pairs = self._groups(left, right) if written.both_ways else self._variables(left, right)
        return [self._link(a, b, written) for a, b in pairs if self._fits(a, b, written)]

    def look_at(self, end: str) -> None:
        """Check one end, where the variables of the other are not known."""
        both_ways = parse_connection(self._text).both_ways
        port = self._end(end, both_ways)
        if port is None:
            return
        if both_ways:
            self._members(port)
        elif not self._elements(port):
            self._reject_ends(port, port, [port])

    def _link(self, source: Port, target: Port, written: Connection) -> Link:
        scale, shift = 1.0, 0.0
        if not written.units_ignored:
            scale, shift = conversion(self._variable(source), self._variable(target))
        factor, offset = written.factor * scale, written.factor * shift + written.offset
        return Link(source, target, self._index, factor, offset, written.delayed)

    def _end(self, text: str, both_ways: bool) -> Port | None:
        """Component and the rest of one end; of a connector, a bus alone."""
        component, dot, rest = text.partition(".")
        if unknown := unknown_component(text, self._variables_of):
            self._reject(*unknown)
            return None
        if both_ways and not dot and component in self._system.buses:
            return Port(component, "")
        if not dot or not rest:
            self._reject(f"{text!r} names no variable or connector", f"write '{component}.name'")
            return None
        return Port(component, rest)

    def _variable(self, port: Port) -> Variable:
        return self._variables_of[port.component][port.variable]

    def _groups(self, left: Port, right: Port) -> list[tuple[Port, Port]]:
        ends = (left, right)
        single = [end for end in ends if end.variable in self._variables_of[end.component]]
        if any(not self._connectors(end)[1] for end in single):
            verb = "is a variable" if len(single) == 1 else "are variables"
            message = f"{' and '.join(map(str, single))} {verb}: '<->' connects connectors"
            self._reject(message, "connect variables with '->', from the output to the input")
            return []
        a, b = self._members(left), self._members(right)
        if not a or not b:
            return []
        pairs = []
        for last in a.keys() & b.keys():
            causalities = self._variable(a[last]).causality, self._variable(b[last]).causality
            if causalities in (("output", "input"), ("output", BUS), (BUS, "input")):
                pairs.append((a[last], b[last]))
            elif causalities in (("input", "output"), (BUS, "output"), ("input", BUS)):
                pairs.append((b[last], a[last]))
        if not pairs:
            remedy = f"{left} has {self._listed(a)}; {right} has {self._listed(b)}"
            self._reject(f"{left} and {right} have no output and input of the same name", remedy)
            return []
        pairs += [*self._carried(a, b), *self._carried(b, a)]
        return sorted(pairs, key=lambda pair: pair[1])

    def _carried(self, a: dict[str, Port], b: dict[str, Port]) -> list[tuple[Port, Port]]:
        """Calculated parameters beside the members `a`, each with a parameter beside `b`."""
        sources, targets = self._beside(a, "calculatedParameter"), self._beside(b, "parameter")
        return [(sources[last], targets[last]) for last in sources.keys() & targets.keys()]

    def _beside(self, members: dict[str, Port], causality: str) -> dict[str, Port]:
        """Variables of a causality in the connector that has these members, by last segment."""
        port = next(iter(members.values()))
        group = port.variable.rpartition(".")[0]
        return {
            name.rpartition(".")[2]: Port(port.component, name)
            for name, variable in self._variables_of[port.component].items()
            if variable.causality == causality and name.rpartition(".")[0] == group
        }

    def _listed(self, members: dict[str, Port]) -> str:
        return ", ".join(f"{n} ({self._variable(p).causality})" for n, p in sorted(members.items()))

    def _members(self, end: Port) -> dict[str, Port]:
        """Inputs and outputs of a connector by last segment; empty, with a problem, if unclear."""
        groups, near = self._connectors(end)
        word = end.variable
        if len(near) == 1:
            return groups[near[0]]
        if near:
            remedy = f"write one of: {', '.join(sorted(near))}"
            self._reject(f"{end.component!r} has several connectors {word!r}", remedy)
            return {}
        known = {*groups, *(g.rpartition(".")[2] for g in groups)}
        remedy = suggestion(word, known, "connectors")
        self._reject(f"{end.component!r} has no connector {word!r}", remedy)
        return {}

    def _connectors(self, end: Port) -> tuple[dict[str, dict[str, Port]], list[str]]:
        """Inputs and outputs by connector and last segment; the connectors that `end` may name."""
        groups: dict[str, dict[str, Port]] = defaultdict(dict)
        for v in self._variables_of[end.component].values():
            group, dot, last = v.name.rpartition(".")
            if v.causality == BUS or (dot and v.causality in ("input", "output")):
                groups[group][last] = Port(end.component, v.name)
        word = end.variable
        near = [g for g in groups if g == word] or [g for g in groups if g.endswith("." + word)]
        return groups, near

    def _variables(self, left: Port, right: Port) -> list[tuple[Port, Port]]:
        a, b = self._elements(left), self._elements(right)
        missing = [end for end, found in ((left, a), (right, b)) if not found]
        if missing:
            self._reject_ends(left, right, missing)
            return []
        if a.keys() != b.keys():
            remedy = f"{left} has {_extent(a)}, {right} has {_extent(b)}"
            self._reject(f"{left} and {right} differ in size", remedy)
            return []
        return [(a[index], b[index]) for index in a]

    def _elements(self, end: Port) -> dict[str, Port]:
        """The variable itself (index ''), or the elements of the array, by index; or nothing."""
        variables = self._variables_of[end.component]
        if end.variable in variables:
            return {"": end}
        prefix = end.variable + "["
        found = [name for name in variables if name.startswith(prefix) and name.endswith("]")]
        return {name[len(end.variable) :]: Port(end.component, name) for name in found}

    def _reject_ends(self, left: Port, right: Port, missing: Sequence[Port]) -> None:
        """Of the two ends of '->', those that are no variables: connectors, or unknown."""
        groups = [end for end in missing if self._connectors(end)[1]]
        if len(groups) == 2:
            message = f"{left} and {right} are connectors: '->' connects variables"
            self._reject(message, f"write '{left} <-> {right}'")
        elif groups:
            message = f"{groups[0]} is a connector: '->' connects variables"
            self._reject(message, "name one of its variables, or two connectors with '<->'")
        for end in missing:
            if end not in groups:
                variables = self._variables_of[end.component]
                known = {*variables, *(name.partition("[")[0] for name in variables)}
                remedy = suggestion(end.variable, known, "variables")
                self._reject(f"{end.component!r} has no variable {end.variable!r}", remedy)

    def _fits(self, source: Port, target: Port, written: Connection) -> bool:
        """Whether a value may go from `source` to `target`: causality, type and dimension."""
        give, take = self._variable(source), self._variable(target)
        if give.causality == take.causality == BUS:
            remedy = "connect a component to both: it gives each of them the value"
            self._reject(f"{source} and {target} are both signals of a bus", remedy)
        elif give.causality not in ("output", "calculatedParameter", BUS):
            remedy = "what stands left of '->' must be an output or a calculated parameter"
            self._reject(f"{source} ({give.causality}) is not an output", remedy)
        elif take.causality not in ("input", "parameter", BUS):
            remedy = "what stands right of '->' must be an input or a parameter"
            self._reject(f"{target} ({take.causality}) is not an input", remedy)
        elif (give.causality, take.causality) == CONSTANT_TO_INPUT:
            self._reject(f"{source} is constant, {target} is an input", CARRIED_ONCE)
        elif found := misfit(give, take, plain=(written.factor, written.offset) == (1.0, 0.0)):
            what, remedy = found
            self._reject(f"{source} -> {target}: {source} {what}", remedy)
        else:
            return written.units_ignored or self._units_fit(source, target, written)
        return False

    def _units_fit(self, source: Port, target: Port, written: Connection) -> bool:
        give, take = self._variable(source).dimension, self._variable(target).dimension
        if give is None or take is None or give.same_dimension(take):
            return True
        remedy = f"connect other variables: {give.si_text} is not {take.si_text}"
        if not written.both_ways:
            remedy += "; or write ', units ignored' behind the connection"
        self._reject(f"{source} is in {give.text}, {target} expects {take.text}", remedy)
        return False


def _through_problems(
    system: System, variables: Mapping[str, Mapping[str, Variable]], links: Iterable[Link]
) -> Iterable[Problem]:
    """Calculated parameters that lead to inputs over a bus, and types that do not fit."""
    for link in links:
        give, take = (variables[p.component][p.variable] for p in (link.source, link.target))
        if found := misfit(give, take, plain=link.is_plain):
            message = f"{link}: {link.source} {found[0]}"
            yield system.problem(("connections", link.connection), message, found[1])
        if (give.causality, take.causality) == CONSTANT_TO_INPUT:
            message = f"{link.source} is constant, {link.target} is an input"
            yield system.problem(("connections", link.connection), message, CARRIED_ONCE)


def is_carried(give: Variable, take: Variable) -> bool:
    """True if values go over at every communication point; otherwise they do once, at the start."""
    return take.causality == "input" or (_is_varying(give) and take.variability == "tunable")


def _is_varying(give: Variable) -> bool:
    return give.causality == "output" and give.variability != "constant"


def _delay_problems(
    system: System, variables: Mapping[str, Mapping[str, Variable]], links: Iterable[Link]
) -> Iterable[Problem]:
    """Parameters that take values once, with a delay."""
    for link in links:
        give, take = (variables[port.component][port.variable] for port in link.ends)
        if link.delayed and not is_carried(give, take) and not _is_varying(give):
            message = (
                f"{link.target} is a parameter, to which values are carried once, at the start"
            )
            remedy = "leave out ', delayed'"
            yield system.problem(("connections", link.connection), message, remedy)


def _frozen_problems(
    system: System, variables: Mapping[str, Mapping[str, Variable]], links: Iterable[Link]
) -> Iterable[Problem]:
    """Outputs that lead into parameters which cannot change during a run."""
    for link in links:
        give, take = (variables[port.component][port.variable] for port in link.ends)
        if _is_varying(give) and not is_carried(give, take):
            message = (
                f"{link.target} is a {take.variability} parameter, which cannot follow the output "
                f"{link.source} during a run"
            )
            remedy = (
                "connect to an input or a tunable parameter (of a model: tunable: true), or give "
                "a number under start:"
            )
            yield system.problem(("connections", link.connection), message, remedy)


def conversion(give: Variable, take: Variable) -> tuple[float, float]:
    """Factor and offset from the unit of one variable to that of another, of one dimension."""
    if give.dimension is None or take.dimension is None:
        return 1.0, 0.0
    factor = give.dimension.factor / take.dimension.factor
    shift = (give.offset - take.offset) / take.dimension.factor
    return (1.0 if abs(factor - 1) < SAME_UNIT else factor), shift


def _extent(elements: Iterable[str]) -> str:
    indices = list(elements)
    return (
        "no index" if indices == [""] else f"{len(indices)} elements {indices[0]} to {indices[-1]}"
    )


def _without_given(
    system: System, variables: Mapping[str, Mapping[str, Variable]], links: list[Link]
) -> list[Link]:
    """`links` without those of '<->' into parameters that are given in another way."""

    def implied(link: Link) -> bool:
        target = variables[link.target.component][link.target.variable]
        return target.causality == "parameter" and "<->" in system.connections[link.connection]

    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {link.target for link in links if not implied(link)}
    return [link for link in links if not (implied(link) and link.target in given)]


def _one_source_each(system: System, links: list[Link], problems: list[Problem]) -> list[Link]:
    first: dict[Port, Link] = {}
    for link in links:
        other = first.setdefault(link.target, link)
        if other.source != link.source:
            message = f"{link.target} has two sources: {other.source} and {link.source}"
            remedy = (
                f"drop one (the other is connected by {system.connections[other.connection]!r}), "
                "or connect both to a component of 'kind: sum', and its sum here"
            )
            problems.append(system.problem(("connections", link.connection), message, remedy))
        elif link.delayed:  # beside a connector that carries it, too
            first[link.target] = link
    return list(first.values())


def _outside_problems(
    system: System, descriptions: Mapping[str, Description], driven: set[Port]
) -> Iterable[Problem]:
    """What is wrong with the system's own inputs and outputs."""
    named = [(("inputs", name), text) for name, texts in system.inputs.items() for text in texts]
    named += [(("outputs", name), text) for name, text in system.outputs.items()]
    for at, text in named:
        port = Port(*text.partition(".")[::2])
        kind = at[0].removesuffix("s")
        known = descriptions.get(port.component)
        variable = known.variables.get(port.variable) if known else None
        if variable is None:
            there = known.of_causality(kind) if known else ()
            remedy = suggestion(port.variable, [v.name for v in there], f"{kind}s")
            if known is None:
                remedy = suggestion(port.component, descriptions, "components")
            yield system.problem(at, f"{at[1]!r} stands for {text!r}, which is no variable", remedy)
        elif variable.causality != kind:
            message = f"{at[1]!r} stands for {text} ({variable.causality}), which is no {kind}"
            yield system.problem(at, message, f"name an {kind}")
        elif port in driven:
            message = f"{at[1]!r} stands for {text}, which is connected"
            yield system.problem(at, message, "name an input that nothing leads to")


def _moved_problems(
    system: System, descriptions: Mapping[str, Description], links: Iterable[Link]
) -> Iterable[Problem]:
    """Inputs that an FMU moves along others, which have to be carried over alike."""
    by_target = {link.target: link for link in links}
    for component, description in descriptions.items():
        for moved, rate in description.input_derivatives.items():
            place = by_target.get(Port(component, moved))
            speed = by_target.get(Port(component, rate))
            if place is None or speed is None:
                continue
            if abs(speed.factor / place.factor - 1) > SAME_UNIT or speed.offset != 0.0:
                message = f"{rate} is declared as the rate of {moved}, but carried over otherwise"
                remedy = f"give both the factor {place.factor:g}, and {rate} no offset"
                yield system.problem(("connections", speed.connection), message, remedy)


def _bonds(
    system: System, variables: Mapping[str, Mapping[str, Variable]], links: Sequence[Link]
) -> Iterable[Bond]:
    """The power bonds among the links, connection by connection.

    A force is one on a body whose velocity, of the same connector, goes to any component: that of
    the force itself, or one whose force a third component adds to others.
    """
    carried = {link.source: link for link in links}
    found: dict[int, list[Axis]] = defaultdict(list)
    for force, velocity, position in AXES:
        for link in links:
            body, last = link.target.component, _last(link.target)
            connector = link.target.variable.removesuffix(last)
            back = carried.get(Port(body, connector + velocity))
            give, take = (variables[p.component][p.variable] for p in (link.source, link.target))
            scale, shift = conversion(give, take)
            if last == force and back and link.offset == link.factor / scale * shift:
                moved = carried.get(Port(body, connector + position))
                found[link.connection].append(Axis(link, back, moved, link.factor / scale))
    for index, axes in sorted(found.items()):
        sources = {axis.force.source.component for axis in axes}
        given = [link for link in links if link.target.component in sources]
        forces = {axis[0] for axis in AXES}
        adds = dict.fromkeys(link.source.component for link in given)
        if not all(_last(link.source) in forces for link in given):
            adds = {}  # it is moved by what it is given, or driven: no mere sum of forces
        yield Bond(system.connections[index], tuple(axes), tuple(adds))


def _last(port: Port) -> str:
    return port.variable.rpartition(".")[2]
