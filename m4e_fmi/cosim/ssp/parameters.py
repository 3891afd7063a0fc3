"""Parameter sets (SSV), their mappings (SSM) and bindings: start values of the components.

A binding at a system wins over those further in, a later one over an earlier one at the same
element. Names count from the element that has the binding; of a system they are its connectors', or
begin with the name of an element in it and a dot.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from m4e_fmi.cosim.ssp.elements import Node, Signal
from m4e_fmi.cosim.ssp.package import (
    PARAMETER_MAPPING_TYPE,
    PARAMETER_SET_TYPE,
    SSD,
    SSM,
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
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.units import Quantity

Value = float | int | bool | str | Quantity


@dataclass(frozen=True)
class _Parameter:
    """A named value; a Real with a unit is a Quantity, an item of an enumeration its name."""

    name: str
    value: Value
    element: Element
    transformation: Element | None = None
    units_ignored: bool = False

    def for_variable(self, variable: Variable) -> Value:
        """The value that the variable takes; ValueError(message, remedy) if it has none."""
        if self.transformation is None:
            value = self.value
            return value.value if self.units_ignored and isinstance(value, Quantity) else value
        if not self.transformation.tag.endswith("LinearTransformation"):
            message = f"parameter {self.name!r} is mapped by a table"
            raise ValueError(message, "only linear transformations of numbers are read")
        factor = float(self.transformation.get("factor", 1.0))
        offset = float(self.transformation.get("offset", 0.0))
        return factor * self._number(variable) + offset

    def _number(self, variable: Variable) -> float:
        """The value in the unit of the variable."""
        value = self.value
        if isinstance(value, Quantity):
            if self.units_ignored or variable.dimension is None:
                return value.value
            try:
                return value.in_unit(variable.dimension, variable.offset)
            except ValueError as error:
                raise ValueError(f"parameter {self.name!r}: {error}", "correct its unit") from None
        if isinstance(value, str | bool):
            remedy = "a linear transformation needs a Real or an Integer"
            raise ValueError(f"parameter {self.name!r} is {value!r}", remedy)
        return float(value)


def read_parameter_set(path: str | Path) -> dict[str, Value]:
    """The values of an SSV file by name; InputError with all that is wrong with it."""
    path = Path(path)
    try:
        content = read_bytes(path, largest=LARGEST_XML)
    except (OSError, TooLongError) as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
    root = parse(content, str(path), SSV)
    return {parameter.name: parameter.value for parameter in _parameters(root, {})}


def _parameters(root: Element, units: dict[str, Definition]) -> Iterator[_Parameter]:
    """The values of a ParameterSet; InputError for one that cannot be read."""
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
        yield _Parameter(name, result, element)


def bound_parameters(
    package: Package, node: Node, units: dict[str, Definition]
) -> Iterator[_Parameter]:
    """The values that the bindings of one element give, by names that count from there."""
    for binding in node.element.findall(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
        root = _content(
            package, binding, SSV, "ParameterSet", PARAMETER_SET_TYPE, "ParameterValues"
        )
        if root is None:
            continue
        mapping = binding.find(f"{SSD}ParameterMapping")
        entries: dict[str, list[Element]] = {}
        if mapping is not None:
            table = _content(package, mapping, SSM, "ParameterMapping", PARAMETER_MAPPING_TYPE)
            for entry in table.findall(f"{SSM}MappingEntry") if table is not None else ():
                entries.setdefault(entry.get("source"), []).append(entry)
        prefix = binding.get("prefix", "")
        for parameter in _parameters(root, units):
            name = prefix + parameter.name
            mapped = entries.get(name)
            if mapped is None:
                yield replace(parameter, name=name)
            for entry in mapped or ():
                ways = [child for child in entry if child.tag.endswith("Transformation")]
                yield replace(
                    parameter,
                    name=entry.get("target"),
                    transformation=ways[0] if ways else None,
                    units_ignored=entry.get("suppressUnitConversion", "false") in ("true", "1"),
                )


def _content(
    package: Package, element: Element, namespace: str, name: str, kind: str, inside: str = ""
) -> Element | None:
    """The root of a parameter set or mapping, from its own file or inside `element`."""
    if element.get("type", kind) != kind:
        message = f"{name} of type {element.get('type')!r} is not read"
        package.reject(element, message, f"{kind} is")
    elif element.get("sourceBase", "SSD") != "SSD":
        remedy = "put it into the package's folder resources"
        package.reject(element, f"{name} inside a component is not read", remedy)
    elif element.get("source"):
        member = package.member(element, element.get("source"))
        return package.xml(member, namespace) if member else None
    else:
        outer = element.find(f"{SSD}{inside}") if inside else element
        root = outer.find(f"{namespace}{name}") if outer is not None else None
        if root is None:
            package.reject(element, f"a binding names no file and holds no {name}")
            return None
        return checked(root, root.getroottree().docinfo.URL, namespace)
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
