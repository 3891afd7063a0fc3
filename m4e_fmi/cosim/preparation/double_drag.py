"""Drag and wave forces of one body in two components: allowed, as parts of a hull may differ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

from m4e_fmi.cosim.connections.links import Port, Wiring
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.fmu import Description

DRAG = ("drag_", "linear_drag_")
"""Beginnings of the last names of a hull's drag coefficients; `drag_force_…` are outputs."""


def double_drag(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> Iterator[str]:
    """A line on each two components that move with one body and both have drag on it."""
    for source, takers in moved_together(wiring).items():
        acting = [port for port in takers if _has_drag(system, descriptions, port)]
        for one, other in combinations(acting, 2):
            body, first, second = (str(p).removesuffix(".z") for p in (source, one, other))
            yield (
                f"{first} and {second} both have drag on {body}: right for different parts of it; "
                "of the same part leave it to one of them"
            )


def moved_together(wiring: Wiring) -> dict[Port, list[Port]]:
    """Heights that components take, by the height of the body that they follow."""
    moved: dict[Port, list[Port]] = {}
    for link in wiring.links:
        if link.source.variable.endswith(".z") and link.target.variable.endswith(".z"):
            moved.setdefault(link.source, []).append(link.target)
    return moved


def _has_drag(system: System, descriptions: Mapping[str, Description], port: Port) -> bool:
    """True if the component gives drag on the body whose height is `port`.

    A hull's coefficients are parameters of the body; members have their own.
    """
    body = port.variable.removesuffix("z")
    variables = descriptions[port.component].variables
    if f"{body}drag_force_z" not in variables:
        return False
    start = next(c.start for c in system.components if c.name == port.component)
    coefficients = [
        variable
        for name, variable in variables.items()
        if name.startswith(tuple(body + part for part in DRAG))
        and variable.causality == "parameter"
    ]
    values = (value_of(v, start.get(v.name, float(v.start or 0.0))) for v in coefficients)
    return not coefficients or any(value != 0.0 for value in values)
