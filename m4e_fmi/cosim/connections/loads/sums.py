"""Sums of forces, moments and added masses that several connections lead to one input.

Several sources of a force or moment, or of an element of an added-mass matrix, mean their sum.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from m4e_fmi.cosim.connections.added_mass.matrices import ELEMENT
from m4e_fmi.cosim.connections.links import Link, Port, Variables, is_varying
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.units import parse_unit

LOADS = tuple(map(parse_unit, ("N", "N.m")))
MATRIX = "added_mass"


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
