"""The FMUs of a package: their names as components, and whether it says the same as they do."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from m4e_fmi.cosim.ssp.elements import Node, Path, Signal
from m4e_fmi.cosim.ssp.package import Package, unpack_member
from m4e_fmi.cosim.ssp.units import Definition
from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.files.temporary import TemporaryFolder
from m4e_fmi.fmu.importer.reading import Description, read_description
from m4e_fmi.units import Unit


def flat_names(package: Package, parts: Iterable[Node]) -> dict[Path, str]:
    """A name for every component: its path joined by underscores, with letters and digits only."""
    names: dict[Path, str] = {}
    for node in parts:
        plain = re.sub(r"\W", "_", "_".join(node.path))
        plain = f"_{plain}" if plain[:1].isdigit() else plain
        name, count = plain, 1
        while name in names.values():
            count += 1
            name = f"{plain}_{count}"
        names[node.path] = name
        if name != ".".join(node.path):
            package.note(f"component {'.'.join(node.path)!r} is called {name!r} here")
    return names


def read_fmus(package: Package, parts: Iterable[Node]) -> dict[Path, Description]:
    """Descriptions of the FMUs; those that cannot be read are among the problems."""
    known: dict[str, Description | None] = {"": None}
    found = {}
    with TemporaryFolder() as folder:
        for node in parts:
            if node.member not in known:
                try:
                    copy = unpack_member(package.path, node.member, folder)
                    known[node.member] = read_description(copy)
                except InputError as error:
                    file = f"{package.path}/{node.member}"
                    package.problems += [replace(p, file=file) for p in error.problems]
                    known[node.member] = None
            description = known[node.member]
            if description is not None:
                found[node.path] = description
    return found


def check_connectors(
    package: Package, node: Node, descriptions: dict[Path, Description]
) -> dict[str, Unit]:
    """Units that the package adds to the FMU's variables; problems where both say otherwise."""
    added: dict[str, Unit] = {}
    description = descriptions.get(node.path)
    for name, connector in node.connectors.items() if description else ():
        assert description is not None
        variable = description.variables.get(name)
        if variable is None:
            remedy = suggestion(name, description.variables, "variables")
            message = f"the FMU of {node.path[-1]!r} has no variable {name!r}"
            package.reject(connector.element, message, remedy)
            continue
        told = f"connector {name!r} of {node.path[-1]!r}"
        if connector.kind != variable.causality:
            message = f"{told} is {connector.kind}, in its FMU {variable.causality}"
            package.reject(connector.element, message, "correct the kind")
        if connector.type not in (None, variable.type):
            message = f"{told} is {connector.type}, in its FMU {variable.type}"
            package.reject(connector.element, message, "correct the type")
        if connector.unit is None:
            continue
        unit, dimension = connector.unit.unit, variable.dimension
        if dimension is None:
            added[name] = unit
        elif (
            not unit.same_dimension(dimension)
            or abs(unit.factor / dimension.factor - 1) > 1e-9
            or connector.unit.offset != variable.offset
        ):
            message = f"{told} is in {unit.text}, in its FMU {variable.unit}"
            package.reject(connector.element, message, "correct the unit")
    return added


def add_units(
    node: Node, descriptions: dict[Path, Description], of_signals: dict[Signal, Definition]
) -> None:
    """Add the units of the FMU's variables to those that the package names."""
    description = descriptions.get(node.path)
    for name in node.connectors:
        variable = description.variables.get(name) if description else None
        if variable is not None and variable.dimension is not None:
            known = Definition(variable.dimension, variable.offset)
            of_signals.setdefault((node.path, name), known)
