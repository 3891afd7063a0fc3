"""Bodies in water whose model takes no added mass."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from m4e_fmi.cosim.connections.added_mass.matrices import (
    BODY,
    added_mass_bodies,
    group,
    in_order,
    moving,
)
from m4e_fmi.cosim.connections.links import Link, Port, Wiring
from m4e_fmi.fmu.importer.reading import Description, Variable

FLAG = "'added_mass: true'"


def without_added_mass(descriptions: Mapping[str, Description], wiring: Wiring) -> list[str]:
    """Warnings of bodies that the water's forces move without its added mass, one line each.

    They are bodies of our models without a matrix, in water whose matrix holds them and leads
    nowhere. Bodies that no force moves are left out.
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
        body, other = group(source), group(target).removeprefix(BODY)
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
        f"{water} has added mass, which {body.component}.{BODY}{body.variable} does not take: "
        f"write {FLAG} at {body.variable} in its model, and connect "
        f"'{water.component}.added_mass -> {body.component}.added_mass'"
        for water, body in bare.items()
    ]


def _moves(link: Link, descriptions: Mapping[str, Description]) -> bool:
    """True if an output of the body that takes the force of `link` depends on it."""
    component, name = link.target.component, link.target.variable
    dependencies = descriptions[component].dependencies
    prefix = group(link.target) + "."
    return any(name in known for out, known in dependencies.items() if out.startswith(prefix))


def lacking_flag(variables: Mapping[str, Variable], name: str) -> str:
    """The remedy of a matrix `name` that a model does not have; no text of other components."""
    inputs = [v.name for v in variables.values() if v.causality == "input"]
    parts = [text.removeprefix(BODY).partition(".")[0] for text in inputs if text.startswith(BODY)]
    if name != "added_mass" or not parts:
        return ""
    bodies = ", ".join(dict.fromkeys(parts))
    return f"write {FLAG} in its model at each body that is in water (bodies: {bodies})"


def differing_bodies(source: Iterable[str], target: Iterable[str]) -> str:
    """The remedy of two matrices of these bodies in water and of a model; no text if unknown."""
    given, taken = list(source), list(target)
    if not given or not taken or len(given) == len(taken):
        return ""
    return (
        f"; rows are for {', '.join(given)}, and for {', '.join(taken)}: write {FLAG} in the model "
        "at each body that is in water, and at no other"
    )
