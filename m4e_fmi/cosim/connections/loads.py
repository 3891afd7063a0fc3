"""Forces, moments and added masses among the links: power bonds, and sums of several on one body.

A bond has the forces among the links of a connection and the velocities that they work on. Several
sources of a force or moment, or of an element of an added-mass matrix, mean their sum.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

from m4e_fmi.cosim.connections.added_mass.matrices import ELEMENT
from m4e_fmi.cosim.connections.links import (
    Axis,
    Bond,
    Link,
    Port,
    Variables,
    conversion,
    is_varying,
)
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.units import parse_unit

AXES = (
    ("force_x", "vx", "x"),
    ("force_y", "vy", "y"),
    ("force_z", "vz", "z"),
    ("moment_x", "omega_x", ""),
    ("moment_y", "omega", "theta"),
    ("moment_z", "omega_z", ""),
)
"""Force, the velocity it works on, and the coordinate of that velocity, in one connector.

Angular velocities of bodies in space are not the rates of any angles.
"""
_FORCES = {force for force, _, _ in AXES}
LOADS = tuple(map(parse_unit, ("N", "N.m")))
MATRIX = "added_mass"


def power_bonds(
    connections: Sequence[str],
    variables: Variables,
    links: Sequence[Link],
) -> Iterable[Bond]:
    """The power bonds among the links, connection by connection.

    A force is one on a body whose velocity, of the same connector, goes to any component: that of
    the force itself, or one whose force a third component adds to others.
    """
    carried = {link.source: link for link in links}
    found: dict[int, list[Axis]] = defaultdict(list)
    for force, velocity, position in AXES:
        for link in links:
            body, last = link.target.component, _last(link.target)
            connector = link.target.variable.removesuffix(last)
            back = carried.get(Port(body, connector + velocity))
            scale, shift = conversion(*link.variables(variables))
            if last == force and back and link.offset == link.factor / scale * shift:
                rate = Port(body, connector + velocity)
                moved = carried.get(Port(body, connector + position))
                if velocity == "omega" and _turns_in_space(rate, variables):
                    moved = None
                found[link.connection].append(Axis(link, back, moved, link.factor / scale))
    for index, axes in sorted(found.items()):
        sources = {axis.force.source.component for axis in axes}
        given = [link for link in links if link.target.component in sources]
        adds = dict.fromkeys(link.source.component for link in given)
        if not all(_last(link.source) in _FORCES for link in given):
            adds = {}  # its inputs are not forces only: its output is not a mere sum
        yield Bond(connections[index], tuple(axes), tuple(adds))


def _turns_in_space(omega: Port, variables: Variables) -> bool:
    """True of a body's angular velocity about Y if it has one about X as well."""
    return f"{omega.variable}_x" in variables[omega.component]


def _last(port: Port) -> str:
    return port.variable.rpartition(".")[2]


def can_be_summed(give: Variable, take: Variable) -> bool:
    """True of Reals for inputs that are forces or moments, and elements of added-mass matrices."""
    if not give.type == take.type == REAL:
        return False
    matrix = ELEMENT.fullmatch(take.name)
    if matrix and matrix[1].rpartition(".")[2] == MATRIX:
        return True
    dimension = take.dimension
    is_load = dimension is not None and any(dimension.same_dimension(load) for load in LOADS)
    return take.causality == "input" and is_load


def summed(links: Iterable[Link], variables: Variables) -> list[list[list[Link]]]:
    """Groups of targets that take the sum of several links, each target with its links in order.

    Targets of a group are of one connector or matrix, and so are their sources, one by one, which
    all vary or not.
    """
    by_target: dict[Port, list[Link]] = {}
    for link in links:
        by_target.setdefault(link.target, []).append(link)
    groups: dict[tuple[object, ...], list[list[Link]]] = {}
    for target, several in by_target.items():
        if len(several) > 1:
            gives = [link.variables(variables)[0] for link in several]
            sources = tuple((base(k.source), k.connection) for k in several)
            key = base(target), sources, tuple(map(is_varying, gives))
            groups.setdefault(key, []).append(several)
    return list(groups.values())


def sum_note(group: Sequence[Sequence[Link]]) -> str:
    """A line on a group of sums."""
    first, last = group[0][0].target, group[-1][0].target
    into = base(first) if first != last else str(first)
    givers = dict.fromkeys(base(link.source) for several in group for link in several)
    return f"{into} takes the sum of {', '.join(givers)}"


def base(port: Port) -> str:
    """Component and connector of a variable; of an element of a matrix, the matrix."""
    if matrix := ELEMENT.fullmatch(port.variable):
        return f"{port.component}.{matrix[1]}"
    group = port.variable.rpartition(".")[0]
    return f"{port.component}.{group}" if group else port.component
