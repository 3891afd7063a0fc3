"""Bodies of the rows and columns of added-mass matrices, and the bodies that are connected."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from m4e_fmi.cosim.connections.links import Link, Port, Variables
from m4e_fmi.fmu.importer.reading import Variable

DESCRIBED = re.compile(
    r"added mass at infinite frequency: (\w+) \w+ per acceleration in \w+ \w+"
    r"|Added mass at infinite frequency, world axes at the CG, (\w+) by \w+"
)
"""Description of an element, with the body of its row: of a hydrodynamics component, or a model."""
ELEMENT = re.compile(r"(.+)\[(\d+),(\d+)\]")
BODY = "body."
"""Prefix of a model's bodies."""

Pairs = frozenset[tuple[str, str]]
"""Bodies of a hydrodynamics component, each with the body of a model that it is connected with."""


def added_mass_bodies(variables: Mapping[str, Variable]) -> dict[str, tuple[str, str]]:
    """The bodies of row and column of each element of an added-mass matrix, by its name.

    They are read from the descriptions: one per element in FMI 2.0, those of all elements in FMI
    3.0. Matrices of other tools have no such description and are left out.
    """
    matrices: dict[str, dict[str, tuple[int, int]]] = {}
    for name in variables:
        if found := ELEMENT.fullmatch(name):
            matrices.setdefault(found[1], {})[name] = (int(found[2]), int(found[3]))
    bodies: dict[str, tuple[str, str]] = {}
    for places in matrices.values():
        texts = (variables[name].description for name in places)
        rows = (row[1] or row[2] for text in texts for row in DESCRIBED.finditer(text))
        order = list(dict.fromkeys(rows))
        if order:
            motions = max(i for i, _ in places.values()) // len(order)
            for name, (i, j) in places.items():
                bodies[name] = order[(i - 1) // motions], order[(j - 1) // motions]
    return bodies


def in_order(bodies: Mapping[str, tuple[str, str]]) -> list[str]:
    """The bodies of a matrix in the order of its rows."""
    return list(dict.fromkeys(row for row, _ in bodies.values()))


def moving(variables: Variables, links: Iterable[Link]) -> list[Link]:
    """The links into inputs: forces and motions, but no parameters."""
    return [k for k in links if k.variables(variables)[1].causality == "input"]


def connected_bodies(links: Iterable[Link]) -> Mapping[tuple[str, str], Pairs]:
    """Pairs of bodies that these forces or motions connect, by hydrodynamics component and model.

    Any component counts that is connected with a variable ``body.<name>.…`` of another one, which
    is the model.
    """
    found: dict[tuple[str, str], set[tuple[str, str]]] = {}
    for link in links:
        model = next((port for port in link.ends if port.variable.startswith(BODY)), None)
        if model is None:
            continue
        water = link.source if model is link.target else link.target
        name = group(model).removeprefix(BODY)
        found.setdefault((water.component, model.component), set()).add((group(water), name))
    return {key: frozenset(pairs) for key, pairs in found.items()}


def group(port: Port) -> str:
    """A variable's name before its last dot."""
    return port.variable.rpartition(".")[0]
