"""Which body hangs on which, in the numbering that the equations use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import networkx as nx

from m4e_fmi.model import GROUND, Model
from m4e_fmi.model.elements import Joint

COORDINATES = {"revolute": ("Theta",), "prismatic": ("S",), "floating": ("X", "Z", "Theta")}


@dataclass(frozen=True)
class Link:
    """One body with the joint that holds it.

    `number` counts bodies from 1, in the order of their distance from the ground; `parent` is the
    index of the parent's link, −1 for the ground. `coordinates` are the indices in q of the joint's
    coordinates; `angle` is the index in q of the body's absolute angle, −1 if it never turns.
    """

    number: int
    body: str
    joint_name: str
    joint: Joint
    parent: int
    coordinates: tuple[int, ...]
    angle: int


@dataclass(frozen=True)
class Topology:
    """The links of a model, parents first, and the names of its coordinates and velocities."""

    links: tuple[Link, ...]
    coordinate_names: tuple[str, ...]

    @property
    def velocity_names(self) -> tuple[str, ...]:
        return tuple(_rate_name(name) for name in self.coordinate_names)

    def index(self, body: str) -> int:
        """Index of a body's link; −1 for the ground."""
        return next((k for k, link in enumerate(self.links) if link.body == body), -1)

    def branches(self) -> list[list[str]]:
        """All paths of bodies from the ground to a leaf."""
        graph = _graph({link.joint_name: link.joint for link in self.links})
        leaves = [body for body in graph if graph.out_degree(body) == 0]
        return [nx.shortest_path(graph, GROUND, leaf)[1:] for leaf in leaves]


def topology(model: Model) -> Topology:
    """Number the bodies by distance from the ground, equal ones in the order of the model."""
    holders = {joint.child: name for name, joint in model.joints.items()}
    distance = nx.single_source_shortest_path_length(_graph(model.joints), GROUND)
    order = sorted(model.bodies, key=lambda body: distance[body])  # stable: ties keep their order
    links: list[Link] = []
    names: list[str] = []
    for number, body in enumerate(order, start=1):
        joint = model.joints[holders[body]]
        parent = next((k for k, link in enumerate(links) if link.body == joint.parent), -1)
        first = len(names)
        names += [f"{letter}_{number}" for letter in COORDINATES[joint.type]]
        coordinates = tuple(range(first, len(names)))
        if joint.type == "prismatic":
            angle = links[parent].angle if parent >= 0 else -1
        else:
            angle = coordinates[-1]
        links.append(Link(number, body, holders[body], joint, parent, coordinates, angle))
    return Topology(tuple(links), tuple(names))


def _graph(joints: Mapping[str, Joint]) -> nx.DiGraph:
    graph = nx.DiGraph((joint.parent, joint.child) for joint in joints.values())
    graph.add_node(GROUND)
    return graph


def _rate_name(coordinate: str) -> str:
    letter, number = coordinate.split("_")
    return f"{letter}D_{number}"
