"""Graph of the links: the order that it allows, and which links form algebraic loops.

Loops are solved in `network.newton`.

At one communication point an input is as new as the output it comes from, and an output with
feed-through as new as the inputs it depends on. Exchanging along the dependencies
makes all of them belong to the same instant; read in any other order, outputs would show inputs of
the step before. A delayed link carries an older value, and waits for nothing.

`Description.dependencies` of a prepared system holds the inputs that an output depends on within an
instant, from the first of these sources that exists:

===========  ===================================================================================
`STATED`     the system file declares it, under `dependencies` of the component
`DECLARED`   the FMU declares it
`PROBED`     the FMU declares nothing; inputs were moved, and the output read
             (`dependence_probing`). It may be incomplete: `late_dependence` goes on watching
`STEPPED`    likewise, but a change of the input shows after the next step: one step late
`ASSUMED`    nothing is known: the output is taken to depend on all inputs
===========  ===================================================================================
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import networkx as nx

from m4e_fmi.cosim.system.simulation import ComponentStep
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmi.errors import Problem, suggestion
from m4e_fmi.fmu.importer.reading import Description

DECLARED = "declared by its FMU"
STATED = "declared in the system file"
PROBED = "probed"
STEPPED = "probed; one step late"
ASSUMED = "assumed"
Graph: TypeAlias = "nx.DiGraph[Port]"
"""Ports, with an edge to each port that waits for another."""


def how_known(description: Description, output: str) -> str:
    """The source of an output's dependencies: one of the constants of this module."""
    if output in description.resolved:
        return description.resolved[output]
    return ASSUMED if output in description.undeclared else DECLARED


def assumed(description: Description) -> frozenset[str]:
    """Outputs with unknown dependencies."""
    return frozenset(
        variable.name
        for variable in description.of_causality("output")
        if how_known(description, variable.name) == ASSUMED
    )


def resolve(
    description: Description, found: Mapping[str, Iterable[str]], how: Mapping[str, str]
) -> Description:
    """The description with the dependencies `found` of some outputs, and `how` they are known."""
    needs = {name: frozenset(inputs) for name, inputs in found.items()}
    return replace(
        description,
        dependencies={**description.dependencies, **needs},
        resolved={**description.resolved, **how},
    )


def with_stated(system: System, descriptions: Mapping[str, Description]) -> dict[str, Description]:
    """The descriptions with the dependencies that the system file declares."""
    found = dict(descriptions)
    for component in system.components:
        needs = component.dependencies
        if needs:
            how = dict.fromkeys(needs, STATED)
            found[component.name] = resolve(found[component.name], needs, how)
    return found


def dependency_problems(
    system: System, descriptions: Mapping[str, Description]
) -> Iterable[Problem]:
    """Names under `dependencies` that are not outputs, or not inputs, of the component."""
    for component in system.components:
        description = descriptions[component.name]
        outputs, inputs = (
            [v.name for v in description.of_causality(kind)] for kind in ("output", "input")
        )
        for output, needs in component.dependencies.items():
            at = ("components", component.name, "dependencies", output)
            if output not in outputs:
                remedy = suggestion(output, outputs, "outputs")
                yield system.problem(at, f"{component.name!r} has no output {output!r}", remedy)
            for name in needs:
                if name not in inputs:
                    remedy = suggestion(name, inputs, "inputs")
                    message = f"{component.name!r} has no input {name!r}, on which {output} depends"
                    yield system.problem(at, message, remedy)


@dataclass(frozen=True)
class Transfer:
    """One FMI call of an exchange: get or set these variables of this component.

    The variables of a `discrete` transfer are not Real, or take values that are not.
    """

    action: Literal["get", "set"]
    component: str
    variables: tuple[str, ...]
    discrete: bool = False


@dataclass(frozen=True)
class AlgebraicLoop:
    """Inputs and outputs that depend on one another within an instant: to be solved together.

    `cycle` is one cycle among them: each port depends on the one before.
    """

    sets: tuple[Transfer, ...]
    gets: tuple[Transfer, ...]
    cycle: tuple[Port, ...] = ()

    @property
    def transfers(self) -> tuple[Transfer, ...]:
        """All sets, then all gets."""
        return *self.sets, *self.gets


Exchange = Sequence[Transfer | AlgebraicLoop]
"""Transfers and loops in their order."""


def transfers_of(exchange: Exchange) -> Iterator[Transfer]:
    """All transfers of an exchange, also those in loops."""
    for part in exchange:
        yield from part.transfers if isinstance(part, AlgebraicLoop) else (part,)


@dataclass(frozen=True)
class Structure:
    """Loops, transfers and order of components, as they follow from the wiring.

    `initial` are the transfers in initialization mode, `exchange` those at a communication point.
    In a loop at initialisation, inputs that are not Real have their start values. `execution_order`
    has the sources of unpredictable values first; `delayed` are the links that lead backwards in it
    all the same. `ends` are the outputs of components with connected inputs, but without connected
    Real outputs: only they show the effect of the coupling on these components.
    """

    initial: tuple[Transfer | AlgebraicLoop, ...]
    exchange: tuple[Transfer | AlgebraicLoop, ...]
    execution_order: tuple[str, ...]
    delayed: tuple[Link, ...]
    ends: tuple[Port, ...]

    @property
    def loops(self) -> tuple[tuple[Port, ...], ...]:
        """A cycle of inputs and outputs in each algebraic loop, at communication points."""
        return tuple(step.cycle for step in self.exchange if isinstance(step, AlgebraicLoop))


def analyse(descriptions: Mapping[str, Description], wiring: Wiring) -> Structure:
    """The structure of a system, from its FMUs' `descriptions` by component and its wiring."""

    def initially(port: Port) -> frozenset[str]:
        return descriptions[port.component].initial_dependencies[port.variable]

    everything = wiring.all_links
    prompt = [link for link in everything if not link.delayed]
    graph = instant_graph(prompt, [k.source for k in prompt], initially)
    unsolved = [link for _, link in _loop_links(prompt, graph) if not link.is_real]
    prompt = [link for link in prompt if link not in unsolved]
    sources = list(dict.fromkeys(link.source for link in everything))
    graph = instant_graph(prompt, sources, initially)
    graph.add_edges_from(list(_parameters_first(descriptions, prompt, graph)))
    order, delayed = execution_order(descriptions, wiring.links)
    discrete = {port for k in everything if not k.is_real for port in k.ends}
    return Structure(
        initial=_order(prompt, graph, discrete),
        exchange=_order(wiring.links, exchange_graph(descriptions, wiring), discrete),
        execution_order=order,
        delayed=delayed,
        ends=tuple(_ends(descriptions, wiring.links)),
    )


def _parameters_first(
    descriptions: Mapping[str, Description], links: Iterable[Link], graph: Graph
) -> Iterator[tuple[Port, Port]]:
    """Edges by which all outputs of a component wait for the parameters that others calculate.

    Without these its equations may have no solution, as those of a body without its mass.
    Parameters that are calculated from connected parameters keep their order.
    """

    def causality(port: Port) -> str:
        return descriptions[port.component].variables[port.variable].causality

    outputs = [port for port in graph if causality(port) == "output"]
    for link in links:
        if causality(link.source) == "calculatedParameter" and not graph.in_degree(link.source):
            own = (port for port in outputs if port.component == link.target.component)
            yield from ((link.target, port) for port in own)


def _loop_links(links: Iterable[Link], graph: Graph) -> list[tuple[int, Link]]:
    """The links that are part of algebraic loops, each with the number of its loop."""
    loops = [ports for ports in nx.strongly_connected_components(graph) if len(ports) > 1]
    loop_of = {port: number for number, ports in enumerate(loops) for port in ports}
    return [
        (loop_of[k.source], k)
        for k in links
        if k.source in loop_of and loop_of[k.source] == loop_of.get(k.target)
    ]


def exchange_graph(descriptions: Mapping[str, Description], wiring: Wiring) -> Graph:
    """The graph of the ports that wait for others at a communication point."""
    tuned = _driven_parameters(descriptions, wiring.links)

    def now(port: Port) -> frozenset[str]:
        described = descriptions[port.component]
        initially = described.initial_dependencies.get(port.variable, frozenset())
        # not known of an FMU before it is built
        later = described.dependencies.get(port.variable, frozenset())
        return later | (initially & tuned[port.component])

    chains = (link.source.derivatives(descriptions) for link in wiring.links)
    ends = _ends(descriptions, wiring.links)
    needed = dict.fromkeys((*(port for chain in chains for port in chain), *ends))
    return instant_graph(wiring.links, list(needed), now)


def _driven_parameters(
    descriptions: Mapping[str, Description], links: Iterable[Link]
) -> dict[str, set[str]]:
    """Connected tunable parameters by component.

    FMI declares the dependencies on them for initial values only; these hold later, too.
    """
    found: dict[str, set[str]] = {name: set() for name in descriptions}
    for _, target in (link.ends for link in links):
        if descriptions[target.component].variables[target.variable].causality == "parameter":
            found[target.component].add(target.variable)
    return found


def _ends(descriptions: Mapping[str, Description], links: Sequence[Link]) -> Iterator[Port]:
    """Outputs of components with connected inputs, but without connected Real outputs.

    Roll and yaw of our bodies in space are left out: they jump by a turn where the motion does not.
    """
    taken = {link.source.component for link in links if link.is_real}
    for name in dict.fromkeys(link.target.component for link in links):
        if name in taken:
            continue
        described = descriptions[name]
        # of bodies in space, which have angular velocities about all axes
        bodies = [n.removesuffix("omega_x") for n in described.variables if n.endswith(".omega_x")]
        turns = {f"{body}{turn}" for body in bodies if described.is_own for turn in ("phi", "psi")}
        for variable in described.variables.values():
            is_real = (variable.causality, variable.type) == ("output", "Real")
            if is_real and variable.name in described.dependencies and variable.name not in turns:
                yield Port(name, variable.name)


def execution_order(
    descriptions: Mapping[str, Description], links: Iterable[Link]
) -> tuple[tuple[str, ...], tuple[Link, ...]]:
    """The order of components in which sources of unpredictable values step first.

    A value with a declared derivative can be predicted and constrains nothing. Where the others
    form a cycle, the component listed first goes first. Links that then lead backwards are returned
    as well.
    """
    binding = [
        link
        for link in links
        if link.is_real
        and link.source.variable not in descriptions[link.source.component].output_derivatives
        and link.source.component != link.target.component
        and not link.delayed
    ]
    before: dict[str, set[str]] = {name: set() for name in descriptions}
    for link in binding:
        before[link.target.component].add(link.source.component)
    order: list[str] = []
    waiting = list(descriptions)
    while waiting:
        free = [name for name in waiting if before[name] <= set(order)]
        order.append((free or waiting)[0])
        waiting.remove(order[-1])
    place = {name: k for k, name in enumerate(order)}
    delayed = [k for k in binding if place[k.source.component] > place[k.target.component]]
    return tuple(order), tuple(delayed)


def instant_graph(
    links: Iterable[Link], outputs: Sequence[Port], depends: Callable[[Port], Iterable[str]]
) -> Graph:
    """The graph of the ports that wait for others at one instant."""
    links = list(links)
    driven = dict.fromkeys(link.target for link in links)
    graph: Graph = nx.DiGraph()
    graph.add_nodes_from((*outputs, *driven))
    for output in outputs:
        known = (Port(output.component, name) for name in depends(output))
        graph.add_edges_from((port, output) for port in known if port in driven)
    graph.add_edges_from(link.ends for link in links if not link.delayed)
    return graph


def _order(
    links: Sequence[Link], graph: Graph, discrete: Container[Port]
) -> tuple[Transfer | AlgebraicLoop, ...]:
    """Gets and sets that carry over each value when it is final."""
    driven = {link.target for link in links}
    steps: list[Transfer | AlgebraicLoop] = []
    transfers: list[Transfer] = []
    condensed = nx.condensation(graph)
    for generation in nx.topological_generations(condensed):
        # a generation is all inputs or outputs that wait for nothing but earlier generations
        members = [condensed.nodes[group]["members"] for group in generation]
        single = [port for ports in members if len(ports) == 1 for port in ports]
        transfers += _transfers(single, driven, discrete)
        for ports in members:
            if len(ports) > 1:
                calls = _transfers(ports, driven, discrete)
                steps += _merged(transfers)
                transfers = []
                sets, gets = ([t for t in calls if t.action == a] for a in ("set", "get"))
                steps.append(AlgebraicLoop(tuple(sets), tuple(gets), _cycle(graph, ports)))
    return (*steps, *_merged(transfers))


def _transfers(
    ports: Iterable[Port], driven: Container[Port], discrete: Container[Port]
) -> list[Transfer]:
    by_call: dict[tuple[Literal["get", "set"], str, bool], list[str]] = {}
    for port in sorted(ports):
        action: Literal["get", "set"] = "set" if port in driven else "get"
        call = action, port.component, port in discrete
        by_call.setdefault(call, []).append(port.variable)
    calls = [Transfer(a, c, tuple(names), apart) for (a, c, apart), names in by_call.items()]
    return sorted(calls, key=lambda call: call.action == "set")  # some lose outputs when set


def _merged(transfers: list[Transfer]) -> tuple[Transfer, ...]:
    """Fewer, larger calls: sets of one component with no get of it in between become one."""
    result: list[Transfer] = []
    for transfer in transfers:
        same = [k for k, t in enumerate(result) if t.component == transfer.component]
        alike = replace(result[same[-1]], variables=transfer.variables) if same else None
        if transfer.action == "set" and alike == transfer:
            names = (*result.pop(same[-1]).variables, *transfer.variables)
            transfer = replace(transfer, variables=names)
        result.append(transfer)
    return tuple(result)


def _cycle(graph: Graph, members: Iterable[Port]) -> tuple[Port, ...]:
    """A cycle among the ports of a loop, beginning with the first by name."""
    ports = [edge[0] for edge in nx.find_cycle(graph.subgraph(members))]
    start = ports.index(min(ports))
    return (*ports[start:], *ports[:start])


def broken(
    descriptions: Mapping[str, Description], wiring: Wiring, rates: Mapping[str, ComponentStep]
) -> tuple[Wiring, list[str]]:
    """The wiring with delays of one step where loops cannot be solved, and a note on each.

    Loops over values that are not Real are cut at one link each, until there are none. A component
    that steps more rarely than the system does not answer between its own points: in a loop through
    it, the links into or those out of it are delayed, whichever are fewer.
    """
    found, notes = list[Link](), []
    mixed = not all(link.is_real for link in wiring.links)
    while mixed and (cut := _first_not_real(descriptions, wiring)):
        found += cut
        wiring = _delayed(wiring, cut)
    if found:
        notes = [f"an algebraic loop leads over values that are not Real: {_late_text(found)}"]
    for name, rate in rates.items():
        if not rate.is_longer:
            continue
        stuck = [k for _, k in _loop_links(wiring.links, exchange_graph(descriptions, wiring))]
        into = [link for link in stuck if link.target.component == name]
        out = [link for link in stuck if link.source.component == name]
        if late := min(into, out, key=len):
            wiring = _delayed(wiring, late)
            notes.append(
                f"an algebraic loop leads through {name}, which {rate}, and is broken there: "
                f"{_late_text(late)}"
            )
    return wiring, notes


def _first_not_real(descriptions: Mapping[str, Description], wiring: Wiring) -> list[Link]:
    """The first link that is not Real of each algebraic loop that has one."""
    first: dict[int, Link] = {}
    for loop, link in _loop_links(wiring.links, exchange_graph(descriptions, wiring)):
        if not link.is_real:
            first.setdefault(loop, link)
    return list(first.values())


def _delayed(wiring: Wiring, late: Collection[Link]) -> Wiring:
    links = tuple(replace(k, delayed=True) if k in late else k for k in wiring.links)
    return replace(wiring, links=links)


def _late_text(late: Collection[Link]) -> str:
    verb = "have" if len(late) > 1 else "has"
    return f"{', '.join(map(str, late))} {verb} the value of the previous step"
