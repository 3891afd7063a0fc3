"""Problems of a system's inputs, found before anything is built.

FMUs that are there are read. What is quick to make is made, in memory: a `Draft`, which is then
written as an FMU. The `check` of a kind that takes long finds its problems, and returns a program
with the variables that its FMU will have. When all of these are right, connections, start values
and the scenario are checked against them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.scenario.plan import scenario_problems
from m4e_fmi.cosim.system.component import Component, FmuFile, Kind, ModelFile, kind_module
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.files.files_read import Files, depends_on, files_read
from m4e_fmi.fmu import Description, read_description
from m4e_fmi.fmu.export.description import expected_description
from m4e_fmi.fmu.importer.reading import resized

if TYPE_CHECKING:
    from m4e_fmi.fmu import PythonSource
    from m4e_fmi.program import Program

Tell = Callable[[str], object]
WARNING = "warning"
"""How lines of progress begin that matter to everyone who uses what is built."""


def silent(_: str) -> None:
    """Takes a line of progress that nobody asked for."""


@dataclass(frozen=True)
class Draft:
    """The source of an FMU, and the `files` that were read for it.

    `lines` are messages of progress that were not shown yet.
    """

    made: Program | PythonSource
    files: Files
    lines: tuple[str, ...] = ()


def takes_long(source: FmuFile | ModelFile | Kind) -> bool:
    """True for kinds that may take minutes to make."""
    return isinstance(source, Kind) and getattr(kind_module(source.name), "TAKES_LONG", False)


def drafted(system: System, component: Component, tell: Tell | None = None) -> Draft:
    """The draft of a component that is no FMU; `tell` gets lines of progress, else they are kept.

    InputError and RunError as from reading the model, or from `make` of the kind.
    """
    source, lines = component.source, list[str]()
    tell = tell or lines.append
    assert not isinstance(source, FmuFile)
    with files_read() as files:
        if isinstance(source, Kind):
            for path in named_files(system, source):  # however the kind reads them
                depends_on(path)
            make = kind_module(source.name).make
            made = make(source.config, name=component.name, folder=system.folder, progress=tell)
        else:
            from m4e_fmi.model import load_model
            from m4e_fmi.multibody import model_program

            model = load_model(source.path)
            for warning in model.warnings:
                tell(f"{WARNING}: {warning}")
            made = model_program(model)
    return Draft(made, files, tuple(lines))


def named_files(system: System, source: Kind) -> Iterator[Path]:
    """The files that are there and that the configuration of a kind names."""
    for text in _texts(source.config.model_dump(serialize_as_any=True)):
        try:
            path = system.folder / text
            if path.is_file():
                yield path
        except (OSError, ValueError):  # a text that no file can be called by
            continue


def _texts(value: Any) -> Iterator[str | Path]:
    """All texts and paths in plain data."""
    if isinstance(value, str | Path):
        yield value
    elif isinstance(value, Mapping):
        for member in value.values():
            yield from _texts(member)
    elif isinstance(value, (list, tuple, set, frozenset)):
        for member in value:
            yield from _texts(member)


def checked_inputs(system: System, *, ready: Mapping[str, Path] | None = None) -> dict[str, Draft]:
    """Drafts of those components that are quick to make.

    `ready` are the FMUs of components that need not be built. InputError with all problems of the
    components; if there are none, with those of connections, start values and the scenario.
    """
    check_components(system)
    problems: list[Problem] = []
    drafts: dict[str, Draft] = {}
    descriptions: dict[str, Description] = {}
    known: list[Component] = []
    for component in system.components:
        try:
            found = _looked_at(system, component, (ready or {}).get(component.name), drafts)
        except InputError as error:
            is_file = isinstance(component.source, FmuFile)
            problems += (
                p if is_file else system.located(component.name, p) for p in error.problems
            )
        except RunError:
            continue  # the build tells it
        else:
            if found is not None:
                descriptions[component.name] = component.described(found)
                known.append(_without_memory(component, found))
    if problems:
        raise InputError(dict.fromkeys(problems))
    if len(known) == len(system.components):
        system = replace(system, components=tuple(known))
        wiring = connect(system, descriptions)
        if system.scenario:
            problems = scenario_problems(system, descriptions, wiring)
    if problems:
        raise InputError(problems)
    return drafts


def expected_descriptions(system: System) -> dict[str, Description]:
    """Descriptions of the FMUs that the components of a right system are or will be.

    Those of kinds that take long lack what is found by the computation.
    """
    found = {c.name: _looked_at(system, c, None, {}) for c in system.components}
    components = {c.name: c for c in system.components}
    return {name: components[name].described(one) for name, one in found.items() if one}


def check_components(system: System) -> None:
    """InputError for a system that has none."""
    if not system.components:
        message, remedy = "the system has no component", "name an FMU, a model or a kind"
        raise InputError([system.problem(("components",), message, remedy)])


def _looked_at(
    system: System, component: Component, ready: Path | None, drafts: dict[str, Draft]
) -> Description | None:
    """The description of a component's FMU, made or not; None if that is not known yet."""
    name, source = component.name, component.source
    if ready is not None:
        return resized(read_description(ready), component.start)
    if isinstance(source, FmuFile):
        return None if source.member else resized(read_description(source.path), component.start)
    made: Any = None
    if not takes_long(source):
        drafts[name] = drafted(system, component)
        made = drafts[name].made
    elif isinstance(source, Kind) and (check := getattr(kind_module(source.name), "check", None)):
        made = check(source.config, folder=system.folder)
    return None if made is None else expected_description(made, Path(f"{name}.fmu"))


def _without_memory(component: Component, description: Description) -> Component:
    """The component without start values that only the finished FMU of its kind can judge.

    These are elements of arrays, as the states of a fitted memory, whose number is found by the
    computation that takes long.
    """
    if not takes_long(component.source):
        return component
    known = description.variables
    start = {n: value for n, value in component.start.items() if n in known or "[" not in n}
    return replace(component, start=start)
