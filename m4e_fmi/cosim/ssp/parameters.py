"""Parameter sets (SSV) and their bindings: start values of the components.

A binding at a system wins over those further in, a later one over an earlier one at the same
element. Names count from the element that has the binding; of a system they are its connectors', or
begin with the name of an element in it and a dot.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from m4e_fmi.cosim.ssp.elements import Node, Signal
from m4e_fmi.cosim.ssp.package import (
    PARAMETER_SET_TYPE,
    SSD,
    SSV,
    Definition,
    Element,
    Package,
    checked,
    parse,
    read_units,
    unit_named,
)
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_XML
from m4e_fmi.units import Quantity

Value = float | int | bool | str | Quantity


def read_parameter_set(path: str | Path) -> dict[str, Value]:
    """The values of an SSV file by name; InputError with all that is wrong with it."""
    path = Path(path)
    try:
        content = read_bytes(path, largest=LARGEST_XML)
    except (OSError, TooLongError) as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
    root = parse(content, str(path), SSV)
    return dict(_parameters(root, {}))


def _parameters(root: Element, units: dict[str, Definition]) -> Iterator[tuple[str, Value]]:
    """Names and values of a ParameterSet; InputError for one that cannot be read.

    A Real with a unit is a Quantity, an item of an enumeration its name.
    """
    own = read_units(root)
    for element in root.iterfind(f"{SSV}Parameters/{SSV}Parameter"):
        value = next(child for child in element if child.tag.startswith(SSV))
        given, name = value.get("value"), element.get("name")
        kind = value.tag.removeprefix(SSV)
        result: Value = given
        if kind in ("Real", "Integer"):
            result = float(given) if kind == "Real" else int(given)
        elif kind == "Boolean":
            result = given.strip() in ("true", "1")
        if kind == "Real" and value.get("unit"):
            try:
                unit = unit_named(value.get("unit"), own, units)
            except ValueError as error:
                file, line = root.getroottree().docinfo.URL, value.sourceline or 0
                remedy = "define it among the file's Units"
                problem = Problem(f"parameter {name!r}: {error}", remedy, file, line)
                raise InputError([problem]) from None
            result = Quantity(float(given), unit.unit, unit.offset)
        yield name, result


def bound_parameters(
    package: Package, node: Node, units: dict[str, Definition]
) -> Iterator[tuple[str, Value]]:
    """The values that the bindings of one element give, by names that count from there."""
    for binding in node.element.findall(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
        mapping = binding.find(f"{SSD}ParameterMapping")
        if mapping is not None:
            remedy = "give the parameters of the set the names of what they are for"
            package.reject(mapping, "a mapping of parameters (SSM) is not read", remedy)
            continue
        root = _content(package, binding)
        prefix = binding.get("prefix", "")
        for name, value in _parameters(root, units) if root is not None else ():
            yield prefix + name, value


def _content(package: Package, binding: Element) -> Element | None:
    """The root of the parameter set of a binding, from its own file or inside it."""
    if binding.get("type", PARAMETER_SET_TYPE) != PARAMETER_SET_TYPE:
        message = f"ParameterSet of type {binding.get('type')!r} is not read"
        package.reject(binding, message, f"{PARAMETER_SET_TYPE} is")
    elif binding.get("sourceBase", "SSD") != "SSD":
        remedy = "put it into the package's folder resources"
        package.reject(binding, "ParameterSet inside a component is not read", remedy)
    elif binding.get("source"):
        member = package.member(binding, binding.get("source"))
        return package.xml(member, SSV) if member else None
    else:
        root = binding.find(f"{SSD}ParameterValues/{SSV}ParameterSet")
        if root is not None:
            return checked(root, root.getroottree().docinfo.URL, SSV)
        package.reject(binding, "a binding names no file and holds no ParameterSet")
    return None


def targets(node: Node, name: str, leads_to: dict[Signal, list[Signal]]) -> list[Signal] | None:
    """The variables of components that `name`, counted from `node`, stands for; None if none."""
    if node.what == "Component":
        return [(node.path, name)]
    if node.what == "System" and name in node.connectors:
        return leads_to.get((node.path, name), [])
    for child in node.children.values():
        if name.startswith(f"{child.path[-1]}."):
            found = targets(child, name.removeprefix(f"{child.path[-1]}."), leads_to)
            if found is not None:
                return found
    return None
