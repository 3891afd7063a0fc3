"""Buses: named signals between a source and its takers.

A bus is declared with its signals and their units; a signal that is not Real has its type in place
of the unit. In a connection a bus stands where a component stands. Each signal has one source, of
its dimension; values are converted to the signal's unit, and from there to each taker's. Nothing
passes through a bus at run time: a connection to it and one from it make one link.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from m4e_fmi.cosim.connections.links import BusSignal, Link, Port
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.fmu.importer.type_rules import REAL, TYPES
from m4e_fmi.units import parse_unit

BUS = "bus"
"""Causality of a signal: it may be source and target."""
Buses = Mapping[str, Mapping[str, str]]
"""Units of the signals of each bus, by name."""


def bus_variables(buses: Buses) -> dict[str, dict[str, Variable]]:
    """The signals of each bus, as variables; without dimension where the unit is not known."""
    return {
        bus: {name: _variable(name, unit) for name, unit in signals.items()}
        for bus, signals in buses.items()
    }


def bus_problems(system: System) -> Iterator[Problem]:
    """Problems of the declarations of a system's buses."""
    components = {component.name for component in system.components}
    for bus, signals in system.buses.items():
        if bus in components:
            message = f"{bus!r} is a bus, and also a component"
            yield system.problem(("buses", bus), message, "rename one of the two")
        for name, unit in signals.items():
            if unit in TYPES:
                continue
            try:
                parse_unit(unit)
            except ValueError as error:
                remedy = "write it like N.s/m or kg.m2, and 1 for none; or a type, like Boolean"
                yield system.problem(("buses", bus, name), str(error), remedy)


def through_buses(links: Iterable[Link], buses: Buses) -> tuple[list[Link], list[BusSignal]]:
    """The links from component to component, and the signals of all buses.

    A link through a bus counts as one of the connection that takes the signal.
    """
    givers: dict[Port, Link] = {}
    takers: dict[Port, list[Link]] = {}
    found: list[Link] = []
    for link in links:
        if link.target.component in buses:
            givers[link.target] = link
        elif link.source.component in buses:
            takers.setdefault(link.source, []).append(link)
        else:
            found.append(link)
    for signal, taking in takers.items():
        if signal in givers:
            found += (_joined(givers[signal], link) for link in taking)
    found.sort(key=lambda link: link.connection)
    given = {(port.component, port.variable): link.source for port, link in givers.items()}
    taken = {
        (port.component, port.variable): tuple(link.target for link in taking)
        for port, taking in takers.items()
    }
    signals = [
        BusSignal(bus, name, unit, given.get((bus, name)), taken.get((bus, name), ()))
        for bus, units in buses.items()
        for name, unit in units.items()
    ]
    return found, signals


def _joined(giving: Link, taking: Link) -> Link:
    """One link of two: ``taking.factor · (giving.factor · y + giving.offset) + taking.offset``."""
    factor = taking.factor * giving.factor
    offset = taking.factor * giving.offset + taking.offset
    delayed = giving.delayed or taking.delayed
    return replace(taking, source=giving.source, factor=factor, offset=offset, delayed=delayed)


def _variable(name: str, unit: str) -> Variable:
    kind = unit if unit in TYPES else REAL
    unit = unit if kind == REAL else ""
    try:
        dimension = parse_unit(unit)
    except ValueError:
        dimension = None
    return Variable(
        name=name,
        value_reference=0,
        type=kind,
        causality=BUS,
        variability="continuous" if kind == REAL else "discrete",
        initial=None,
        unit=unit,
        dimension=dimension,
        offset=0.0,
        description="",
        derivative_of=None,
    )
