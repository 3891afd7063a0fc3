"""Connections that would give the added mass of one body to another one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from m4e_fmi.cosim.connections.added_mass.matrices import (
    BODY,
    Pairs,
    added_mass_bodies,
    connected_bodies,
    group,
    in_order,
    moving,
)
from m4e_fmi.cosim.connections.links import Link, Variables
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import Problem


def body_order_problems(
    system: System, variables: Variables, links: Sequence[Link]
) -> Iterator[Problem]:
    """One problem per connection of matrices that pairs other bodies than forces and motions do.

    Not checked are matrices of other tools, and bodies whose forces and motions all go through
    third components.
    """
    bodies = {component: added_mass_bodies(table) for component, table in variables.items()}
    exchanged = moving(variables, links)
    pairs = connected_bodies(exchanged)
    used = {(port.component, group(port)) for link in exchanged for port in link.ends}
    told: set[int] = set()
    for link in links:
        source, target = link.ends
        given = bodies[source.component].get(source.variable)
        taken = bodies[target.component].get(target.variable)
        joined = pairs.get((source.component, target.component))
        if link.connection in told or joined is None or given is None or taken is None:
            continue
        pairing = _Pairing(
            source.component,
            target.component,
            in_order(bodies[source.component]),
            in_order(bodies[target.component]),
            joined,
        )
        for body, other in zip(given, taken, strict=True):
            if pairing.excludes(body, other, idle=(source.component, body) not in used):
                told.add(link.connection)
                at = ("connections", link.connection)
                yield system.problem(at, pairing.message(body, other), pairing.remedy)
                break


@dataclass(frozen=True)
class _Pairing:
    """Two components, the bodies of their matrices in order, and the `pairs` that are connected."""

    water: str
    model: str
    given: Sequence[str]
    taken: Sequence[str]
    pairs: Pairs

    def excludes(self, body: str, other: str, *, idle: bool) -> bool:
        """True if `other` of the model is not `body` in the water; `idle` if nothing moves that."""
        if (body, other) in self.pairs:
            return False
        return idle or any(body == water or other == name for water, name in self.pairs)

    def message(self, body: str, other: str) -> str:
        """Both orders, and the first bodies that differ."""
        return (
            f"the added mass of {self.water}.{body} would act on {self.model}.{BODY}{other}, with "
            f"which it is not connected: rows of {self.water} are for {', '.join(self.given)}, "
            f"those of {self.model} for {', '.join(self.taken)}"
        )

    @property
    def remedy(self) -> str:
        """The order that is right, or how the bodies would be the same."""
        of_water: Mapping[str, str] = {name: body for body, name in sorted(self.pairs)}
        order = [of_water.get(name, "") for name in self.taken]
        if sorted(order) == sorted(self.given):
            return f"write the bodies of {self.water!r} in the order {', '.join(order)}"
        return (
            f"connect each body of {self.water!r}, and in the model write 'added_mass: true' at "
            "the bodies that these are connected with, at no others"
        )
