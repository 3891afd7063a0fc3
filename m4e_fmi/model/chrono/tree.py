"""Which body hangs on which: Chrono's joints join two bodies, ours a child to its parent."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from m4e_fmi.model.elements import GROUND

Joining = TypeVar("Joining")


@dataclass(frozen=True)
class Edge(Generic[Joining]):
    """Something that joins two bodies; the ground stands for all fixed ones."""

    joining: Joining
    bodies: tuple[str, str]


@dataclass(frozen=True)
class Branch(Generic[Joining]):
    """`child` hangs on `parent` by `joining`; None where it floats."""

    child: str
    parent: str
    joining: Joining | None


def branches(
    bodies: Iterable[str], edges: Sequence[Edge[Joining]]
) -> tuple[list[Branch[Joining]], list[Edge[Joining]]]:
    """A branch for every body, parents first, and the edges that would close a loop.

    Of bodies that are joined to the ground by nothing, the first in the list floats.
    """
    at: dict[str, list[Edge[Joining]]] = {}
    for edge in edges:
        for body in edge.bodies:
            at.setdefault(body, []).append(edge)
    grown: list[Branch[Joining]] = []
    used: set[int] = set()
    reached = {GROUND}
    grown += _grow(GROUND, at, reached, used)
    for body in bodies:
        if body not in reached:
            reached.add(body)
            grown.append(Branch(body, GROUND, None))
            grown += _grow(body, at, reached, used)
    return grown, [edge for edge in edges if id(edge) not in used and set(edge.bodies) != {GROUND}]


def _grow(
    root: str, at: Mapping[str, list[Edge[Joining]]], reached: set[str], used: set[int]
) -> Iterator[Branch[Joining]]:
    """Branches from `root`, by distance from it; marks bodies and edges."""
    waiting = [root]
    for parent in waiting:  # grows while it is walked through
        for edge in at.get(parent, ()):
            first, second = edge.bodies
            child = second if first == parent else first
            if child not in reached:
                reached.add(child)
                used.add(id(edge))
                waiting.append(child)
                yield Branch(child, parent, edge.joining)
