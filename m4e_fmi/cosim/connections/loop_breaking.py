"""Delays of one step that break loops which cannot be solved at every communication point.

A component that steps more rarely than the system does not answer between its own points, so that
no loop through it can be solved there. Nor can a loop over values that are not Real.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import networkx as nx

from m4e_fmi.cosim.connections.links import Link, Port, Wiring
from m4e_fmi.cosim.connections.structure import (
    AlgebraicLoop,
    Graph,
    analyse,
    exchange_graph,
    loop_links,
    not_real,
)
from m4e_fmi.cosim.system.component_step import ComponentStep
from m4e_fmi.fmu.importer.reading import Description


def broken(
    descriptions: Mapping[str, Description], wiring: Wiring, rates: Mapping[str, ComponentStep]
) -> tuple[Wiring, list[str]]:
    """The wiring with delays where loops cannot be solved, and a note on each.

    Loops over values that are not Real are cut at one link each, until there are none. In a loop
    through a component that steps more rarely, the links into or those out of it are delayed,
    whichever are fewer.
    """
    found, notes = list[Link](), []
    mixed = bool(not_real(wiring.links))
    while mixed and (cut := _one_of_each(wiring.links, exchange_graph(descriptions, wiring))):
        found += cut
        wiring = _delayed(wiring, cut)
    if found:
        notes = [
            f"an algebraic loop leads over values that are not Real: {', '.join(map(str, found))} "
            f"{'have' if len(found) > 1 else 'has'} the value of the previous step"
        ]
    for name, rate in rates.items():
        if not rate.is_longer:
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
            f"{', '.join(map(str, late))} {'have' if len(late) > 1 else 'has'} the value of the "
            "previous step"
        )
    return wiring, notes


def _one_of_each(links: Sequence[Link], graph: Graph) -> list[Link]:
    """The first link that is not Real of each group of algebraic loops that has one."""
    found: dict[int, Link] = {}
    group_of = {
        port: number
        for number, group in enumerate(nx.strongly_connected_components(graph))
        for port in group
    }
    for link in not_real(loop_links(links, graph)):
        found.setdefault(group_of[link.source], link)
    return list(found.values())


def _delayed(wiring: Wiring, late: Collection[Link]) -> Wiring:
    links = tuple(replace(k, delayed=True) if k in late else k for k in wiring.links)
    return replace(wiring, links=links)


def _loop_links(descriptions: Mapping[str, Description], wiring: Wiring, name: str) -> list[Link]:
    """The links into and out of a component that are part of an algebraic loop."""
    found: list[Link] = []
    for step in analyse(descriptions, wiring).exchange:
        if isinstance(step, AlgebraicLoop):
            ports = {Port(t.component, v) for t in step.transfers for v in t.variables}
            found += [
                link
                for link in wiring.links
                if name in {port.component for port in link.ends} and ports.issuperset(link.ends)
            ]
    return found
