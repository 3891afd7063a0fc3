"""Unconnected connectors of two components that seem to belong together.

A connector is the variables whose names are equal up to their last dot. Two of them fit if all
inputs of one are outputs of the other, by their last words, in the same unit, and no variable of
both is of another unit. They belong together if they have the same name, and neither fits another
one of this name; else if all inputs of both fit, and neither fits another connector as well.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field
from functools import cached_property

from m4e_fmi.cosim.connections.links import Port
from m4e_fmi.fmu.importer.reading import Description, Variable


@dataclass(frozen=True)
class Pair:
    """Two connectors that belong together, and the outputs of each that the other has as inputs."""

    ends: tuple[Port, Port]
    given: tuple[frozenset[Port], frozenset[Port]]

    def of(self, port: Port) -> Port:
        """The other end, from that of a variable or of the connector itself."""
        a, b = self.ends
        return b if port == a or group_of(port) == a else a

    def outputs(self, end: Port) -> frozenset[Port]:
        """The outputs of the connector `end` that the other has as inputs."""
        return self.given[self.ends.index(end)]

    def __str__(self) -> str:
        return "'{} <-> {}'".format(*self.ends)


@dataclass(frozen=True, eq=False)
class _Connector:
    """The inputs and outputs of the connector `port` by their last words."""

    port: Port
    inputs: dict[str, Variable] = field(default_factory=dict)
    outputs: dict[str, Variable] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.port.variable.rpartition(".")[2]

    @cached_property
    def shape(self) -> tuple[frozenset[tuple[str, str, str]], ...]:
        """Last words, types and units of its inputs and outputs, which decide what fits."""
        groups = (self.inputs, self.outputs)
        return tuple(frozenset((n, v.type, v.unit) for n, v in group.items()) for group in groups)


def group_of(port: Port) -> Port:
    """The connector of a variable."""
    return Port(port.component, port.variable.rpartition(".")[0])


def fits(output: Variable, target: Variable) -> bool:
    """True if the input `target` may take the value of `output`, by type and unit."""
    if output.type != target.type:
        return False
    a, b = output.dimension, target.dimension
    return a is None or b is None or a.same_dimension(b)


def free_pairs(descriptions: Mapping[str, Description], driven: Set[Port]) -> list[Pair]:
    """Pairs of connectors none of whose inputs is `driven`."""
    free = [
        connector
        for connector in _connectors(descriptions)
        if not any(
            Port(connector.port.component, v.name) in driven for v in connector.inputs.values()
        )
    ]
    giving: dict[str, list[_Connector]] = {}
    for connector in free:
        for name in connector.outputs:
            giving.setdefault(name, []).append(connector)
    found: dict[frozenset[_Connector], tuple[_Connector, _Connector]] = {}
    together: dict[object, bool] = {}
    for taking in free:
        for other in {other for name in taking.inputs for other in giving.get(name, ())}:
            if other.port.component == taking.port.component:
                continue
            case = other.shape, taking.shape, other.name == taking.name
            if case not in together:
                together[case] = _belong_together(other, taking)
            if together[case]:
                found.setdefault(frozenset((other, taking)), (other, taking))
    all_of = Counter(connector for pair in found for connector in pair)
    named = Counter(c for pair, (a, b) in found.items() if a.name == b.name for c in pair)
    pairs = []
    for a, b in found.values():
        rivals = named if a.name == b.name else all_of
        if rivals[a] == rivals[b] == 1:
            a, b = sorted((a, b), key=lambda c: c.port)
            pairs.append(Pair((a.port, b.port), (_given(a, b), _given(b, a))))
    return sorted(pairs, key=lambda pair: pair.ends)


def _connectors(descriptions: Mapping[str, Description]) -> Iterator[_Connector]:
    for component, description in descriptions.items():
        groups: dict[str, _Connector] = {}
        for causality in ("input", "output"):
            for variable in description.of_causality(causality):
                group, dot, last = variable.name.rpartition(".")
                if dot:
                    known = groups.setdefault(group, _Connector(Port(component, group)))
                    members = known.inputs if causality == "input" else known.outputs
                    members[last] = variable
        yield from groups.values()


def _belong_together(a: _Connector, b: _Connector) -> bool:
    ways = ((a.outputs, b.inputs), (b.outputs, a.inputs))
    if any(not fits(give[n], take[n]) for give, take in ways for n in give.keys() & take.keys()):
        return False
    fed = [bool(give.keys() & take.keys()) and give.keys() >= take.keys() for give, take in ways]
    return all(fed) or (a.name == b.name and any(fed))


def _given(giving: _Connector, taking: _Connector) -> frozenset[Port]:
    names = giving.outputs.keys() & taking.inputs.keys()
    return frozenset(Port(giving.port.component, giving.outputs[name].name) for name in names)
