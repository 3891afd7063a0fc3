"""Added mass of bodies: those of each matrix, their order, bodies without it.

A matrix ``added_mass`` has rows and columns per body: a hydrodynamics component's in the order of
its file, a model's in the order of its body numbers. Connections must not give the added mass of
one body to another one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import ELEMENT, Link, Port, Variables, Wiring
from m4e_fmi.errors import Problem
from m4e_fmi.fmu.importer.reading import Description, Variable

DESCRIBED = re.compile(
    r"added mass at infinite frequency: (\w+) \w+ per acceleration in \w+ \w+"
    r"|Added mass at infinite frequency, world axes at the CG, (\w+) by \w+"
)
"""Description of an element, with the body of its row: of a hydrodynamics component, or a model."""
BODY = "body."
"""Prefix of a model's bodies."""

Pairs = frozenset[tuple[str, str]]
"""Bodies of a hydrodynamics component, each with the body of a model that it is connected with."""
FLAG = "'added_mass: true'"


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

    Every component counts that is connected with a variable ``body.<name>.…`` of another one, which
    is the model.
    """
    found: dict[tuple[str, str], set[tuple[str, str]]] = {}
    for link in links:
        model = next((port for port in link.ends if port.variable.startswith(BODY)), None)
        if model is None:
            continue
        giver = link.source if model is link.target else link.target
        name = model.connector.variable.removeprefix(BODY)
        found.setdefault((giver.component, model.component), set()).add(
            (giver.connector.variable, name)
        )
    return {key: frozenset(pairs) for key, pairs in found.items()}


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
    used = {(port.component, port.connector.variable) for link in exchanged for port in link.ends}
    told: set[int] = set()
    for link in links:
        source, target = link.ends
        given = bodies[source.component].get(source.variable)
        taken = bodies[target.component].get(target.variable)
        joined = pairs.get((source.component, target.component))
        if link.connection in told or joined is None or given is None or taken is None:
            continue
        rows = in_order(bodies[source.component]), in_order(bodies[target.component])
        for body, other in zip(given, taken, strict=True):
            idle = (source.component, body) not in used
            elsewhere = any(body == one or other == name for one, name in joined)
            if (body, other) in joined or not (idle or elsewhere):
                continue
            told.add(link.connection)
            message = (
                f"the added mass of {source.component}.{body} would act on "
                f"{target.component}.{BODY}{other}, with which it is not connected: rows of "
                f"{source.component} are for {', '.join(rows[0])}, those of {target.component} "
                f"for {', '.join(rows[1])}"
            )
            given_by = {name: one for one, name in sorted(joined)}
            order = [given_by.get(name, "") for name in rows[1]]
            remedy = f"write the bodies of {source.component!r} in the order {', '.join(order)}"
            if sorted(order) != sorted(rows[0]):
                remedy = (
                    f"connect each body of {source.component!r}, and in the model write "
                    "'added_mass: true' at the bodies that these are connected with, at no others"
                )
            yield system.problem(("connections", link.connection), message, remedy)
            break


def without_added_mass(descriptions: Mapping[str, Description], wiring: Wiring) -> list[str]:
    """Warnings of bodies moved by forces whose added mass they do not take, one line each.

    They are bodies of our models without a matrix; the matrix of the component that gives the
    forces holds them and leads nowhere. Bodies that no force moves are left out.
    """
    tables = {name: d.variables for name, d in descriptions.items()}
    bodies = {name: added_mass_bodies(table) for name, table in tables.items()}
    taken = {
        (link.source.component, body)
        for link in wiring.all_links
        for body in bodies[link.source.component].get(link.source.variable, ())
    }
    bare: dict[Port, Port] = {}
    for link in moving(tables, wiring.all_links):
        source, target = link.ends
        body, other = source.connector.variable, target.connector.variable.removeprefix(BODY)
        if (
            target.variable.startswith(BODY)
            and body in in_order(bodies[source.component])
            and (source.component, body) not in taken
            and other not in in_order(bodies[target.component])
            and descriptions[target.component].is_own
            and _moves(link, descriptions)
        ):
            bare[Port(source.component, body)] = Port(target.component, other)
    return [
        f"{giver} has added mass, which {body.component}.{BODY}{body.variable} does not take: "
        f"write {FLAG} at {body.variable} in its model, and connect "
        f"'{giver.component}.added_mass -> {body.component}.added_mass'"
        for giver, body in bare.items()
    ]


def _moves(link: Link, descriptions: Mapping[str, Description]) -> bool:
    """True if an output of the body that takes the force of `link` depends on it."""
    component, name = link.target.component, link.target.variable
    dependencies = descriptions[component].dependencies
    prefix = link.target.connector.variable + "."
    return any(name in known for out, known in dependencies.items() if out.startswith(prefix))


def lacking_flag(variables: Mapping[str, Variable], name: str) -> str:
    """The remedy of a matrix `name` that a model does not have; no text of other components."""
    inputs = [v.name for v in variables.values() if v.causality == "input"]
    parts = [text.removeprefix(BODY).partition(".")[0] for text in inputs if text.startswith(BODY)]
    if name != "added_mass" or not parts:
        return ""
    bodies = ", ".join(dict.fromkeys(parts))
    return f"write {FLAG} in its model at each body that has one (bodies: {bodies})"


def differing_bodies(source: Iterable[str], target: Iterable[str]) -> str:
    """The remedy of two matrices of these bodies, given and of a model; no text if unknown."""
    given, taken = list(source), list(target)
    if not given or not taken or len(given) == len(taken):
        return ""
    return (
        f"; rows are for {', '.join(given)}, and for {', '.join(taken)}: write {FLAG} in the model "
        "at each body that has added mass, and at no other"
    )
