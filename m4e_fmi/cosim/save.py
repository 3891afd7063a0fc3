"""Saving a system with all its FMUs as an SSP package.

SSP allows one source for each input: where several add up, a component of ``kind: sum`` is put
between them and their target, one for each connector or matrix. What a component calculates once,
as an added mass, is a parameter of the sum.
"""

from __future__ import annotations

import re
from collections.abc import Container, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path

from m4e_fmi.cosim.preparation.components import ready_fmus
from m4e_fmi.cosim.preparation.prepare import described, prepare
from m4e_fmi.cosim.ssp.write import write_ssp
from m4e_fmi.cosim.system.component import Component, Kind, kind_of
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Link, Port, Variables, base, is_varying, summed
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import InputError
from m4e_fmi.files.file_kinds import SSP_SUFFIX

KIND = "sum"
RESERVED = (KIND, "factor", "time")
"""Names that no input of a sum has."""


def save_system(system: System, path: str | Path, *, build_directory: str | Path = "build") -> Path:
    """Write the system with all its FMUs, built where needed, as an SSP package (`*.ssp`).

    InputError and RunError as from `prepare`, and InputError for another suffix.
    """
    if Path(path).suffix.lower() != SSP_SUFFIX:
        raise InputError.single(f"a system is saved as {SSP_SUFFIX}", f"write {path}{SSP_SUFFIX}")
    prepared = prepare(system, build_directory=build_directory)
    prepared = replace(prepared, system=system)
    return write_ssp(_with_sums(prepared, build_directory), path)


def _with_sums(prepared: Prepared, build_directory: str | Path) -> Prepared:
    """The same with a component for each sum, through which the links go."""
    system, wiring = prepared.system, prepared.wiring
    variables = {name: d.variables for name, d in prepared.descriptions.items()}
    sums: dict[str, Component] = {}
    through: dict[Link, Link] = {}
    onward: list[Link] = []
    for group in summed(wiring.all_links, variables):
        name = _free_name(f"{base(group[0][0].target)}_{KIND}", (*variables, *sums))
        terms: list[str] = []
        for link in group[0]:
            terms.append(_free_name(link.source.component, (*terms, *RESERVED)))
        for several in group:
            signal, first = _signal(several[0]), several[0]
            for term, link in zip(terms, several, strict=True):
                through[link] = replace(link, target=Port(name, f"{term}.{signal}"))
            source = Port(name, f"{KIND}.{signal}")
            onward.append(Link(source, first.target, first.connection))
        sums[name] = _sum(name, terms, group, variables)
    if not sums:
        return prepared
    part = System(system.name, tuple(sums.values()), (), system.simulation)
    fmus = ready_fmus(part, build_directory, drafts={})
    links = (*(through.get(k, k) for k in wiring.all_links), *onward)
    return replace(
        prepared,
        system=replace(system, components=(*system.components, *sums.values())),
        descriptions=prepared.descriptions | described(part, fmus),
        wiring=replace(wiring, links=links, initial_links=()),
    )


def _sum(
    name: str, terms: Sequence[str], group: Sequence[Sequence[Link]], variables: Variables
) -> Component:
    """The component of a sum of `terms`, whose signals are those that a group's links carry."""
    once = [
        term
        for term, link in zip(terms, group[0], strict=True)
        if not is_varying(link.variables(variables)[0])
    ]
    targets = [(_signal(several[0]), several[0].target) for several in group]
    units = {n: variables[port.component][port.variable].unit or "1" for n, port in targets}
    config = kind_of(KIND).config(inputs=list(terms), parameters=once, signals=units)
    return Component(name, Kind(KIND, config))


def _signal(link: Link) -> str:
    """The last name of a link's target; of an element of a matrix, with its indices."""
    return re.sub(r"[^\w\[\],]+", "_", link.target.variable.rpartition(".")[2], flags=re.ASCII)


def _free_name(text: str, taken: Container[str]) -> str:
    """A name of letters, digits and underscores that begins with a letter, numbered if `taken`."""
    word = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
    stem = word if word[:1].isalpha() else f"of_{word}"
    names = (f"{stem}_{k}" if k > 1 else stem for k in count(1))
    return next(name for name in names if name not in taken)
