"""From connection texts to links, with every check that needs no running FMU.

A calculated parameter is carried over into a parameter once, at initialisation. An output may lead
into a tunable parameter, and is then carried at every communication point, as into an input
(`is_carried`); into a fixed one it may not. Values are converted where units differ; `type_rules`
tells which types fit.

``a.group <-> b.group`` connects connectors. A group is the part of a variable's name before its
last dot; the word written may be the whole group or its last parts, if that is unique. Members
whose last segments are equal and of which one is an output, the other an input, are connected, both
ways, unless one connector is of the plane and the other of space. So is a calculated parameter with
a parameter, unless that has a start value or is connected by ``->``.

``a.variable -> b.variable`` connects one variable, or all elements of an array given by its base
name; `connection_text` tells how a factor and an offset are written.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from m4e_fmi.cosim.system.component import answers
from m4e_fmi.cosim.system.connection_text import ConnectionText, parse_connection, unknown_component
from m4e_fmi.cosim.system.start_values import start_problems
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.added_mass import (
    added_mass_bodies,
    body_order_problems,
    differing_bodies,
    in_order,
    lacking_flag,
)
from m4e_fmi.cosim.wiring.link_checks import (
    input_derivative_problems,
    link_problems,
    outer_port_problems,
    unset_masses,
)
from m4e_fmi.cosim.wiring.links import (
    Link,
    Port,
    Variables,
    Wiring,
    can_be_summed,
    conversion,
    is_carried,
    power_bonds,
    sum_note,
    summed,
)
from m4e_fmi.cosim.wiring.structure import dependency_problems
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import misfit

_FORWARD = ("output", "input")


@dataclass(frozen=True)
class Pairing:
    """Links of the variables that a connection's text pairs."""

    system: System
    variables: Variables

    def links(self, index: int) -> Iterator[Link]:
        """The links of the connection `index`; in the end InputError with all its problems."""
        written = parse_connection(self.system.connections[index])
        both_ways = written.both_ways
        left, right = (self._end(text) for text in (written.left, written.right))
        pairs = self._paired_groups(left, right) if both_ways else self._paired(left, right)
        problems: list[Problem] = []
        for source, target in pairs:
            try:
                self._check(source, target, written)
            except InputError as error:
                problems += error.problems
                if not both_ways:
                    break  # the other elements of an array have the same problem
                continue
            scale, shift = 1.0, 0.0
            if not written.units_ignored:
                scale, shift = conversion(self._variable(source), self._variable(target))
            factor, offset = written.factor * scale, written.factor * shift + written.offset
            yield Link(source, target, index, factor, offset, written.delayed)
        InputError.raise_for(problems)

    def _end(self, text: str) -> Port:
        """Component and the rest of one end."""
        port = Port.named(text)
        if unknown := unknown_component(text, self.variables):
            raise InputError([unknown])
        if not port.variable:
            message = f"{text!r} names no variable or connector"
            raise InputError.single(message, f"write '{port.component}.name'")
        return port

    def _variable(self, port: Port) -> Variable:
        return self.variables[port.component][port.variable]

    def _paired_groups(self, left: Port, right: Port) -> list[tuple[Port, Port]]:
        """Source and target of all links between two connectors."""
        single = [end for end in (left, right) if end.variable in self.variables[end.component]]
        if any(not self._connectors(end)[1] for end in single):
            verb = "is a variable" if len(single) == 1 else "are variables"
            message = f"{' and '.join(map(str, single))} {verb}: '<->' connects connectors"
            remedy = "connect variables with '->', from the output to the input"
            raise InputError.single(message, remedy)
        a, b = self._members(left), self._members(right)
        for planar, flat, other in ((left, a, b), (right, b, a)):
            if _has(flat, "xz") and not _has(flat, "y") and _has(other, "xyz"):
                message = f"{planar} is planar, and what it is connected with moves along Y, too"
                remedy = "give it 'dimensions: 3', or connect its variables one by one with '->'"
                raise InputError.single(message, remedy)
        pairs: list[tuple[Port, Port]] = []
        for last in a.keys() & b.keys():
            causalities = self._variable(a[last]).causality, self._variable(b[last]).causality
            if causalities == _FORWARD:
                pairs.append((a[last], b[last]))
            elif causalities[::-1] == _FORWARD:
                pairs.append((b[last], a[last]))
        if not pairs:
            message = f"{left} and {right} have no output and input of the same name"
            remedy = f"{left} has {self._listed(a)}; {right} has {self._listed(b)}"
            raise InputError.single(message, remedy)
        for givers, takers in ((a, b), (b, a)):
            sources = self._beside(givers, "calculatedParameter")
            targets = self._beside(takers, "parameter")
            pairs += [(sources[last], targets[last]) for last in sources.keys() & targets.keys()]
        return sorted(pairs, key=lambda pair: pair[1])

    def _beside(self, members: dict[str, Port], causality: str) -> dict[str, Port]:
        """Variables of a causality in the connector that has these members, by last segment."""
        port = next(iter(members.values()))
        group = port.variable.rpartition(".")[0]
        return {
            name.rpartition(".")[2]: Port(port.component, name)
            for name, variable in self.variables[port.component].items()
            if variable.causality == causality and name.rpartition(".")[0] == group
        }

    def _listed(self, members: dict[str, Port]) -> str:
        return ", ".join(f"{n} ({self._variable(p).causality})" for n, p in sorted(members.items()))

    def _members(self, end: Port) -> dict[str, Port]:
        """Inputs and outputs of a connector by last segment."""
        groups, near = self._connectors(end)
        word = end.variable
        if len(near) == 1:
            return groups[near[0]]
        if near:
            remedy = f"write one of: {', '.join(sorted(near))}"
            raise InputError.single(f"{end.component!r} has several connectors {word!r}", remedy)
        known = {*groups, *(g.rpartition(".")[2] for g in groups)}
        remedy = suggestion(word, known, "connectors")
        raise InputError.single(f"{end.component!r} has no connector {word!r}", remedy)

    def _connectors(self, end: Port) -> tuple[dict[str, dict[str, Port]], list[str]]:
        """Inputs and outputs by connector and last segment; the connectors that `end` may name."""
        groups: dict[str, dict[str, Port]] = defaultdict(dict)
        for v in self.variables[end.component].values():
            group, dot, last = v.name.rpartition(".")
            if dot and v.causality in ("input", "output"):
                groups[group][last] = Port(end.component, v.name)
        word = end.variable
        near = [g for g in groups if g == word] or [g for g in groups if g.endswith("." + word)]
        return groups, near

    def _paired(self, left: Port, right: Port) -> list[tuple[Port, Port]]:
        """The two variables, or all elements of the two arrays."""
        a, b = self._elements(left), self._elements(right)
        missing = [end for end, found in ((left, a), (right, b)) if not found]
        if missing:
            raise InputError(self._not_variables(left, right, missing))
        if a.keys() == b.keys():
            return [(a[index], b[index]) for index in a]
        remedy = f"{left} has {_extent(a)}, {right} has {_extent(b)}"
        if {len(a), len(b)} == {9, 36}:  # added mass of one body in the plane, and in space
            pairs = zip((1, 3, 5), (1, 2, 3), strict=True)
            row = [(f"[1,{c}]", f"[1,{p}]") for c, p in pairs]
            row = row if len(a) == 36 else [(p, c) for c, p in row]
            links = ", ".join(f"{left}{i} -> {right}{j}" for i, j in row)
            remedy += f"; of a body in the plane and in space, connect one by one: {links}, …"
        remedy += differing_bodies(self._bodies(a), self._bodies(b))
        raise InputError.single(f"{left} and {right} differ in size", remedy)

    def _bodies(self, elements: Mapping[str, Port]) -> list[str]:
        """The bodies of the rows of an added-mass matrix; none of another array."""
        ports = elements.values()
        return in_order(added_mass_bodies({p.variable: self._variable(p) for p in ports}))

    def _elements(self, end: Port) -> dict[str, Port]:
        """The variable itself (index ''), or the elements of the array, by index; or nothing."""
        variables = self.variables[end.component]
        if end.variable in variables:
            return {"": end}
        prefix = end.variable + "["
        found = [name for name in variables if name.startswith(prefix) and name.endswith("]")]
        return {name[len(end.variable) :]: Port(end.component, name) for name in found}

    def _not_variables(self, left: Port, right: Port, missing: Sequence[Port]) -> Iterator[Problem]:
        """Problems of the ends of '->' that are not variables: connectors, or unknown."""
        groups = [end for end in missing if self._connectors(end)[1]]
        if len(groups) == 2:
            message = f"{left} and {right} are connectors: '->' connects variables"
            yield Problem(message, f"write '{left} <-> {right}'")
        elif groups:
            message = f"{groups[0]} is a connector: '->' connects variables"
            yield Problem(message, "name one of its variables, or two connectors with '<->'")
        for end in missing:
            if end not in groups:
                variables = self.variables[end.component]
                known = {*variables, *(name.partition("[")[0] for name in variables)}
                remedy = lacking_flag(variables, end.variable.partition("[")[0])
                remedy = remedy or suggestion(end.variable, known, "variables")
                yield Problem(f"{end.component!r} has no variable {end.variable!r}", remedy)

    def _check(self, source: Port, target: Port, written: ConnectionText) -> None:
        """InputError if no value may go from `source` to `target`."""
        give, take = self._variable(source), self._variable(target)
        message, remedy = "", ""
        if give.causality not in ("output", "calculatedParameter"):
            message = f"{source} ({give.causality}) is not an output"
            remedy = "the left side of '->' must be an output or a calculated parameter"
        elif take.causality not in ("input", "parameter"):
            message = f"{target} ({take.causality}) is not an input"
            remedy = "the right side of '->' must be an input or a parameter"
        elif (give.causality, take.causality) == ("calculatedParameter", "input"):
            message = f"{source} is constant, {target} is an input"
            remedy = "a calculated parameter is transferred once: connect it to a parameter"
        elif found := misfit(give, take, plain=(written.factor, written.offset) == (1.0, 0.0)):
            message, remedy = f"{source} -> {target}: {source} {found[0]}", found[1]
        elif not written.units_ignored:
            one, other = give.dimension, take.dimension
            if one is not None and other is not None and not one.same_dimension(other):
                message = f"{source} is in {one.text}, {target} expects {other.text}"
                remedy = f"connect other variables: {one.difference(other)}"
                if not written.both_ways:
                    remedy += "; or write ', units ignored' behind the connection"
        if message:
            raise InputError.single(message, remedy)


def _extent(elements: Iterable[str]) -> str:
    indices = list(elements)
    return (
        "no index" if indices == [""] else f"{len(indices)} elements {indices[0]} to {indices[-1]}"
    )


def _has(members: Collection[str], axes: str) -> bool:
    """True of a connector with a position or a velocity along each of the `axes`."""
    return all(axis in members or f"v{axis}" in members for axis in axes)


def connect(system: System, descriptions: Mapping[str, Description]) -> Wiring:
    """The wiring of `system`, whose components' FMUs have these `descriptions`.

    InputError with all problems of connections, start values, and the system's inputs and outputs,
    each at its place.
    """
    links, variables = _resolved(system, descriptions)
    steady = tuple(link for link in links if is_carried(*link.variables(variables)))
    driven = {link.target for link in steady}
    inputs = [Port(c, v.name) for c, d in descriptions.items() for v in d.of_causality("input")]
    real = [link for link in steady if link.is_real]
    return Wiring(
        links=steady,
        initial_links=tuple(k for k in links if not is_carried(*k.variables(variables))),
        bonds=tuple(power_bonds(system.connections, variables, real)),
        unconnected=tuple(port for port in inputs if port not in driven),
        notes=tuple(map(sum_note, summed(links, variables))),
    )


def _resolved(
    system: System, descriptions: Mapping[str, Description]
) -> tuple[list[Link], Variables]:
    """Links between components, by connection, and all variables; InputError."""
    problems: list[Problem] = []
    variables = {name: description.variables for name, description in descriptions.items()}
    links: list[Link] = []
    pairing = Pairing(system, variables)
    for index in range(len(system.connections)):
        try:
            links.extend(pairing.links(index))  # those before a problem stay
        except InputError as error:
            at = ("connections", index)
            problems += [system.problem(at, p.message, p.remedy) for p in error.problems]
    links = _without_given(system, variables, links)
    links = _one_source_each(system, variables, links, problems)
    links = [replace(link, kind=link.variables(variables)[0].type) for link in links]
    driven = {link.target for link in links}
    found: list[Iterable[Problem]] = [
        link_problems(system, variables, links),
        start_problems(system, descriptions),
        dependency_problems(system, descriptions),
        answers(system.components, descriptions, lambda k: k.problems, system, variables, links),
        input_derivative_problems(system, descriptions, links),
        body_order_problems(system, variables, links),
        outer_port_problems(system, descriptions, driven),
        unset_masses(system, descriptions, {str(port) for port in driven}),
    ]
    problems += [problem for group in found for problem in group]
    InputError.raise_for(problems)
    return links, variables


def _without_given(system: System, variables: Variables, links: list[Link]) -> list[Link]:
    """`links` without those of '<->' into parameters that are given in another way."""

    def implied(link: Link) -> bool:
        target = variables[link.target.component][link.target.variable]
        return target.causality == "parameter" and "<->" in system.connections[link.connection]

    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {link.target for link in links if not implied(link)}
    return [link for link in links if not (implied(link) and link.target in given)]


def _one_source_each(
    system: System, variables: Variables, links: list[Link], problems: list[Problem]
) -> list[Link]:
    """The first link from each source into each target, which has one source, or takes a sum.

    Adds to `problems` where a target that takes no sum has another source, and where a source has
    two factors.
    """
    first: dict[tuple[Port, Port], Link] = {}
    sources: dict[Port, Link] = {}
    for link in links:
        give, target = link.variables(variables)
        other = sources.setdefault(link.target, link)
        if other.source != link.source and not can_be_summed(give, target):
            message = f"{link.target} has two sources: {other.source} and {link.source}"
            remedy = (
                f"drop one (the other is connected by {system.connections[other.connection]!r}), "
                "or connect both to a component of 'kind: sum', and its sum here; forces, moments "
                "and added masses add up without one"
            )
            problems.append(system.problem(("connections", link.connection), message, remedy))
            continue
        known = first.setdefault(link.ends, link)
        if (known.factor, known.offset) != (link.factor, link.offset):
            message = f"{link} is connected twice, by factors {known.factor:g} and {link.factor:g}"
            remedy = f"drop one (the other is {system.connections[known.connection]!r})"
            problems.append(system.problem(("connections", link.connection), message, remedy))
        if known is not link and link.delayed:  # beside a connector that carries it, too
            first[link.ends] = link
    return sorted(first.values(), key=lambda link: link.connection)
