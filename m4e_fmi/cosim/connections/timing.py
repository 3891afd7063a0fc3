"""Delay between each connected input and its source, under the system's algorithm.

During a step an algorithm knows some outputs only as they were at its start, and others over the
whole step.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum

import networkx as nx

from m4e_fmi.cosim.connections.links import Link, Wiring
from m4e_fmi.cosim.connections.structure import Structure
from m4e_fmi.cosim.system.component_step import ComponentStep
from m4e_fmi.coupling_algorithms import LinkDelay, algorithm_descriptor
from m4e_fmi.fmu.importer.reading import Description


class Timing(Enum):
    """How an input follows its source during a step; the values are texts for a person."""

    KNOWN = "in time: its source has already made the step"
    SOLVED = "in time: solved together with its source"
    CORRECTED = "in time: corrected by a second pass"
    PREDICTED = "predicted from derivatives that its FMU declares"
    EXTRAPOLATED = "extrapolated from the step before"
    LATE = "one step late: held at its value at the start of the step"
    TAKEN = "sampled at the points of a component that steps less often"
    DELAYED = "one step late, as its connection says: held at its source's previous value"
    HELD = "held between the points of a component that steps less often"
    SWITCHED = "held during each step: a change acts from the end of its step"


def timings(
    descriptions: Mapping[str, Description],
    wiring: Wiring,
    structure: Structure,
    algorithm: str,
    rates: Mapping[str, ComponentStep],
) -> dict[Link, Timing]:
    """The timing of every link that carries values at communication points."""

    def skips(component: str) -> bool:
        return component in rates and rates[component].is_longer

    followed = [
        link
        for link in wiring.links
        if link.is_real
        and not (link.delayed or skips(link.source.component) or skips(link.target.component))
    ]
    cycles = component_cycles(descriptions, followed)
    cycle_of = {name: cycle for cycle in cycles for name in cycle}
    corrects = not structure.loops and all(
        any(descriptions[name].saves_state for name in cycle) for cycle in cycles
    )
    place = {name: k for k, name in enumerate(structure.execution_order)}
    delay = algorithm_descriptor(algorithm).link_delay

    def in_order(link: Link) -> Timing:
        source, target = link.source, link.target
        if place[source.component] < place[target.component]:
            return Timing.KNOWN
        if source.variable in descriptions[source.component].output_derivatives:
            return Timing.PREDICTED
        return Timing.EXTRAPOLATED

    def timing(link: Link) -> Timing:
        if link.delayed:
            return Timing.DELAYED
        if skips(link.target.component):
            return Timing.TAKEN
        if skips(link.source.component):
            return Timing.HELD
        if not link.is_real:
            return Timing.SWITCHED
        if delay is LinkDelay.ONE_STEP:
            return Timing.LATE
        if delay is LinkDelay.SOLVED:
            return Timing.SOLVED
        if delay is LinkDelay.EXECUTION_ORDER or not corrects:
            return in_order(link)
        if link.target.component not in cycle_of.get(link.source.component, ()):
            return Timing.KNOWN
        returns = descriptions[link.target.component].saves_state
        return Timing.CORRECTED if returns else in_order(link)

    return {link: timing(link) for link in wiring.links}


def component_cycles(names: Iterable[str], links: Iterable[Link]) -> list[frozenset[str]]:
    """Sets of components that depend on one another in a cycle of connections."""
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(names)
    graph.add_edges_from((link.source.component, link.target.component) for link in links)
    return [
        frozenset(group)
        for group in nx.strongly_connected_components(graph)
        if len(group) > 1 or any(graph.has_edge(name, name) for name in group)
    ]
