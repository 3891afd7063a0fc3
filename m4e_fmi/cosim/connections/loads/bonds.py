"""Power bonds: the forces among the links, and the velocities that they work on."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

from m4e_fmi.cosim.connections.links import Axis, Bond, Link, Port, Variables, conversion

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
