"""Buses in packages: SSP has none, so connections through them are written from end to end.

So are those of several sources that add up, which go through components that are sums.

What the system says of buses, and all its connections, is in an annotation. Reading takes it up
again if it still means what the package connects. Other tools see the plain connections only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.connections.links import SAME_UNIT, Link, Wiring, conversion
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.ssp.package import Package
from m4e_fmi.cosim.system.connection_text import Connection, parse_connection
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Description


def annotated(system: System) -> dict[str, Any]:
    """Content of the annotation of a package about the system's buses."""
    if not system.buses:
        return {}
    buses = {name: dict(signals) for name, signals in system.buses.items()}
    return {"buses": buses, "connections": list(system.connections)}


def flattened(prepared: Prepared) -> Prepared:
    """The same system with connections from component to component in place of its buses."""
    system, texts = prepared.system, tuple(_flat(prepared))
    if texts == system.connections:
        return prepared
    flat = replace(system, buses={}, connections=texts)
    return replace(prepared, system=flat, wiring=connect(flat, prepared.descriptions))


def _flat(prepared: Prepared) -> Iterator[str]:
    wiring = prepared.wiring
    for index, text in enumerate(prepared.system.connections):
        written = parse_connection(text)
        own = [link for link in wiring.all_links if link.connection == index]
        ends = {end.partition(".")[0] for end in (written.left, written.right)}
        if ends.issuperset(port.component for link in own for port in link.ends):
            yield text
        else:
            yield from (str(_connection(link, prepared.descriptions)) for link in own)


def _connection(link: Link, descriptions: Mapping[str, Description]) -> Connection:
    """The text of a link, whose factor and offset act after the conversion of units."""
    give, take = (descriptions[p.component].variables[p.variable] for p in link.ends)
    one, other = give.dimension, take.dimension
    ignored = one is not None and other is not None and not one.same_dimension(other)
    scale, shift = (1.0, 0.0) if ignored else conversion(give, take)
    factor = link.factor / scale
    if math.isclose(factor, 1.0, rel_tol=SAME_UNIT):
        factor = 1.0
    return Connection(
        str(link.source),
        str(link.target),
        factor=factor,
        offset=link.offset - factor * shift,
        units_ignored=ignored,
        delayed=link.delayed,
    )


def restored(
    package: Package,
    system: System,
    told: Mapping[str, Any],
    descriptions: Mapping[str, Description],
) -> System:
    """The system with the buses that its annotation tells of, if its connections mean the same."""
    buses, connections = told.get("buses"), told.get("connections")
    if not buses or not isinstance(buses, dict) or not isinstance(connections, list):
        return system
    try:
        units = {str(bus): dict(signals) for bus, signals in buses.items()}
        whole = replace(system, buses=units, connections=tuple(map(str, connections)))
        if _alike(connect(whole, descriptions), connect(system, descriptions)):
            return whole
    except (InputError, TypeError, ValueError):
        pass  # what stands alone is checked when the system is prepared
    package.note(
        "its buses differ from the package's connections: components are connected directly"
    )
    return replace(system, notes=tuple(package.notes))


def _alike(one: Wiring, other: Wiring) -> bool:
    """True if two wirings carry the same values."""
    mine, others = ({k.ends: k for k in wiring.all_links} for wiring in (one, other))
    return mine.keys() == others.keys() and all(
        math.isclose(link.factor, others[ends].factor, rel_tol=SAME_UNIT)
        and math.isclose(link.offset, others[ends].offset, rel_tol=SAME_UNIT, abs_tol=SAME_UNIT)
        and link.delayed == others[ends].delayed
        for ends, link in mine.items()
    )
