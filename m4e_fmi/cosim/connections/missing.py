"""Unconnected inputs, and components whose outputs lead nowhere.

An input that is not connected keeps its start value. That is reported, unless it is intended: a
value is given under `start:`, or in the configuration of the component, the input is one of the
system's own `inputs`, or it is an *idle load*: a force, moment or effort on a body, point or joint
of a multibody FMU that is 0, as most of them are in any system. An idle load is reported only where
something else says that it should be connected:

- its connector is connected in part, and the other side has an output of its name;
- another component has a connector for it (`matching_connectors`), whose outputs lead nowhere;
- a component that depends on the multibody FMU has outputs of the load's dimension that lead
  nowhere.

A component without any connection is reported as well. A connection is suggested only where names
and units leave no other.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field
from functools import cached_property

import networkx as nx

from m4e_fmi.cosim.connections.links import Port, Wiring, is_carried, is_varying
from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.cosim.system.system import System
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


IDLE = re.compile(r"(body|point|joint)\..+\.(force|moment|effort)(_[xyz]|[123])?(\[.*\])?")
SHOWN = 4
"""Inputs of one component that a warning names; `info` shows all."""

Descriptions = Mapping[str, Description]


def unfed(system: System, wiring: Wiring) -> list[Port]:
    """Inputs without a connection and without a given value."""
    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {
        Port(c.name, f"{c.source.name}.{key}")  # as direction of kind: wind for wind.direction
        for c in system.components
        if isinstance(c.source, Kind)
        for key in c.source.config.model_fields_set
    }
    given |= {Port.named(text) for ts in system.inputs.values() for text in ts}
    return [port for port in wiring.unconnected if port not in given]


def is_idle_load(port: Port, descriptions: Descriptions) -> bool:
    """True if an input without a given value is a load of a multibody FMU, which is 0."""
    variable = descriptions[port.component].variables[port.variable]
    return bool(IDLE.fullmatch(port.variable)) and _number(variable) == 0.0


def loose_ends(system: System, descriptions: Descriptions, wiring: Wiring) -> list[str]:
    """Warnings of inputs and links that seem to be left out, one line each."""
    ports = unfed(system, wiring)
    loads = [port for port in ports if is_idle_load(port, descriptions)]
    idle = set(loads)
    others = [port for port in ports if port not in idle]
    links = (*wiring.links, *wiring.initial_links)
    linked = {port.component for link in links for port in link.ends}
    linked |= {text.partition(".")[0] for text in system.outputs.values()}
    linked |= {text.partition(".")[0] for texts in system.inputs.values() for text in texts}
    taken = {link.source for link in links}
    taken |= {Port.named(text) for text in system.outputs.values()}
    pairs = list(free_pairs(descriptions, driven={link.target for link in links}))
    by_component = {name: [p for p in others if p.component == name] for name in descriptions}
    fed_by_nobody = [
        _fed_by_nobody(descriptions[name], found, pairs)
        for name, found in by_component.items()
        if found and name in linked
    ]
    missing = dict(_halves(descriptions, wiring, loads))
    halves = [
        f"{load} is connected to nothing, though {group_of(load)} and {group_of(source)} are "
        f"connected by other variables: '{source} -> {load}' seems to be left out"
        for load, source in missing.items()
    ]
    open_inputs = {group_of(port) for port in others}
    unused = {
        pair.of(load): pair
        for load in loads
        for pair in pairs
        if group_of(load) in pair.ends and pair.of(load).component in linked
        if not taken & pair.outputs(pair.of(load)) and pair.of(load) not in open_inputs
    }
    led_nowhere = [
        f"{source} leads nowhere, and {pair.of(source)} takes nothing: {pair} seems to be left "
        "out; if it only watches, name its outputs under outputs:"
        for source, pair in unused.items()
    ]
    known = {port.component for port in (*missing.values(), *unused)}
    dead_ends = _dead_ends(system, descriptions, wiring, loads, known)
    return [*_alone(descriptions, linked, pairs), *fed_by_nobody, *halves, *led_nowhere, *dead_ends]


def start_text(variable: Variable) -> str:
    """The start value of a variable with its unit."""
    number = _number(variable)
    value = f"{number:g}" if number is not None else variable.start or "none"
    return f"{value} {variable.unit}".rstrip() if variable.unit not in ("", "1") else value


def _number(variable: Variable) -> float | None:
    try:
        return float(variable.start or 0.0)
    except ValueError:  # of a Boolean or String
        return None


def _alone(descriptions: Descriptions, linked: set[str], pairs: list[Pair]) -> Iterator[str]:
    """Warnings of components without any connection, where there are several components."""
    alone = [
        name
        for name, description in descriptions.items()
        if name not in linked and description.of_causality("input", "output")
    ]
    if len(descriptions) < 2:
        return
    if alone and not linked:
        yield f"{', '.join(alone)}: no component is connected with another"
        return
    for name in alone:
        left_out = _left_out(
            [pair for pair in pairs if name in {end.component for end in pair.ends}]
        )
        yield (f"{name} is connected with nothing: it does not interact with the others{left_out}")


def _left_out(pairs: list[Pair]) -> str:
    """The missing connections in brackets; empty if none are known."""
    seem = "seems" if len(pairs) == 1 else "seem"
    return f" ({', '.join(map(str, pairs))} {seem} to be left out)" if pairs else ""


def _fed_by_nobody(description: Description, ports: list[Port], pairs: list[Pair]) -> str:
    """The warning of the unconnected inputs `ports` of one component."""
    names: dict[str, str] = {}
    for port in ports:
        base, bracket, _ = port.variable.partition("[")
        name = f"{base}[…]" if bracket else base
        names.setdefault(name, start_text(description.variables[port.variable]))
    groups = {group_of(port) for port in ports}
    left_out = _left_out([pair for pair in pairs if groups & set(pair.ends)])
    if len(names) == 1:
        ((name, value),) = names.items()
        return (
            f"{ports[0].component}.{name} is connected to nothing and runs on its start value "
            f"{value}: connect it{left_out}, or set it under start: if that is meant"
        )
    shown = ", ".join(f"{name} ({value})" for name, value in list(names.items())[:SHOWN])
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return (
        f"{ports[0].component}: {len(names)} inputs are connected to nothing and run on their "
        f"start values, {shown}{more}: connect them{left_out}, or set them under start: if that is "
        "meant"
    )


def _halves(
    descriptions: Descriptions, wiring: Wiring, loads: list[Port]
) -> Iterator[tuple[Port, Port]]:
    """Loads of connectors that are connected in part, each with the output of the other side."""
    pairs = {
        (group_of(here), group_of(there))
        for link in wiring.links
        for here, there in (link.ends, link.ends[::-1])
    }
    for load in loads:
        last = load.variable.rpartition(".")[2]
        wanted = descriptions[load.component].variables[load.variable]
        for here, there in sorted(pairs):
            source = Port(there.component, f"{there.variable}.{last}")
            known = descriptions[there.component].variables.get(source.variable)
            if here != group_of(load) or known is None or known.causality != "output":
                continue
            if fits(known, wanted):
                yield load, source
                break


def _dead_ends(
    system: System,
    descriptions: Descriptions,
    wiring: Wiring,
    loads: list[Port],
    known: set[str],
) -> Iterator[str]:
    """Warnings of components that could drive idle loads of a multibody FMU, and drive nothing.

    They depend on that FMU. Those `known` are left out.
    """
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(descriptions)
    graph.add_edges_from((k.source.component, k.target.component) for k in wiring.links)
    taken = {link.source.component for link in wiring.all_links}
    taken |= {text.partition(".")[0] for text in system.outputs.values()}
    for name, description in descriptions.items():
        if name in known | taken or not graph.in_degree(name):
            continue
        before = nx.ancestors(graph, name)
        candidates = [
            (output, load)
            for load in loads
            if load.component in before
            for output in description.of_causality("output")
            if fits(output, descriptions[load.component].variables[load.variable])
        ]
        if candidates:
            driven = ", ".join(dict.fromkeys(load.component for _, load in candidates))
            yield (
                f"{name} takes inputs, but none of its outputs is connected, and loads of "
                f"{driven} are connected to nothing{_suggested(name, descriptions, candidates)}; "
                "if it only watches, name its outputs under outputs:"
            )


def _suggested(
    name: str, descriptions: Descriptions, candidates: list[tuple[Variable, Port]]
) -> str:
    """The connection from component `name` that is left out, if names and units leave only one."""
    known = [
        (output, load)
        for output, load in candidates
        if output.dimension and descriptions[load.component].variables[load.variable].dimension
    ]
    of_name = [
        (output, load)
        for output, load in candidates
        if output.name.rpartition(".")[2] == load.variable.rpartition(".")[2]
    ]
    for found in (of_name, known if len(known) == len(candidates) else []):
        if len(found) == 1:
            ((output, load),) = found
            return f": '{name}.{output.name} -> {load}' seems to be left out"
    return ""


def unconnected_parameters(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> list[str]:
    """Warnings of calculated parameters that are not carried to another component, one line each.

    The other component has a parameter of the same name, added mass for example, which would be
    left at its start value. So are matrices that are outputs.
    """
    taken = {link.source for link in wiring.all_links}
    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {link.target for link in wiring.all_links}
    calculated, varying, wanted = (
        _arrays(descriptions, causality, done)
        for causality, done in (
            ("calculatedParameter", taken), ("output", taken), ("parameter", given)
        )
    )  # fmt: skip
    offered = calculated | {key: found for key, found in varying.items() if "" not in found}
    return [
        f"{source}.{name} is calculated, but not transferred: "
        + _advice(f"{source}.{name}", f"{target}.{name}", members, others)
        for (source, name), members in offered.items()
        for (target, other), others in wanted.items()
        if name == other and source != target
    ]


def _arrays(
    descriptions: Mapping[str, Description], causality: str, done: Set[Port]
) -> dict[tuple[str, str], dict[str, Variable]]:
    """Variables that are not `done`: component and array name → index → variable.

    A scalar is an array with the index "".
    """
    found: dict[tuple[str, str], dict[str, Variable]] = {}
    for component, description in descriptions.items():
        for variable in description.of_causality(causality):
            if Port(component, variable.name) not in done:
                base, bracket, index = variable.name.partition("[")
                found.setdefault((component, base), {})[bracket + index] = variable
    return found


def _advice(
    source: str, target: str, members: dict[str, Variable], others: dict[str, Variable]
) -> str:
    """The missing connection, or the reason why the two cannot be connected."""
    if members.keys() != others.keys():
        return (
            f"{target}, which differs in size ({len(members)} and {len(others)} elements), keeps "
            "its start value"
        )
    if not all(fits(members[index], others[index]) for index in members):
        return f"{target}, which is of another type or unit, keeps its start value"
    if any(is_varying(v) and not is_carried(v, others[index]) for index, v in members.items()):
        return f"{target}, which is fixed, keeps its start value while {source} varies"
    return f"'{source} -> {target}'"
