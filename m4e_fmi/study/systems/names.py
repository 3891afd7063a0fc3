"""A study of a system with its names resolved: what each run changes, not yet made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.start_values import single_problems
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.prepared import chosen
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Location
from m4e_fmi.fmu import Description
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.systems.models import system_problems
from m4e_fmi.study.systems.quantities import in_units, new_places
from m4e_fmi.study.systems.targets import KeyTarget, SettingTarget, StartTarget, Target, targets_of


def changed(system: System, settings: Mapping[str, object]) -> System:
    """The system with other settings of its simulation; InputError if they do not fit."""
    if odd := settings.keys() & {"start", "origin"}:
        raise InputError.single(f"the simulation has no setting {min(odd)!r}")
    return system.changed(origin="study", **settings)  # pyrefly: ignore[bad-argument-type]


@dataclass(frozen=True)
class Named:
    """A study whose names are resolved: the system with what holds for all runs, and targets.

    `descriptions` are those that the FMUs of the system have or will have.
    """

    study: Study
    system: System
    targets: Mapping[str, Target]
    descriptions: Mapping[str, Description]

    def settings(self, values: Mapping[str, Scalar]) -> dict[str, Scalar]:
        """Varied settings, of the values by name of a run."""
        return {t.key: values[n] for n, t in self.targets.items() if isinstance(t, SettingTarget)}

    def start(self, values: Mapping[str, Scalar]) -> dict[str, dict[str, Scalar]]:
        """Varied start values by component, of the values by name of a run."""
        found: dict[str, dict[str, Scalar]] = {}
        for name, target in self.targets.items():
            if isinstance(target, StartTarget):
                found.setdefault(target.component, {})[target.variable] = values[name]
        return found

    def keys(self, component: str) -> dict[str, Location]:
        """Varied keys of a component's section, by name."""
        return {
            name: target.keys
            for name, target in self.targets.items()
            if isinstance(target, KeyTarget) and target.component == component
        }

    @property
    def changing(self) -> Sequence[Component]:
        """The components whose section is varied."""
        names = {t.component for t in self.targets.values() if isinstance(t, KeyTarget)}
        return [component for component in self.system.components if component.name in names]


def named(study: Study, system: System) -> Named:
    """The study with its names resolved; InputError with all problems of names and start values."""
    found, problems = resolved(study, system)
    if problems:
        raise InputError(dict.fromkeys(problems))
    return found


def resolved(study: Study, system: System) -> tuple[Named, list[Problem]]:
    """The study with its names resolved as far as they can be, and what is wrong with them."""
    problems: list[Problem] = []
    try:
        system = changed(system, study.simulation)
    except InputError as error:
        problems += _placed(study, system, error.problems)
    try:
        system = system.changed(start=study.start, origin="study")
    except InputError as error:
        problems += error.problems
    settings = system.simulation
    problems += study.start_up_problems(settings.stop_time - settings.start_time)
    descriptions = expected_descriptions(system)
    places = [(t, v.location) for axis in study.grid.axes for v in axis.varied for t in v.targets]
    targets = targets_of(places, system, descriptions, study.document, problems)
    study, units = in_units(study, targets)
    problems += _setting_problems(study, system, targets)
    starts = _start_problems(study, system, targets, descriptions)
    problems += [*starts, *new_places(units, starts)]
    problems += _fixed_start_problems(study, system, descriptions)
    problems += _unknown_variables(study, descriptions)
    if not problems:
        problems += system_problems(study, system, targets)
    return Named(study, system, targets, descriptions), problems


def _placed(study: Study, system: System, found: Sequence[Problem]) -> Iterator[Problem]:
    """Problems of the settings of all runs, at the setting that has them also by itself."""
    of: dict[str, str] = {}
    for key, value in study.simulation.items():
        try:
            changed(system, {key: value})
        except InputError as error:
            of |= {problem.message: key for problem in error.problems}
    for one in found:
        key = of.get(one.message)
        at = ("simulation", key) if key else ("simulation",)
        yield study.document.problem(at, one.message, one.remedy)


def _setting_problems(study: Study, system: System, targets: Mapping[str, Target]) -> list[Problem]:
    """Values of varied settings that no simulation has, each by itself."""
    problems = []
    for axis in study.grid.axes:
        for k, varied in enumerate(axis.varied):
            target = targets.get(varied.targets[0])
            if not isinstance(target, SettingTarget):
                continue
            for value in dict.fromkeys(point[k] for point in axis.points):
                try:
                    changed(system, {target.key: value})
                except InputError as error:
                    problems += [
                        study.document.problem(varied.location, p.message, p.remedy)
                        for p in error.problems
                    ]
    return problems


def _fixed_start_problems(
    study: Study, system: System, descriptions: Mapping[str, Description]
) -> Iterator[Problem]:
    """Start values of all runs that their variables do not take, or that no component has."""
    components = {component.name: component for component in system.components}
    for name, value in study.start.items():
        component, _, variable = name.partition(".")
        if component not in components or component not in descriptions:
            continue
        part = Component(component, components[component].source, {variable: value})
        for one in single_problems(system, part, descriptions[component]):
            yield study.document.problem(("start", name), one.message, one.remedy)


def _start_problems(
    study: Study,
    system: System,
    targets: Mapping[str, Target],
    descriptions: Mapping[str, Description],
) -> list[Problem]:
    """Values of varied start values that their variables do not take, each by itself."""
    problems = []
    components = {component.name: component for component in system.components}
    for axis in study.grid.axes:
        for k, varied in enumerate(axis.varied):
            for target in filter(None, map(targets.get, varied.targets)):
                if not isinstance(target, StartTarget):
                    continue
                for value in dict.fromkeys(point[k] for point in axis.points):
                    start = {target.variable: value}
                    part = Component(target.component, components[target.component].source, start)
                    found = single_problems(system, part, descriptions[target.component])
                    problems += [
                        study.document.problem(varied.location, p.message, p.remedy) for p in found
                    ]
    return problems


def _unknown_variables(study: Study, descriptions: Mapping[str, Description]) -> list[Problem]:
    """Wanted variables that no FMU has."""
    places = [((("wanted", w.name, "variable", "@value")), w.variable) for w in study.wanted]
    places += [(("series", k), name) for k, name in enumerate(study.series)]
    problems = []
    for at, name in places:
        try:
            members = chosen(descriptions, [name])
        except InputError as error:
            (problem,) = error.problems
            problems.append(study.document.problem(at, problem.message, problem.remedy))
            continue
        found = [v for one in members.values() for v in one]
        if len(found) != 1:
            message = f"{name} stands for {len(found)} variables"
            problems.append(study.document.problem(at, message, "name one of them"))
        elif found[0].type not in ("Real", "Integer", "Enumeration", "Boolean"):
            message = f"{name} is of type {found[0].type}, of which there are no statistics"
            problems.append(study.document.problem(at, message))
    return problems
