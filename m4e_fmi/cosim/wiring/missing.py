"""Inputs, outputs, components and parameters that seem to be left without a connection.

An input that is not connected keeps its start value. That is reported, unless it is intended: a
value is given under `start:`, or in the configuration of the component, the input is one of the
system's own `inputs`, or it is an *idle load*: a force, moment or effort on a body, point or joint
of a multibody FMU that is 0, as most of them are in any system. An idle load is reported only where
something else says that it should be connected:

- its connector is connected in part, and the other side has an output of its name;
- its connector has a partner, whose outputs lead nowhere;
- a component that depends on the multibody FMU has outputs of the load's dimension that lead
  nowhere.

A component without any connection is reported as well, and a calculated parameter that is not
carried to a parameter of its name.

A connector is the variables whose names are equal up to their last dot. Two connectors of different
components are partners, whose connection is suggested, if they have the same last name, all inputs
of one are outputs of the other in the same unit, and neither fits another one of that name.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field
from itertools import combinations

import networkx as nx

from m4e_fmi.cosim.system.component import Kind
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Port, Wiring, is_carried, is_varying
from m4e_fmi.fmu.importer.reading import Description, Variable

IDLE = re.compile(r"(body|point|joint)\..+\.(force|moment|effort)(_[xyz]|[123])?(\[.*\])?")
SHOWN = 4
"""Inputs of one component that a warning names; `info` shows all."""

Descriptions = Mapping[str, Description]
Partners = Mapping[Port, Port]
"""Connectors that are free, each with the one that belongs to it."""


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
    idle, others = set(loads), dict[str, list[Port]]()
    for port in ports:
        if port not in idle:
            others.setdefault(port.component, []).append(port)
    outputs = {Port.named(text) for text in system.outputs.values()}
    outer = {Port.named(text) for texts in system.inputs.values() for text in texts} | outputs
    ends = {port for link in wiring.all_links for port in link.ends}
    linked = {port.component for port in ends | outer}
    taken = {link.source for link in wiring.all_links} | outputs
    partners = _partners(descriptions, driven={link.target for link in wiring.all_links})
    fed_by_nobody = [
        _fed_by_nobody(descriptions[name], found, partners)
        for name, found in others.items()
        if name in linked
    ]
    halves = dict(_halves(descriptions, wiring, loads))
    half_lines = [
        f"{load} is connected to nothing, though {group_of(load)} and {group_of(source)} are "
        f"connected by other variables: '{source} -> {load}' seems to be left out"
        for load, source in halves.items()
    ]
    busy = {group_of(port) for found in (taken, *others.values()) for port in found}
    unused = {
        partner: end
        for end in map(group_of, loads)
        if (partner := partners.get(end)) and partner.component in linked and partner not in busy
    }
    led_nowhere = [
        f"{partner} leads nowhere, and {end} takes nothing: {_pair(end, partner)} seems to be left "
        "out; if it only watches, name its outputs under outputs:"
        for partner, end in unused.items()
    ]
    known = {port.component for port in (*halves.values(), *unused, *taken)}
    dead_ends = _dead_ends(descriptions, wiring, loads, known)
    return [
        *_alone(descriptions, linked, partners),
        *fed_by_nobody,
        *half_lines,
        *led_nowhere,
        *dead_ends,
    ]


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


def group_of(port: Port) -> Port:
    """The connector of a variable."""
    return Port(port.component, port.variable.rpartition(".")[0])


def fits(output: Variable, target: Variable) -> bool:
    """True if the input `target` may take the value of `output`, by type and unit."""
    if output.type != target.type:
        return False
    a, b = output.dimension, target.dimension
    return a is None or b is None or a.same_dimension(b)


@dataclass(frozen=True)
class _Connector:
    """The variables of the connector `port` by causality and last word."""

    port: Port
    input: dict[str, Variable] = field(default_factory=dict)
    output: dict[str, Variable] = field(default_factory=dict)

    def fits(self, other: _Connector) -> bool:
        """True if all inputs of one are outputs of the other, and what both have agrees."""
        ways = ((self.output, other.input), (other.output, self.input))
        shared = [give.keys() & take.keys() for give, take in ways]
        return any(
            names and give.keys() >= take.keys()
            for names, (give, take) in zip(shared, ways, strict=True)
        ) and all(
            fits(give[name], take[name])
            for names, (give, take) in zip(shared, ways, strict=True)
            for name in names
        )


def _partners(descriptions: Descriptions, driven: Set[Port]) -> dict[Port, Port]:
    """Partners among the connectors none of whose inputs is `driven`, both ways."""
    found: dict[Port, _Connector] = {}
    for component, description in descriptions.items():
        for variable in description.of_causality("input", "output"):
            group, dot, last = variable.name.rpartition(".")
            if dot:
                port = Port(component, group)
                members = getattr(found.setdefault(port, _Connector(port)), variable.causality)
                members[last] = variable
    by_name: dict[str, list[_Connector]] = {}
    fed = set(map(group_of, driven))
    for port, connector in found.items():
        if port not in fed:
            by_name.setdefault(port.variable.rpartition(".")[2], []).append(connector)
    pairs = [
        (a.port, b.port)
        for same in by_name.values()
        for a, b in combinations(same, 2)
        if (a.input or b.input) and a.port.component != b.port.component and a.fits(b)
    ]
    rivals = Counter(port for pair in pairs for port in pair)
    return {
        end: other
        for a, b in pairs
        for end, other in ((a, b), (b, a))
        if rivals[a] == rivals[b] == 1
    }


def _pair(end: Port, partner: Port) -> str:
    return "'{} <-> {}'".format(*sorted((end, partner)))


def _left_out(ends: Iterable[Port], partners: Partners) -> str:
    """The missing connections of connectors, in brackets; empty if none are known."""
    pairs = sorted({_pair(end, partners[end]) for end in ends if end in partners})
    seem = "seems" if len(pairs) == 1 else "seem"
    return f" ({', '.join(pairs)} {seem} to be left out)" if pairs else ""


def _alone(descriptions: Descriptions, linked: set[str], partners: Partners) -> Iterator[str]:
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
        left_out = _left_out((end for end in partners if end.component == name), partners)
        yield f"{name} is connected with nothing: it does not interact with the others{left_out}"


def _fed_by_nobody(description: Description, ports: list[Port], partners: Partners) -> str:
    """The warning of the unconnected inputs `ports` of one component."""
    names: dict[str, str] = {}
    for port in ports:
        base, bracket, _ = port.variable.partition("[")
        name = f"{base}[…]" if bracket else base
        names.setdefault(name, start_text(description.variables[port.variable]))
    left_out = _left_out(map(group_of, ports), partners)
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
        for there in sorted(there for here, there in pairs if here == group_of(load)):
            source = Port(there.component, f"{there.variable}.{last}")
            known = descriptions[there.component].variables.get(source.variable)
            if known is not None and known.causality == "output" and fits(known, wanted):
                yield load, source
                break


def _dead_ends(
    descriptions: Descriptions, wiring: Wiring, loads: list[Port], known: Set[str]
) -> Iterator[str]:
    """Warnings of components that could drive idle loads of a multibody FMU, and drive nothing.

    They depend on that FMU. Those `known` give something, or have other warnings.
    """
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(descriptions)
    graph.add_edges_from((k.source.component, k.target.component) for k in wiring.links)
    for name, description in descriptions.items():
        if name in known or not graph.in_degree(name):
            continue
        before = nx.ancestors(graph, name)
        candidates = [
            (output.name, load)
            for load in loads
            if load.component in before
            for output in description.of_causality("output")
            if fits(output, descriptions[load.component].variables[load.variable])
        ]
        if candidates:
            driven = ", ".join(dict.fromkeys(load.component for _, load in candidates))
            alike = [
                f": '{name}.{output} -> {load}' seems to be left out"
                for output, load in candidates
                if output.rpartition(".")[2] == load.variable.rpartition(".")[2]
            ]
            yield (
                f"{name} takes inputs, but none of its outputs is connected, and loads of "
                f"{driven} are connected to nothing{alike[0] if len(alike) == 1 else ''}; "
                "if it only watches, name its outputs under outputs:"
            )


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
