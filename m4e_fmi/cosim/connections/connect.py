"""From connection texts to links, with every check that needs no running FMU.

A calculated parameter is carried over into a parameter once, at initialisation. An output may lead
into a tunable parameter, and is then carried at every communication point, as into an input
(`is_carried`); into a fixed one it may not. Values are converted where units differ; `type_rules`
tells which types fit.

A bus of the system may stand on either side. It is declared with its signals and their units; a
signal that is not Real has its type in place of the unit. Its name alone is the connector of all
signals without a dot. Each signal has one source, of its dimension; values are converted to the
signal's unit, and from there to each taker's. A connection to a bus and one from it make one link
here: nothing passes through a bus at run time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from m4e_fmi.cosim.connections.added_mass.order import body_order_problems
from m4e_fmi.cosim.connections.dependence import dependency_problems
from m4e_fmi.cosim.connections.link_checks import (
    double_load_problems,
    input_derivative_problems,
    link_problems,
    outer_port_problems,
)
from m4e_fmi.cosim.connections.links import (
    BUS,
    BusSignal,
    Link,
    Port,
    Variables,
    Wiring,
    is_carried,
)
from m4e_fmi.cosim.connections.loads import can_be_summed, power_bonds, sum_note, summed
from m4e_fmi.cosim.connections.missing.neutral_mass import unset_masses
from m4e_fmi.cosim.connections.pairing import Pairing
from m4e_fmi.cosim.system.start_values import start_problems
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.fmu.importer.reading import Description, Variable
from m4e_fmi.fmu.importer.type_rules import REAL, TYPES
from m4e_fmi.units import parse_unit


def connect(system: System, descriptions: Mapping[str, Description]) -> Wiring:
    """The wiring of `system`, whose components' FMUs have these `descriptions`.

    InputError with all problems of connections, start values, and the system's inputs and outputs,
    each at its place.
    """
    links, signals, variables = _resolved(system, descriptions)
    links = sorted(links, key=lambda link: link.connection)
    steady = tuple(link for link in links if is_carried(*link.variables(variables)))
    driven = {link.target for link in steady}
    inputs = [Port(c, v.name) for c, d in descriptions.items() for v in d.of_causality("input")]
    real = [link for link in steady if link.is_real]
    return Wiring(
        links=steady,
        initial_links=tuple(k for k in links if not is_carried(*k.variables(variables))),
        bonds=tuple(power_bonds(system.connections, variables, real)),
        unconnected=tuple(port for port in inputs if port not in driven),
        signals=tuple(signals),
        notes=tuple(map(sum_note, summed(links, variables))),
    )


def _resolved(
    system: System, descriptions: Mapping[str, Description]
) -> tuple[list[Link], list[BusSignal], Variables]:
    """Links between components, signals of the buses, and all variables; InputError."""
    problems = list(_bus_problems(system))
    components = {name: description.variables for name, description in descriptions.items()}
    variables: Variables = {**_bus_variables(system), **components}
    links: list[Link] = []
    pairing = Pairing(system, variables)
    for index in range(len(system.connections)):
        try:
            links.extend(pairing.links(index))  # those before a problem stay
        except InputError as error:
            at = ("connections", index)
            problems += [system.problem(at, p.message, p.remedy) for p in error.problems]
    links = _without_given(system, variables, links)
    links = _one_source_each(system, variables, links, problems)
    links, signals = _through_buses(links, system)
    links = [replace(link, kind=link.variables(variables)[0].type) for link in links]
    driven = {link.target for link in links}
    found: list[Iterable[Problem]] = [
        link_problems(system, variables, links),
        start_problems(system, descriptions),
        dependency_problems(system, descriptions),
        double_load_problems(system, variables, links),
        input_derivative_problems(system, descriptions, links),
        body_order_problems(system, variables, links),
        outer_port_problems(system, descriptions, driven),
        unset_masses(system, descriptions, {str(port) for port in driven}),
    ]
    problems += [problem for group in found for problem in group]
    if problems:
        raise InputError(problems)
    return links, signals, variables


def _without_given(system: System, variables: Variables, links: list[Link]) -> list[Link]:
    """`links` without those of '<->' into parameters that are given in another way."""

    def implied(link: Link) -> bool:
        target = variables[link.target.component][link.target.variable]
        return target.causality == "parameter" and "<->" in system.connections[link.connection]

    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {link.target for link in links if not implied(link)}
    return [link for link in links if not (implied(link) and link.target in given)]


def _one_source_each(
    system: System, variables: Variables, links: list[Link], problems: list[Problem]
) -> list[Link]:
    """The first link from each source into each target, which has one source, or takes a sum.

    Adds to `problems` where a target that takes no sum has another source, and where a source has
    two factors.
    """
    first: dict[tuple[Port, Port], Link] = {}
    sources: dict[Port, Link] = {}
    for link in links:
        give, target = link.variables(variables)
        other = sources.setdefault(link.target, link)
        if other.source != link.source and not can_be_summed(give, target):
            message = f"{link.target} has two sources: {other.source} and {link.source}"
            remedy = (
                f"drop one (the other is connected by {system.connections[other.connection]!r}), "
                "or connect both to a component of 'kind: sum', and its sum here; forces, moments "
                "and added masses add up without one"
            )
            problems.append(system.problem(("connections", link.connection), message, remedy))
            continue
        known = first.setdefault(link.ends, link)
        if (known.factor, known.offset) != (link.factor, link.offset):
            message = f"{link} is connected twice, by factors {known.factor:g} and {link.factor:g}"
            remedy = f"drop one (the other is {system.connections[known.connection]!r})"
            problems.append(system.problem(("connections", link.connection), message, remedy))
        if known is not link and link.delayed:  # beside a connector that carries it, too
            first[link.ends] = link
    return list(first.values())


def _bus_variables(system: System) -> Variables:
    """The signals of each bus, as variables; without dimension where the unit is not known."""
    return {
        bus: {name: _signal(name, unit) for name, unit in signals.items()}
        for bus, signals in system.buses.items()
    }


def _signal(name: str, unit: str) -> Variable:
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


def _bus_problems(system: System) -> Iterator[Problem]:
    """Problems of the declarations of a system's buses."""
    components = {component.name for component in system.components}
    for bus, signals in system.buses.items():
        if bus in components:
            message = f"{bus!r} is a bus, and also a component"
            yield system.problem(("buses", bus), message, "rename one of the two")
        for name, unit in signals.items():
            try:
                parse_unit("1" if unit in TYPES else unit)
            except ValueError as error:
                remedy = "write it like N.s/m or kg.m2, and 1 for none; or a type, like Boolean"
                yield system.problem(("buses", bus, name), str(error), remedy)


def _through_buses(links: Iterable[Link], system: System) -> tuple[list[Link], list[BusSignal]]:
    """The links from component to component, and the signals of all buses.

    A link through a bus counts as one of the connection that takes the signal.
    """
    givers: dict[Port, Link] = {}
    takers: dict[Port, list[Link]] = {}
    found: list[Link] = []
    for link in links:
        if link.target.component in system.buses:
            givers[link.target] = link
        elif link.source.component in system.buses:
            takers.setdefault(link.source, []).append(link)
        else:
            found.append(link)
    signals: list[BusSignal] = []
    for bus, units in system.buses.items():
        for name, unit in units.items():
            port = Port(bus, name)
            giving, taking = givers.get(port), takers.get(port, [])
            found += (_joined(giving, link) for link in taking if giving)
            targets = tuple(link.target for link in taking)
            signals.append(BusSignal(bus, name, unit, giving.source if giving else None, targets))
    return sorted(found, key=lambda link: link.connection), signals


def _joined(giving: Link, taking: Link) -> Link:
    """One link of two: ``taking.factor · (giving.factor · y + giving.offset) + taking.offset``."""
    factor = taking.factor * giving.factor
    offset = taking.factor * giving.offset + taking.offset
    delayed = giving.delayed or taking.delayed
    return replace(taking, source=giving.source, factor=factor, offset=offset, delayed=delayed)
