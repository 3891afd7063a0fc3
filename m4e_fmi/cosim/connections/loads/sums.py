"""Sums of forces, moments and added masses that several connections lead to one input.

An input has one source. Several sources of a force or moment, or of an element of an added-mass
matrix, mean their sum: a component of ``kind: sum`` is put between them, one for each connector or
matrix. Its inputs are the links' targets then, and its outputs lead on. What a component calculates
once, as the added mass of a hull, is a parameter of the sum.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path

from m4e_fmi.cosim.connections.added_mass.matrices import ELEMENT
from m4e_fmi.cosim.connections.links import Link, Port, Variables, is_varying
from m4e_fmi.cosim.system.component import Component, Kind, kind_module
from m4e_fmi.fmu.export.description import expected_description
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.fmu.importer.type_rules import REAL
from m4e_fmi.units import parse_unit

KIND = "sum"
LOADS = tuple(map(parse_unit, ("N", "N.m")))
MATRIX = "added_mass"


@dataclass(frozen=True)
class Sum:
    """The component `name` that adds up what `links` lead to inputs of another component.

    `terms` are its inputs by name, False for those that are parameters; `signals` the units of what
    it adds up. `joined` are the links into it and `onward` those from it, instead of `links`.
    """

    name: str
    links: tuple[Link, ...]
    terms: Mapping[str, bool]
    signals: Mapping[str, str]
    joined: tuple[Link, ...] = field(repr=False)
    onward: tuple[Link, ...] = field(repr=False)

    @property
    def component(self) -> Component:
        """It as a component of the system."""
        once = [name for name, varies in self.terms.items() if not varies]
        config = kind_module(KIND).Config(
            inputs=list(self.terms), parameters=once, signals=dict(self.signals)
        )
        return Component(self.name, Kind(KIND, config))

    @property
    def variables(self) -> Mapping[str, Variable]:
        """Those that its FMU will have."""
        source = self.component.source
        assert isinstance(source, Kind)
        made = kind_module(KIND).make(source.config, name=self.name, folder=Path())
        return expected_description(made, Path(f"{self.name}.fmu")).variables

    @property
    def note(self) -> str:
        """A line on what it adds up."""
        first, last = self.links[0].target, self.links[-1].target
        into = _base(first) if first != last else str(first)
        givers = dict.fromkeys(_base(link.source) for link in self.links)
        return f"{into} takes the sum of {', '.join(givers)}: {self.name}"


def can_be_summed(target: Variable) -> bool:
    """True of forces and moments that are inputs, and of elements of added-mass matrices."""
    if target.type != REAL:
        return False
    matrix = ELEMENT.fullmatch(target.name)
    if matrix and matrix[1].rpartition(".")[2] == MATRIX:
        return True
    dimension = target.dimension
    is_load = dimension is not None and any(dimension.same_dimension(load) for load in LOADS)
    return target.causality == "input" and is_load


def sums_of(variables: Variables, links: Sequence[Link]) -> list[Sum]:
    """The sums of links between components that have one target, in the order of the links."""
    by_target: dict[Port, list[Link]] = {}
    for link in links:
        by_target.setdefault(link.target, []).append(link)
    groups: dict[tuple[object, ...], list[list[Link]]] = {}
    for target, several in by_target.items():
        if len(several) > 1:
            keys = tuple(_term(link, variables) for link in several)
            groups.setdefault((_base(target), keys), []).append(several)
    found: list[Sum] = []
    names: set[str] = set()
    for alike in groups.values():
        found.append(_sum(alike, variables, names))
        names.add(found[-1].name)
    return found


def through_sums(links: Iterable[Link], sums: Iterable[Sum]) -> list[Link]:
    """The links with those that are summed going through sums; of one connection in a row."""
    joined = {old.ends: new for s in sums for old, new in zip(s.links, s.joined, strict=True)}
    onward = [link for s in sums for link in s.onward]
    through = [joined.get(link.ends, link) for link in links]
    return sorted([*through, *onward], key=lambda link: link.connection)


def _term(link: Link, variables: Variables) -> tuple[str, str, int, bool]:
    """Links of one term of a sum agree in this: connector, connection, and whether they vary."""
    give, _ = link.variables(variables)
    source = link.source
    return source.component, _base(source), link.connection, is_varying(give)


def _sum(alike: Sequence[Sequence[Link]], variables: Variables, taken: set[str]) -> Sum:
    """The sum of links by target, whose sources are of the same connectors in the same order."""
    keys = [_term(link, variables) for link in alike[0]]
    terms = _term_names([(component, base) for component, base, _, _ in keys])
    targets = [several[0].target for several in alike]
    signals = dict(zip(_signal_names(targets), targets, strict=True))
    units = {
        signal: variables[target.component][target.variable].unit or "1"
        for signal, target in signals.items()
    }
    stem = _word(f"{_base(targets[0])}_{KIND}")
    inputs = {f"{term}.{signal}" for term in terms for signal in signals}
    name = next(n for n in _numbered(stem) if n not in taken and _is_free(variables.get(n), inputs))
    links = [link for several in alike for link in several]
    joined = [
        replace(link, target=Port(name, f"{term}.{signal}"))
        for signal, several in zip(signals, alike, strict=True)
        for term, link in zip(terms, several, strict=True)
    ]
    first = min(link.connection for link in links)
    onward = [Link(Port(name, f"{KIND}.{s}"), target, first) for s, target in signals.items()]
    varies = dict(zip(terms, (key[3] for key in keys), strict=True))
    return Sum(name, tuple(links), varies, units, tuple(joined), tuple(onward))


def _is_free(known: Mapping[str, Variable] | None, inputs: set[str]) -> bool:
    """True if no component has the name, or if it is this sum."""
    return known is None or inputs <= known.keys()


def _term_names(keys: Sequence[tuple[str, str]]) -> list[str]:
    """A name for each component and its connector: that of the component, if it is the only one."""
    found: list[str] = []
    for component, base in keys:
        alone = [name for name, _ in keys].count(component) == 1
        stem = _word(component if alone else base)
        found.append(next(n for n in _numbered(stem) if n not in (*found, KIND, "factor", "time")))
    return found


def _signal_names(targets: Sequence[Port]) -> list[str]:
    """The last names of inputs, and the indices of elements of matrices."""
    found: list[str] = []
    for target in targets:
        matrix = ELEMENT.fullmatch(target.variable)
        whole = matrix[1] if matrix else target.variable
        index = f"[{matrix[2]},{matrix[3]}]" if matrix else ""
        stems = _numbered(_word(whole.rpartition(".")[2]))
        found.append(next(name for s in stems if (name := f"{s}{index}") not in found))
    return found


def _numbered(stem: str) -> Iterator[str]:
    yield from (f"{stem}_{k}" if k > 1 else stem for k in count(1))


def _word(text: str) -> str:
    """A name of letters, digits and underscores that begins with a letter."""
    word = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
    return word if word[:1].isalpha() else f"of_{word}"


def _base(port: Port) -> str:
    """Component and connector of a variable; of an element of a matrix, the matrix."""
    if matrix := ELEMENT.fullmatch(port.variable):
        return f"{port.component}.{matrix[1]}"
    group = port.variable.rpartition(".")[0]
    return f"{port.component}.{group}" if group else port.component
