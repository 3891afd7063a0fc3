"""The names of a study compared with what it runs: targets, values in their units, problems."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.cosim.system.component import ModelFile
from m4e_fmi.cosim.system.simulation import TOLERANCES
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import Location
from m4e_fmi.model import Model, load_model
from m4e_fmi.study.given.grid import Varied
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.targets import (
    SIMULATION,
    KeyTarget,
    SettingTarget,
    StartTarget,
    Target,
    Targets,
)
from m4e_fmi.units import number_in, parse_unit

RENAME = "convert the column if need be, and leave the unit out of its name"


class Runnable(ABC):
    """A system or a program that a study runs, by which its names and values are judged.

    Each method raises an InputError for what is wrong; its problems need no place. `settings` are
    the names of settings that may be varied.
    """

    settings: Sequence[str]

    @abstractmethod
    def target(self, name: str) -> Target:
        """The meaning of a varied name that is no setting."""

    @abstractmethod
    def check_settings(self, given: Mapping[str, Scalar]) -> None:
        """Settings of a run, together."""

    @abstractmethod
    def check_start(self, name: str, value: Scalar) -> None:
        """A start value by the whole name of its variable."""

    @abstractmethod
    def check_variable(self, name: str) -> None:
        """A variable whose series or statistic is wanted."""


@dataclass(frozen=True)
class Named:
    """A study whose names are resolved, with its values in the units of its `targets`."""

    study: Study
    targets: Targets

    def settings(self, values: Mapping[str, Scalar]) -> dict[str, Scalar]:
        """Varied settings, of the values by name of a run."""
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


def named(study: Study, of: Runnable) -> Named:
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
