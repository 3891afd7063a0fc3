"""Calculated parameters and matrices that no connection carries to a parameter of the same name."""

from __future__ import annotations

from collections.abc import Mapping, Set

from m4e_fmi.cosim.connections.links import Port, Wiring, is_carried, is_varying
from m4e_fmi.cosim.connections.missing.matching_connectors import fits
from m4e_fmi.cosim.system.system import System
from m4e_fmi.fmu.importer.reading import Description, Variable


def unconnected_parameters(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> list[str]:
    """Warnings of calculated parameters that are not carried to another component, one line each.

    The other component has a parameter of the same name, added mass for example, which would be
    left at its start value. So are matrices that are outputs.
    """
    taken = {link.source for link in wiring.all_links}
    given = {Port(c.name, name) for c in system.components for name in c.start}
    given |= {link.target for link in wiring.all_links}
    calculated, varying, wanted = (
        _arrays(descriptions, causality, done)
        for causality, done in (
            ("calculatedParameter", taken), ("output", taken), ("parameter", given)
        )
    )  # fmt: skip
    offered = calculated | {key: found for key, found in varying.items() if "" not in found}
    return [
        f"{source}.{name} is calculated, but not transferred: "
        + _advice(f"{source}.{name}", f"{target}.{name}", members, others)
        for (source, name), members in offered.items()
        for (target, other), others in wanted.items()
        if name == other and source != target
    ]


def _arrays(
    descriptions: Mapping[str, Description], causality: str, done: Set[Port]
) -> dict[tuple[str, str], dict[str, Variable]]:
    """Variables that are not `done`: component and array name → index → variable.

    A scalar is an array with the index "".
    """
    found: dict[tuple[str, str], dict[str, Variable]] = {}
    for component, description in descriptions.items():
        for variable in description.of_causality(causality):
            if Port(component, variable.name) not in done:
                base, bracket, index = variable.name.partition("[")
                found.setdefault((component, base), {})[bracket + index] = variable
    return found


def _advice(
    source: str, target: str, members: dict[str, Variable], others: dict[str, Variable]
) -> str:
    """The missing connection, or the reason why the two cannot be connected."""
    if members.keys() != others.keys():
        return (
            f"{target}, which differs in size ({len(members)} and {len(others)} elements), keeps "
            "its start value"
        )
    if not all(fits(members[index], others[index]) for index in members):
        return f"{target}, which is of another type or unit, keeps its start value"
    if any(is_varying(v) and not is_carried(v, others[index]) for index, v in members.items()):
        return f"{target}, which is fixed, keeps its start value while {source} varies"
    return f"'{source} -> {target}'"
