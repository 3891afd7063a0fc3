"""From connection texts to links, with every check that needs no running FMU.

A calculated parameter is carried over into a parameter once, at initialisation. An output may lead
into a tunable parameter, and is then carried at every communication point, as into an input
(`is_carried`); into a fixed one it may not. Values are converted where units differ; `type_rules`
tells which types fit.

A bus of the system (`buses`) may stand on either side, its signals as a component's variables. Its
name alone is the connector of all its signals that have no dot.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from m4e_fmi.cosim.connections.added_mass.order import body_order_problems
from m4e_fmi.cosim.connections.buses import bus_problems, bus_variables, through_buses
from m4e_fmi.cosim.connections.dependence import dependency_problems
from m4e_fmi.cosim.connections.link_checks import (
    bus_link_problems,
    delay_problems,
    double_load_problems,
    fixed_parameter_problems,
    input_derivative_problems,
    outer_port_problems,
)
from m4e_fmi.cosim.connections.links import (
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
from m4e_fmi.fmu.importer.reading import Description


def connect(system: System, descriptions: Mapping[str, Description]) -> Wiring:
    """The wiring of `system`, whose components' FMUs have these `descriptions`.

    InputError with all problems found, each at its connection's place.
    """
    resolved = _resolved(system, descriptions)
    if resolved.problems:
        raise InputError(resolved.problems)
    variables = resolved.variables
    links = sorted(resolved.links, key=lambda link: link.connection)
    steady = tuple(link for link in links if is_carried(*link.variables(variables)))
    driven = {link.target for link in steady}
    inputs = [Port(c, v.name) for c, d in descriptions.items() for v in d.of_causality("input")]
    real = [link for link in steady if link.is_real]
    return Wiring(
        links=steady,
        initial_links=tuple(k for k in links if not is_carried(*k.variables(variables))),
        bonds=tuple(power_bonds(system.connections, variables, real)),
        unconnected=tuple(port for port in inputs if port not in driven),
        signals=tuple(resolved.signals),
        notes=tuple(map(sum_note, summed(links, variables))),
    )


@dataclass(frozen=True)
class _Resolved:
    """Links between components, signals of the buses, all variables; all problems found."""

    links: list[Link]
    signals: list[BusSignal]
    variables: Variables
    problems: list[Problem]


def _resolved(system: System, descriptions: Mapping[str, Description]) -> _Resolved:
    """The connections of `system`, resolved and checked."""
    problems = list(bus_problems(system))
    components = {name: description.variables for name, description in descriptions.items()}
    variables: Variables = {**bus_variables(system.buses), **components}
    links: list[Link] = []
    for index, text in enumerate(system.connections):
        links += Pairing(system, variables, index, text, problems).links()
    links = _without_given(system, variables, links)
    links = _one_source_each(system, variables, links, problems)
    links, signals = through_buses(links, system.buses)
    links = [replace(link, kind=link.variables(variables)[0].type) for link in links]
    driven = {link.target for link in links}
    found: list[Iterable[Problem]] = [
        bus_link_problems(system, variables, links),
        start_problems(system, descriptions),
        dependency_problems(system, descriptions),
        delay_problems(system, variables, links),
        double_load_problems(system, variables, links),
        fixed_parameter_problems(system, variables, links),
        input_derivative_problems(system, descriptions, links),
        body_order_problems(system, variables, links),
        outer_port_problems(system, descriptions, driven),
        unset_masses(system, descriptions, {str(port) for port in driven}),
    ]
    problems += [problem for group in found for problem in group]
    return _Resolved(links, signals, variables, problems)


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
