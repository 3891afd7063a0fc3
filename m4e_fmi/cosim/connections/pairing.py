"""Variables that one connection text pairs, and the problems of the text.

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
from collections.abc import Collection, Iterable, Mapping, Sequence

from m4e_fmi.cosim.connections.added_mass.left_out import differing_bodies, lacking_flag
from m4e_fmi.cosim.connections.added_mass.matrices import added_mass_bodies, in_order
from m4e_fmi.cosim.connections.buses import BUS
from m4e_fmi.cosim.connections.link_checks import CARRIED_ONCE, CONSTANT_TO_INPUT
from m4e_fmi.cosim.connections.links import Link, Port, Variables, conversion
from m4e_fmi.cosim.system.connection_text import Connection, parse_connection, unknown_component
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.fmu.importer.type_rules import misfit

_FORWARD = (("output", "input"), ("output", BUS), (BUS, "input"))
_BACKWARD = tuple((there, here) for here, there in _FORWARD)


class Pairing:
    """The links of one connection text; adds the problems found in the text to `problems`."""

    def __init__(
        self,
        system: System,
        variables: Variables,
        index: int,
        text: str,
        problems: list[Problem],
    ) -> None:
        self._system = system
        self._variables = variables
        self._index = index
        self._text = text
        self._problems = problems

    def _reject(self, message: str, remedy: str = "") -> None:
        at = ("connections", self._index)
        self._problems.append(self._system.problem(at, message, remedy))

    def links(self) -> list[Link]:
        """The links of the text; none if it is wrong as a whole."""
        try:
            written = parse_connection(self._text)
        except InputError as error:
            problem = error.problems[0]
            self._reject(problem.message, problem.remedy)
            return []
        both_ways = written.both_ways
        left, right = (self._end(text, both_ways) for text in (written.left, written.right))
        if left is None or right is None:
            return []
        pairs = self._paired_groups(left, right) if both_ways else self._paired(left, right)
        links: list[Link] = []
        for a, b in pairs:
            if self._fits(a, b, written):
                links.append(self._link(a, b, written))
            elif not both_ways:
                break  # the other elements of an array have the same problem
        return links

    def _link(self, source: Port, target: Port, written: Connection) -> Link:
        scale, shift = 1.0, 0.0
        if not written.units_ignored:
            scale, shift = conversion(self._variable(source), self._variable(target))
        factor, offset = written.factor * scale, written.factor * shift + written.offset
        return Link(source, target, self._index, factor, offset, written.delayed)

    def _end(self, text: str, both_ways: bool) -> Port | None:
        """Component and the rest of one end; a connector may be a bus alone."""
        component, dot, rest = text.partition(".")
        if unknown := unknown_component(text, self._variables):
            self._reject(unknown.message, unknown.remedy)
            return None
        if both_ways and not dot and component in self._system.buses:
            return Port(component, "")
        if not dot or not rest:
            self._reject(f"{text!r} names no variable or connector", f"write '{component}.name'")
            return None
        return Port(component, rest)

    def _variable(self, port: Port) -> Variable:
        return self._variables[port.component][port.variable]

    def _paired_groups(self, left: Port, right: Port) -> list[tuple[Port, Port]]:
        """Source and target of all links between two connectors."""
        single = [end for end in (left, right) if end.variable in self._variables[end.component]]
        if any(not self._connectors(end)[1] for end in single):
            verb = "is a variable" if len(single) == 1 else "are variables"
            message = f"{' and '.join(map(str, single))} {verb}: '<->' connects connectors"
            self._reject(message, "connect variables with '->', from the output to the input")
            return []
        a, b = self._members(left), self._members(right)
        if not a or not b:
            return []
        for planar, flat, other in ((left, a, b), (right, b, a)):
            if _has(flat, "xz") and not _has(flat, "y") and _has(other, "xyz"):
                message = f"{planar} is planar, and what it is connected with moves along Y, too"
                remedy = "give it 'dimensions: 3', or connect its variables one by one with '->'"
                self._reject(message, remedy)
                return []
        pairs: list[tuple[Port, Port]] = []
        for last in a.keys() & b.keys():
            causalities = self._variable(a[last]).causality, self._variable(b[last]).causality
            if causalities in _FORWARD:
                pairs.append((a[last], b[last]))
            elif causalities in _BACKWARD:
                pairs.append((b[last], a[last]))
        if not pairs:
            remedy = f"{left} has {self._listed(a)}; {right} has {self._listed(b)}"
            self._reject(f"{left} and {right} have no output and input of the same name", remedy)
            return []
        pairs += [*self._parameters(a, b), *self._parameters(b, a)]
        return sorted(pairs, key=lambda pair: pair[1])

    def _parameters(self, a: dict[str, Port], b: dict[str, Port]) -> list[tuple[Port, Port]]:
        """Calculated parameters beside the members `a`, each with a parameter beside `b`."""
        sources, targets = self._beside(a, "calculatedParameter"), self._beside(b, "parameter")
        return [(sources[last], targets[last]) for last in sources.keys() & targets.keys()]

    def _beside(self, members: dict[str, Port], causality: str) -> dict[str, Port]:
        """Variables of a causality in the connector that has these members, by last segment."""
        port = next(iter(members.values()))
        group = port.variable.rpartition(".")[0]
        return {
            name.rpartition(".")[2]: Port(port.component, name)
            for name, variable in self._variables[port.component].items()
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
        for v in self._variables[end.component].values():
            group, dot, last = v.name.rpartition(".")
            if v.causality == BUS or (dot and v.causality in ("input", "output")):
                groups[group][last] = Port(end.component, v.name)
        word = end.variable
        near = [g for g in groups if g == word] or [g for g in groups if g.endswith("." + word)]
        return groups, near

    def _paired(self, left: Port, right: Port) -> list[tuple[Port, Port]]:
        """The two variables, or all elements of the two arrays."""
        a, b = self._elements(left), self._elements(right)
        missing = [end for end, found in ((left, a), (right, b)) if not found]
        if missing:
            self._reject_ends(left, right, missing)
            return []
        if a.keys() != b.keys():
            remedy = f"{left} has {_extent(a)}, {right} has {_extent(b)}"
            if {len(a), len(b)} == {9, 36}:  # added mass of one body in the plane, and in space
                pairs = zip((1, 3, 5), (1, 2, 3), strict=True)
                row = [(f"[1,{c}]", f"[1,{p}]") for c, p in pairs]
                row = row if len(a) == 36 else [(p, c) for c, p in row]
                links = ", ".join(f"{left}{i} -> {right}{j}" for i, j in row)
                remedy += f"; of a body in the plane and in space, connect one by one: {links}, …"
            remedy += differing_bodies(self._bodies(a), self._bodies(b))
            self._reject(f"{left} and {right} differ in size", remedy)
            return []
        return [(a[index], b[index]) for index in a]

    def _bodies(self, elements: Mapping[str, Port]) -> list[str]:
        """The bodies of the rows of an added-mass matrix; none of another array."""
        ports = elements.values()
        return in_order(added_mass_bodies({p.variable: self._variable(p) for p in ports}))

    def _elements(self, end: Port) -> dict[str, Port]:
        """The variable itself (index ''), or the elements of the array, by index; or nothing."""
        variables = self._variables[end.component]
        if end.variable in variables:
            return {"": end}
        prefix = end.variable + "["
        found = [name for name in variables if name.startswith(prefix) and name.endswith("]")]
        return {name[len(end.variable) :]: Port(end.component, name) for name in found}

    def _reject_ends(self, left: Port, right: Port, missing: Sequence[Port]) -> None:
        """Problems of the ends of '->' that are not variables: connectors, or unknown."""
        groups = [end for end in missing if self._connectors(end)[1]]
        if len(groups) == 2:
            message = f"{left} and {right} are connectors: '->' connects variables"
            self._reject(message, f"write '{left} <-> {right}'")
        elif groups:
            message = f"{groups[0]} is a connector: '->' connects variables"
            self._reject(message, "name one of its variables, or two connectors with '<->'")
        for end in missing:
            if end not in groups:
                variables = self._variables[end.component]
                known = {*variables, *(name.partition("[")[0] for name in variables)}
                remedy = lacking_flag(variables, end.variable.partition("[")[0])
                remedy = remedy or suggestion(end.variable, known, "variables")
                self._reject(f"{end.component!r} has no variable {end.variable!r}", remedy)

    def _fits(self, source: Port, target: Port, written: Connection) -> bool:
        """True if a value may go from `source` to `target`, by causality, type and dimension."""
        give, take = self._variable(source), self._variable(target)
        if give.causality == take.causality == BUS:
            remedy = "connect a component to both: it gives each of them the value"
            self._reject(f"{source} and {target} are both signals of a bus", remedy)
        elif give.causality not in ("output", "calculatedParameter", BUS):
            remedy = "the left side of '->' must be an output or a calculated parameter"
            self._reject(f"{source} ({give.causality}) is not an output", remedy)
        elif take.causality not in ("input", "parameter", BUS):
            remedy = "the right side of '->' must be an input or a parameter"
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
        remedy = f"connect other variables: {give.difference(take)}"
        if not written.both_ways:
            remedy += "; or write ', units ignored' behind the connection"
        self._reject(f"{source} is in {give.text}, {target} expects {take.text}", remedy)
        return False


def _extent(elements: Iterable[str]) -> str:
    indices = list(elements)
    return (
        "no index" if indices == [""] else f"{len(indices)} elements {indices[0]} to {indices[-1]}"
    )


def _has(members: Collection[str], axes: str) -> bool:
    """True of a connector with a position or a velocity along each of the `axes`."""
    return all(axis in members or f"v{axis}" in members for axis in axes)
