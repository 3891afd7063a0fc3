"""Loops that cannot be solved at every communication point: broken by a delay of one step.

A component that steps more rarely than the system does not answer between its own points, so that
no loop through it can be solved there. Nor can one that leads over values that are not Real.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import networkx as nx

from m4e_fmi.cosim.connections.links import Link, Wiring
from m4e_fmi.cosim.connections.structure import (
    AlgebraicLoop,
    analyse,
    apart,
    exchange_graph,
    loop_links,
)
from m4e_fmi.cosim.system.component_step import ComponentStep
from m4e_fmi.fmu.importer.reading import Description


def broken(
    descriptions: Mapping[str, Description], wiring: Wiring, rates: Mapping[str, ComponentStep]
) -> tuple[Wiring, list[str]]:
    """The wiring with delays where loops cannot be solved, and what is to be said of each.

    Loops over values that are not Real are cut at one link each, until there are none. Of the
    links of a loop into the component that steps more rarely, and those out of it, the
    fewer are delayed.
    """
    found, notes = list[Link](), []
    mixed = bool(apart(wiring.links))
    while mixed and (cut := _one_of_each(wiring.links, exchange_graph(descriptions, wiring))):
        found += cut
        wiring = _delayed(wiring, cut)
    if found:
        notes = [
            f"an algebraic loop leads over values that are not Real: {', '.join(map(str, found))} "
            f"carr{'y' if len(found) > 1 else 'ies'} the value of the step before"
        ]
    for name, rate in rates.items():
        if not rate.is_sampled:
            continue
        stuck = _loop_links(descriptions, wiring, name)
        if not stuck:
            continue
        into = [link for link in stuck if link.target.component == name]
        out = [link for link in stuck if link.source.component == name]
        late = min(into, out, key=len)
        wiring = _delayed(wiring, late)
        notes.append(
            f"an algebraic loop leads through {name}, which {rate}, and is broken there: "
            f"{', '.join(map(str, late))} carr{'y' if len(late) > 1 else 'ies'} the value of the "
            "step before"
        )
    return wiring, notes


def _one_of_each(links: Sequence[Link], graph: nx.DiGraph) -> list[Link]:
    """The first link that is not Real of each knot of algebraic loops that has one."""
    found: dict[int, Link] = {}
    knot_of = {
        port: number
        for number, knot in enumerate(nx.strongly_connected_components(graph))
        for port in knot
    }
    for link in apart(loop_links(links, graph)):
        found.setdefault(knot_of[link.source], link)
    return list(found.values())


def _delayed(wiring: Wiring, late: Collection[Link]) -> Wiring:
    links = tuple(replace(k, delayed=True) if k in late else k for k in wiring.links)
    return replace(wiring, links=links)


def _loop_links(descriptions: Mapping[str, Description], wiring: Wiring, name: str) -> list[Link]:
    """The links into and out of a component that are part of an algebraic loop."""
    found = []
    for step in analyse(descriptions, wiring).exchange:
        if isinstance(step, AlgebraicLoop):
            ports = {(t.component, v) for t in (*step.sets, *step.gets) for v in t.variables}
            found += [
                link
                for link in wiring.links
                if name in (link.source.component, link.target.component)
                and (link.source.component, link.source.variable) in ports
                and (link.target.component, link.target.variable) in ports
            ]
    return found
