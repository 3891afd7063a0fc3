"""Elements of an SSP package: systems, components, references to signal dictionaries."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from m4e_fmi.cosim.ssp.names import (
    DICTIONARY_TYPE,
    FMU_TYPES,
    GRAPHICS,
    OSP,
    OWN,
    SSB,
    SSC,
    SSD,
)
from m4e_fmi.cosim.ssp.package import Element, Package, check
from m4e_fmi.cosim.ssp.units import Definition, read_units, unit_named

Path = tuple[str, ...]
"""Names of the elements from below the root system down."""
Signal = tuple[Path, str]
"""A connector, by its element's path and its name; an entry of a dictionary likewise."""
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration", "Binary")
ROLES = {"input": "in", "parameter": "in", "output": "out", "calculatedParameter": "out"}


@dataclass(frozen=True)
class Connector:
    """A variable at the edge of an element; `type` and `unit` are None where nothing is said."""

    name: str
    kind: str
    type: str | None
    unit: Definition | None
    element: Element


@dataclass
class Node:
    """An element: a system with `children`, a component with a `member`, or a reference.

    `signal` leads from a connector's name to the signal it is, which for a reference belongs to
    the dictionary.
    """

    what: Literal["System", "Component", "SignalDictionaryReference"]
    path: Path
    element: Element
    connectors: dict[str, Connector]
    children: dict[str, Node] = field(default_factory=dict)
    member: str = ""
    dictionary: Path = ()

    def signal(self, name: str) -> Signal:
        """The signal of a connector."""
        return (self.dictionary or self.path, name)

    def components(self) -> Iterator[Node]:
        """All components in it, in the order of the file."""
        for child in self.children.values():
            if child.what == "Component":
                yield child
            yield from child.components()

    def nodes(self) -> Iterator[Node]:
        """Itself and all below it, deepest first."""
        for child in self.children.values():
            yield from child.nodes()
        yield self


@dataclass
class _Reader:
    package: Package
    units: dict[str, Definition]
    dictionaries: dict[Path, dict[str, Connector]] = field(default_factory=dict)


def read_tree(
    package: Package, root: Element, units: dict[str, Definition]
) -> tuple[Node, dict[Signal, Definition]]:
    """The root system and the units of its signals, as far as the file names them.

    What cannot be read is among the package's problems.
    """
    for element in root.iter():
        if element.tag in {f"{SSD}{name}" for name in GRAPHICS}:
            package.note("geometry and graphics are left out")
        if element.tag == f"{SSC}Annotation" and element.get("type") not in (OWN, OSP):
            package.note(f"annotations of type {element.get('type')!r} are left out")
    reader = _Reader(package, units)
    system = _system(reader, root.find(f"{SSD}System"), (), {})
    named = [(path, entries) for path, entries in reader.dictionaries.items()]
    named += [(node.dictionary or node.path, node.connectors) for node in system.nodes()]
    of_signals: dict[Signal, Definition] = {}
    for path, connectors in named:
        for name, connector in connectors.items():
            if connector.unit is not None:
                of_signals.setdefault((path, name), connector.unit)
    return system, of_signals


def _system(reader: _Reader, element: Element, path: Path, outer: dict[str, Path]) -> Node:
    known = dict(outer)
    for found in element.findall(f"{SSD}SignalDictionaries/{SSD}SignalDictionary"):
        name = found.get("name")
        known[name] = (*path, f"dictionary {name}")
        reader.dictionaries[known[name]] = _dictionary(reader, found)
    node = Node("System", path, element, _connectors(reader, element))
    inside = element.find(f"{SSD}Elements")
    for child in inside if inside is not None else ():
        name = child.get("name")
        below = (*path, name)
        if name in node.children:
            reader.package.reject(child, f"two elements are called {name!r}", "rename one of them")
        elif child.tag == f"{SSD}System":
            node.children[name] = _system(reader, child, below, known)
        elif child.tag == f"{SSD}Component":
            member = _member(reader.package, child)
            connectors = _connectors(reader, child)
            node.children[name] = Node("Component", below, child, connectors, member=member)
        else:
            node.children[name] = _reference(reader, child, below, known)
    return node


def _member(package: Package, element: Element) -> str:
    """The FMU of a component, empty if there is none that can be used."""
    kind = element.get("type", FMU_TYPES[0])
    name = element.get("name")
    if kind not in FMU_TYPES:
        remedy = "put the referenced package into this one, as a system"
        package.reject(element, f"component {name!r} is not an FMU but {kind!r}", remedy)
        return ""
    if element.get("implementation", "any") == "ModelExchange":
        message = f"component {name!r} is to be used for model exchange"
        package.reject(element, message, "only FMUs for co-simulation are coupled")
    return package.member(element, element.get("source")) or ""


def _reference(reader: _Reader, element: Element, path: Path, known: dict[str, Path]) -> Node:
    dictionary = element.get("dictionary")
    connectors = _connectors(reader, element)
    owner = known.get(dictionary)
    if owner is None:
        message = f"{path[-1]!r} refers to an unknown signal dictionary {dictionary!r}"
        reader.package.reject(element, message, "define it in this system or one around it")
    for name, connector in connectors.items():
        if owner is not None and name not in reader.dictionaries[owner]:
            message = f"signal dictionary {dictionary!r} has no entry {name!r}"
            reader.package.reject(connector.element, message)
    what = "SignalDictionaryReference"
    return Node(what, path, element, connectors, dictionary=owner or path)


def _dictionary(reader: _Reader, element: Element) -> dict[str, Connector]:
    """Entries of a signal dictionary, in the file or in one of its own."""
    package = reader.package
    content = element.find(f"{SSB}SignalDictionary")
    if element.get("type", DICTIONARY_TYPE) != DICTIONARY_TYPE:
        package.reject(element, f"a dictionary of type {element.get('type')!r} is not read")
        return {}
    if element.get("source"):
        member = package.member(element, element.get("source"))
        content = package.xml(member, SSB) if member else None
    elif content is not None:
        check(content, content.getroottree().docinfo.URL, SSB)
    if content is None:
        package.reject(element, f"signal dictionary {element.get('name')!r} has no content")
        return {}
    inside = _Reader(package, {**reader.units, **read_units(content)})
    return _connectors(inside, content, f"{SSB}DictionaryEntry", "inout")


def _connectors(
    reader: _Reader,
    element: Element,
    tag: str = f"{SSD}Connectors/{SSD}Connector",
    kind: str = "",
) -> dict[str, Connector]:
    found = {}
    for item in element.findall(tag):
        types = [t for t in TYPES if item.find(f"{SSC}{t}") is not None]
        unit = None
        if types == ["Real"]:
            unit = _unit(reader, item, item.find(f"{SSC}Real").get("unit"))
        name = item.get("name")
        if name in found:
            reader.package.reject(item, f"two connectors are called {name!r}", "rename one")
        type_ = types[0] if types else None
        found[name] = Connector(name, kind or item.get("kind"), type_, unit, item)
    return found


def _unit(reader: _Reader, element: Element, name: str | None) -> Definition | None:
    if not name:
        return None
    try:
        return unit_named(name, reader.units)
    except ValueError as error:
        reader.package.reject(element, f"{error}", "define it among the file's Units")
        return None
