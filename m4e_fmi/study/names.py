"""The names of a study compared with what it runs: targets, values in their units, problems.

A study runs a `SystemOfStudy` or a `ProgramOfStudy`, by which its names and values are judged.
Their `settings` are the names of settings that may be varied; `target` gives the meaning of another
varied name, and `check_…` raise an InputError for what is wrong, whose problems need no place.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from m4e_fmi.cosim.composition.compose import system_program
from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.component import Component, ModelFile
from m4e_fmi.cosim.system.simulation import CHECKPOINTS, SETTINGS, TOLERANCES
from m4e_fmi.cosim.system.start_values import single_problems
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import load_system, read_system
from m4e_fmi.cosim.wiring.prepared import chosen
from m4e_fmi.errors import InputError, Problem, UnknownNameError, suggestion
from m4e_fmi.files.document import Document, Location
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.model import Model, load_model
from m4e_fmi.model.yaml import model_of
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.simulate import started
from m4e_fmi.study.given.grid import Varied
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import STOP_TIME, Study
from m4e_fmi.study.programs import settings as program_settings
from m4e_fmi.study.systems.variants import starts_of
from m4e_fmi.study.targets import (
    SIMULATION,
    KeyTarget,
    SettingTarget,
    StartTarget,
    Target,
    Targets,
    is_there,
    location_of,
    system_target,
    with_values,
)
from m4e_fmi.units import number_in, parse_unit

Value = TypeVar("Value")
RENAME = "convert the column if need be, and leave the unit out of its name"


def changed(system: System, settings: Mapping[str, object]) -> System:
    """The system with other settings of its simulation; InputError if they do not fit."""
    if odd := settings.keys() & {"start", "origin"}:
        raise InputError.single(f"the simulation has no setting {min(odd)!r}")
    return system.changed(origin="study", **settings)  # pyrefly: ignore[bad-argument-type]


class SystemOfStudy:
    """The `system` of a study with what holds for all runs, as far as that fits.

    `descriptions` are those that its FMUs have or will have.
    """

    settings = tuple(key for key in SETTINGS if key not in CHECKPOINTS)

    def __init__(self, study: Study) -> None:
        self._given = self.system = load_system(study.source)
        if not study.composed:
            with suppress(InputError):
                self.system = changed(self.system, study.simulation)
        with suppress(InputError):
            self.system = self.system.changed(start=study.start, origin="study")
        self.descriptions = expected_descriptions(self.system)
        self._components = {one.name: one for one in self.system.components}

    def target(self, name: str) -> Target:
        """The meaning of a varied name that is no setting."""
        return system_target(self.system, self.descriptions, name)

    def check_settings(self, given: Mapping[str, Scalar]) -> None:
        """Settings of all runs, together."""
        changed(self._given, given)

    def check_start(self, name: str, value: Scalar) -> None:
        """A start value by the whole name of its variable."""
        component, _, variable = name.partition(".")
        self.system.changed(start={name: value}, origin="study")
        if component in self.descriptions:
            part = Component(component, self._components[component].source, {variable: value})
            found = single_problems(self.system, part, self.descriptions[component])
            InputError.raise_for(found)

    def check_variable(self, name: str) -> None:
        """A variable whose series or statistic is wanted."""
        members = chosen(self.descriptions, [name])
        found = [v for one in members.values() for v in one]
        if len(found) != 1:
            message = f"{name} stands for {len(found)} variables"
            raise InputError.single(message, "name one of them")
        if found[0].type not in ("Real", "Integer", "Enumeration", "Boolean"):
            message = f"{name} is of type {found[0].type}, of which there are no statistics"
            raise InputError.single(message)

    def variable(self, name: str) -> Variable:
        """The variable ``component.variable``."""
        component, _, variable = name.partition(".")
        return self.descriptions[component].variables[variable]


class ProgramOfStudy:
    """The `program` of a study, of a `model` or of a composed system, as its file has it."""

    settings = program_settings.SETTINGS

    def __init__(self, study: Study, tell: Callable[[str], None]) -> None:
        self._study, self._tell = study, tell
        self.system = SystemOfStudy(study) if study.composed else None
        self._file = None if study.source.suffix == ".urdf" else Document.load(study.source)
        self._model = None if study.composed else load_model(study.source)
        for warning in self._model.warnings if self._model else ():
            tell(f"warning: {warning}")
        self.program, self.model = self.made({})
        self._known = {v.name: v for v in starts_of(self.program)}

    def made(self, values: Mapping[KeyTarget, object]) -> tuple[Program, Model | None]:
        """The program with other values of keys of the file, and its model, if it is of one.

        InputError for values that the file cannot have.
        """
        model, file = self._model, self._file
        if values and file is not None:
            above = ("components",) if model is None else ()
            places: dict[Location, object] = {
                (*above, *filter(None, (t.component,)), *t.keys): v for t, v in values.items()
            }
            file = file.with_data(with_values(file.data, places))
        if model is None:
            assert file is not None
            system = read_system(file) if values else load_system(self._study.source)
            return system_program(system, tell=self._tell), None
        if values and file is not None:
            model = model_of(file)
        inputs = {*self._study.grid.places, *self._study.start}
        return model_program(model, inputs=tuple(inputs)), model

    def target(self, name: str) -> Target:
        """The meaning of a varied name that is no setting."""
        if self.system is not None:
            found = system_target(self.system.system, self.system.descriptions, name)
            if isinstance(found, StartTarget) and found.whole not in self._known:
                message = f"{name} takes no start value: a connection gives it its value"
                raise InputError.single(message)
            return found
        if name in self._known:
            return StartTarget("", name, self._known[name].unit, self._known[name].description)
        data = self._file.data if self._file is not None else {}
        if "bodies" in data and is_there(data, location_of(name)):
            return KeyTarget("", location_of(name))
        message = f"the model has no parameter, start value or key {name!r}"
        raise InputError.single(message, suggestion(name, self._known, "start values"))

    def check_settings(self, given: Mapping[str, Scalar]) -> None:
        """Settings of all runs, together."""
        program_settings.checked_settings(given)
        if "stop_time" not in given and STOP_TIME not in self._study.grid.places:
            remedy = "write simulation: {stop_time: 10}"
            raise InputError.single("the study has no stop_time", remedy)

    def check_start(self, name: str, value: Scalar) -> None:
        """A start value by the whole name of its variable."""
        if name not in self._known:
            try:
                started(self.program, {name: value}, self.model)
            except UnknownNameError:
                raise
            except InputError:  # of an attitude: told with all start values
                pass
            return
        one = self._known[name]
        try:
            number = number_in(one.unit, value)
        except ValueError as error:
            raise InputError.single(f"{name}: {error}") from None
        if not one.minimum <= number <= one.maximum:
            limits = f"is outside its range from {one.minimum:g} to {one.maximum:g}"
            raise InputError.single(f"{name} = {number:g} {limits}")

    def check_variable(self, name: str) -> None:
        """A variable whose series or statistic is wanted: a state, an output or a work."""
        known = {v.name for v in (*self.program.states, *self.program.outputs)}
        known |= {f"{n.removesuffix('.power')}.work" for n in known if n.endswith(".power")}
        if name not in known:
            raise InputError.single(f"there is no variable {name!r}", suggestion(name, known))


@dataclass(frozen=True)
class Named:
    """A study whose names are resolved, with its values in the units of its `targets`."""

    study: Study
    targets: Targets

    def settings(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """Varied settings, of the values by name of a run, or of all."""
        return {t.key: values[n] for n, t in self.targets.items() if isinstance(t, SettingTarget)}

    def keys(self, component: str) -> dict[str, Location]:
        """Varied keys of the section of a component, or of a model's file (""), by name."""
        return {
            name: target.keys
            for name, target in self.targets.items()
            if isinstance(target, KeyTarget) and target.component == component
        }

    @property
    def starts(self) -> dict[str, StartTarget]:
        """Varied start values by name."""
        return {n: t for n, t in self.targets.items() if isinstance(t, StartTarget)}


def named(study: Study, of: SystemOfStudy | ProgramOfStudy) -> Named:
    """The study with its names resolved; InputError with all problems of names and of values."""

    def wrong(at: Location, check: Callable[..., object], *values: object) -> list[Problem]:
        try:
            check(*values)
        except InputError as error:
            return [study.document.problem(at, p.message, p.remedy) for p in error.problems]
        return []

    targets: dict[str, Target] = {}

    def resolve(name: str) -> None:
        first, _, rest = name.partition(".")
        if first != SIMULATION:
            targets[name] = of.target(name)
        elif rest in of.settings:
            targets[name] = SettingTarget(rest)
        else:
            remedy = suggestion(rest, of.settings, "settings")
            raise InputError.single(f"{name}: there is no setting {rest!r}", remedy)

    problems: list[Problem] = []
    sound = True
    try:
        of.check_settings(study.simulation)
    except InputError as error:
        sound = False
        problems += setting_problems(study, error)
    for name, at in study.grid.places.items():
        problems += wrong(at, resolve, name)
    for name, value in study.start.items():
        problems += wrong(("start", name), of.check_start, name, value)
    study, units = in_units(study, targets)
    for axis in study.grid.axes:
        for k, varied in enumerate(axis.varied):
            for target in filter(None, map(targets.get, varied.targets)):
                for value in dict.fromkeys(point[k] for point in axis.points):
                    if isinstance(target, SettingTarget) and sound:
                        given = {**study.simulation, target.key: value}
                        problems += wrong(varied.location, of.check_settings, given)
                    elif isinstance(target, StartTarget):
                        problems += wrong(varied.location, of.check_start, target.whole, value)
    told = {(one.line, one.column) for one in problems}
    problems += [one for one in units if (one.line, one.column) not in told]
    for w in study.wanted:
        at = ("wanted", w.name, "variable", "@value")
        problems += wrong(at, of.check_variable, w.variable)
    for k, name in enumerate(study.series):
        problems += wrong(("series", k), of.check_variable, name)
    InputError.raise_for(dict.fromkeys(problems))
    return Named(study, targets)


def setting_problems(study: Study, error: InputError) -> Iterator[Problem]:
    """Problems of settings, at the first setting of the study that each names."""
    places = {key: (SIMULATION, key) for key in study.simulation}
    varied = study.grid.places.items()
    places |= {key: at for n, at in varied if (key := n.removeprefix(f"{SIMULATION}.")) != n}
    for one in error.problems:
        known = [places[word] for word in re.findall(r"\w+", one.message) if word in places]
        yield study.document.problem(next(iter(known), (SIMULATION,)), one.message, one.remedy)


def in_units(study: Study, targets: Targets) -> tuple[Study, list[Problem]]:
    """The study whose start values are numbers in the units of their variables.

    Texts with a unit, as ``"5 mm"``, and columns of tables whose names have one are converted.
    Problems are values of other dimension, and units of what takes plain numbers only: they stay as
    they are, as do those of names without a target.
    """
    problems: list[Problem] = []
    axes = []
    for axis in study.grid.axes:
        columns = [[point[k] for point in axis.points] for k in range(len(axis.varied))]
        for k, varied in enumerate(axis.varied):
            if not all(name in targets for name in varied.targets):
                continue
            of = [targets[name] for name in varied.targets]
            try:
                columns[k] = _converted(varied, of, columns[k])
            except ValueError as error:
                message = f"{varied.targets[0]}: {error}"
                remedy = RENAME if varied.column else ""
                problems.append(study.document.problem(varied.location, message, remedy))
        axes.append(replace(axis, points=tuple(zip(*columns, strict=True))))
    return replace(study, grid=replace(study.grid, axes=tuple(axes))), problems


def _converted(varied: Varied, targets: Sequence[Target], values: Sequence[Scalar]) -> list[Scalar]:
    """The values of a varied quantity; ValueError where they do not fit."""
    units = set(map(_unit, targets))
    unit = units.pop() if len(units) == 1 else None
    if varied.unit:
        given = parse_unit(varied.unit)
        of_component = isinstance(targets[0], KeyTarget) and targets[0].component
        unclear = of_component and given.same_dimension(parse_unit("rad"))  # some keys are in deg
        if unit is None and (given.factor != 1.0 or unclear):
            message = f"the column {varied.column!r} names a unit, but {targets[0]} takes numbers"
            raise ValueError(f"{message} as its documentation says")
        if unit:  # a variable without a unit takes any
            try:
                return [number_in(unit, f"{value!r} {varied.unit}") for value in values]
            except ValueError as error:
                raise ValueError(f"the column {varied.column!r}: {error}") from None
    if unit is None or not isinstance(targets[0], StartTarget):
        return [*values]
    return [number_in(unit, value) if isinstance(value, str) else value for value in values]


def _unit(target: Target) -> str | None:
    """Unit of the numbers that a target takes; None if only its documentation says it."""
    if isinstance(target, SettingTarget):
        return "1" if target.key in TOLERANCES else "s"
    return target.unit if isinstance(target, StartTarget) and target.is_real else None


def model_problems(model: Model, names: Sequence[str], values: np.ndarray) -> list[Problem]:
    """Faults of a model with the values of runs, each once, by the first run that has it.

    `values` (n_runs, n_names) are those of the parameters `names`, in SI units.
    """
    first: dict[Problem, Problem] = {}
    count: Counter[Problem] = Counter()
    check = model.check_of(names)
    for row, runs in Counter(map(tuple, values.tolist())).items():
        for problem in check(dict(zip(names, row, strict=True))):
            fault = replace(problem, message="")
            first.setdefault(fault, problem)
            count[fault] += runs
    of = f"of {len(values)} runs"
    return [replace(p, message=f"{p.message}: in {count[f]} {of}") for f, p in first.items()]


def system_problems(named: Named, system: System) -> Iterator[Problem]:
    """The same of the models of a system whose files do not change.

    The system has the start values of all runs; of the targets each by itself is right.
    """
    grid = named.study.grid
    for component in system.components:
        varied = {n: t for n, t in named.starts.items() if t.component == component.name}
        source = component.source
        if not varied or named.keys(component.name) or not isinstance(source, ModelFile):
            continue
        model = load_model(source.path)
        fixed: dict[str, float] = {}
        for name, value in component.start.items():
            if name in model.parameters and isinstance(value, int | float | str):
                with suppress(ValueError):  # told where start values are checked one by one
                    unit = parse_unit(model.parameters[name].unit)
                    fixed[name] = number_in(unit.coherent_text, value)
        for target in varied.values():
            fixed.pop(target.variable, None)
        rows = [
            [*(number_in(t.unit, values[n]) for n, t in varied.items()), *fixed.values()]
            for values in map(grid.values, grid.runs)
        ]
        names = [*(t.variable for t in varied.values()), *fixed]
        yield from model_problems(model, names, np.array(rows))


def named_system(study: Study) -> tuple[Named, SystemOfStudy]:
    """A study of a system with its names resolved, and the system; InputError with all problems."""
    of = SystemOfStudy(study)
    found = named(study, of)
    InputError.raise_for(dict.fromkeys(system_problems(found, of.system)))
    return found, of
