"""All problems of a system's inputs, found before anything is built.

FMUs that are there are read. What is quick to make is made, in memory: a `Draft`, which is then
written as an FMU. The `check` of a kind that takes long finds its problems, and returns a program
with the variables that its FMU will have. Connections and start values are checked against all of
these. What leads to a component that is wrong itself is not checked: that may follow from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from m4e_fmi.cosim.connections.connect import connect, connection_problems
from m4e_fmi.cosim.input_checks.drafts import Draft, drafted, takes_long
from m4e_fmi.cosim.scenario.plan import scenario_problems
from m4e_fmi.cosim.system.component import Component, FmuFile, Kind, kind_module
from m4e_fmi.cosim.system.component_units import with_units
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.fmu import Description, read_description
from m4e_fmi.fmu.export.expected import expected_description
from m4e_fmi.fmu.importer.reading import resized


def checked_inputs(
    system: System,
    *,
    ready: Mapping[str, Path] | None = None,
    wrong: Mapping[str, Component | None] | None = None,
) -> tuple[list[Problem], dict[str, Draft]]:
    """All problems of the components and connections, and drafts of those that are quick to make.

    `ready` are the FMUs of components that need not be built. `wrong` are the names of further
    components, whose problems are known; of the parts of them that are right (None: there are
    none), further problems are found.
    """
    problems: list[Problem] = []
    if not system.components and not wrong:
        problems.append(no_component(system))
    drafts: dict[str, Draft] = {}
    descriptions: dict[str, Description] = {}
    for component in system.components:
        try:
            found = _looked_at(system, component, (ready or {}).get(component.name), drafts)
        except InputError as error:
            problems += _placed(system, component, error)
        except RunError:
            continue  # the build tells it
        else:
            if found is not None:
                descriptions[component.name] = with_units(component, found)
    for component in filter(None, (wrong or {}).values()):
        problems += _further_problems(system, component)
    known = tuple(_without_memory(c, descriptions) for c in system.components)
    system = replace(system, components=known)
    problems += connection_problems(system, descriptions, wrong or ())
    if system.scenario and not problems and len(descriptions) == len(system.components):
        problems += scenario_problems(system, descriptions, connect(system, descriptions))
    return list(dict.fromkeys(problems)), drafts


def expected_descriptions(system: System) -> dict[str, Description]:
    """Descriptions of the FMUs that the components of a right system are or will be.

    Those of kinds that take long lack what is found by the computation.
    """
    found = {c.name: _looked_at(system, c, None, {}) for c in system.components}
    components = {c.name: c for c in system.components}
    return {name: with_units(components[name], one) for name, one in found.items() if one}


def no_component(system: System) -> Problem:
    """The problem of a system that has none."""
    message, remedy = "the system has no component", "name an FMU, a model or a kind"
    if system.document is None:
        return Problem(message, remedy)
    return system.document.problem(("components",), message, remedy)


def _further_problems(system: System, component: Component) -> list[Problem]:
    """Problems of the parts that are right of a component whose other problems are known.

    A kind may fail in any way on a configuration from which the wrong parts have been removed. Such
    a failure is dropped, as it follows from the known problems.
    """
    try:
        _looked_at(system, component, None, {})
    except InputError as error:
        return _placed(system, component, error)
    except Exception:  # noqa: BLE001
        return []
    return []


def _placed(system: System, component: Component, error: InputError) -> list[Problem]:
    """The problems of a component, in the system's file where they have no place of their own."""
    if isinstance(component.source, FmuFile):
        return error.problems
    return [system.located(component.name, problem) for problem in error.problems]


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


def _without_memory(component: Component, descriptions: Mapping[str, Description]) -> Component:
    """The component without start values that only the finished FMU of its kind can judge.

    These are elements of arrays, as the states of a fitted memory, whose number is found by the
    computation that takes long.
    """
    if component.name not in descriptions or not takes_long(component.source):
        return component
    known = descriptions[component.name].variables
    start = {n: value for n, value in component.start.items() if n in known or "[" not in n}
    return replace(component, start=start)
