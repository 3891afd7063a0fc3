"""A study of one program with its names resolved: programs, and start values of all runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from m4e_fmi.cosim.composition.compose import system_program
from m4e_fmi.cosim.system_file import load_system, read_system
from m4e_fmi.errors import InputError, Problem, UnknownNameError, suggestion
from m4e_fmi.files.document import Document, Location
from m4e_fmi.model import Model, load_model
from m4e_fmi.model.yaml import model_of
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Variable
from m4e_fmi.simulate import started
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import STOP_TIME, Study
from m4e_fmi.study.names import Named, Runnable, model_problems, named, system_problems
from m4e_fmi.study.programs.settings import SETTINGS, checked_settings
from m4e_fmi.study.systems.names import SystemOfStudy
from m4e_fmi.study.systems.variants import Combination, bare_code, starts_of
from m4e_fmi.study.targets import (
    KeyTarget,
    SettingTarget,
    StartTarget,
    Target,
    is_there,
    location_of,
    system_target,
    with_values,
)
from m4e_fmi.units import number_in


class ProgramOfStudy(Runnable):
    """The `program` of a study, of a `model` or of a composed system, as its file has it."""

    settings = SETTINGS

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

    @staticmethod
    def started(study: Study, program: Program, model: Model | None, run: int) -> Program:
        """The program with the start values of the study; checked with those of its first `run`.

        Angles of attitudes among them become states. What varies keeps the program's value.
        InputError for start values that do not fit together.
        """
        known, given = {v.name for v in starts_of(program)}, study.start
        first = {n: v for n, v in study.grid.values(run).items() if n in known}
        checked = started(program, {**first, **given}, model)
        return program.with_start(
            {v.name: v.start for v in starts_of(checked) if v.name in given or v.name not in first}
        )

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
        checked_settings(given)
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
class Version:
    """A program, its `code` without start values, and the model that it is of, if it is of one."""

    program: Program
    code: str
    model: Model | None = field(default=None, repr=False)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """All that has a start value: parameters, inputs, states."""
        return starts_of(self.program)

    @property
    def cuts(self) -> tuple[int, int]:
        """Places among the variables where inputs and states begin."""
        first = len(self.program.parameters)
        return first, first + len(self.program.inputs)

    def named(self, values: np.ndarray) -> dict[str, float]:
        """Start `values` (n_variables,), in SI units, by name."""
        return dict(zip((v.name for v in self.variables), values.tolist(), strict=True))


@dataclass(frozen=True)
class ProgramRuns:
    """The runs of a study of a program.

    Of each combination of values of its keys `of` has the version of the program, and start values
    (n_variables,), in SI units, which hold where nothing else is given.
    """

    named: Named
    of: Mapping[Combination, tuple[Version, np.ndarray]] = field(repr=False)

    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """Values (n_points,) of each varied name, as given, in their units, in grid order."""
        grid = self.named.study.grid
        places = np.unravel_index(np.arange(grid.size), grid.shape) if grid.axes else ()
        found: dict[str, np.ndarray] = {}
        for axis, place in zip(grid.axes, places, strict=True):
            for k, varied in enumerate(axis.varied):
                values = np.array([point[k] for point in axis.points], dtype=object)[place]
                found.update(dict.fromkeys(varied.targets, values))
        return found

    @cached_property
    def keys(self) -> dict[str, KeyTarget]:
        """Varied keys of the file, by name."""
        return {n: t for n, t in self.named.targets.items() if isinstance(t, KeyTarget)}

    @cached_property
    def combinations(self) -> list[Combination]:
        """Values of the keys of each point."""
        columns = [self.columns[name] for name in self.keys]
        return list(zip(*columns, strict=True)) if columns else [()] * self.named.study.grid.size

    @cached_property
    def settings(self) -> dict[str, np.ndarray]:
        """Values (n_points,) of the varied settings, as given in their units."""
        return {
            t.key: self.columns[n]
            for n, t in self.named.targets.items()
            if isinstance(t, SettingTarget)
        }

    @cached_property
    def _starts(self) -> dict[str, np.ndarray]:
        """Values (n_points,) of the varied start values by variable, in SI units."""
        return {
            t.whole: np.array([number_in(t.unit, v) for v in self.columns[n]], float)
            for n, t in self.named.starts.items()
        }

    def version(self, run: int) -> Version:
        """The version of the program of a run."""
        return self.of[self.combinations[run]][0]

    def start_values(self, version: Version, runs: np.ndarray) -> np.ndarray:
        """Start values (n_runs, n_variables), in SI units, of a version.

        `runs` (n_runs,) [1] are numbers of its runs, from 0.
        """
        rows = np.stack([self.of[self.combinations[run]][1] for run in runs])
        places = {v.name: k for k, v in enumerate(version.variables)}
        for name, values in self._starts.items():
            rows[:, places[name]] = values[runs]
        return rows

    def model_problems(self) -> Iterator[Problem]:
        """Faults of models with the start values of their runs."""
        given = {*(t.whole for t in self.named.starts.values()), *self.named.study.start}
        versions = {id(version): version for version, _ in self.of.values() if version.model}
        for key, version in versions.items():
            assert version.model is not None
            runs = self.named.study.grid.runs
            runs = [run for run in runs if id(self.version(run)) == key]
            values = self.start_values(version, np.array(runs))
            changed = (values != values[0]).any(axis=0)  # also by keys of the file
            names = {
                v.name: k
                for k, v in enumerate(version.variables)
                if v.name in version.model.parameters and (v.name in given or changed[k])
            }
            if names:
                yield from model_problems(version.model, [*names], values[:, [*names.values()]])


def program_runs(study: Study, *, tell: Callable[[str], None]) -> ProgramRuns:
    """The runs of a study with its names resolved and its programs made.

    InputError with all problems of names and values; if there are none, with those of programs.
    """
    program = ProgramOfStudy(study, tell)
    of: dict[Combination, tuple[Version, np.ndarray]] = {}
    runs = ProgramRuns(named(study, program), of)
    versions: dict[str, Version] = {}
    problems: list[Problem] = []
    for run in runs.named.study.grid.runs:
        own = runs.combinations[run]
        if own in of:
            continue
        given = dict(zip(runs.keys.values(), own, strict=True))
        try:
            made, model = program.made(given) if given else (program.program, program.model)
            made = program.started(runs.named.study, made, model, run)
        except InputError as error:
            told = ", ".join(f"{n} = {v}" for n, v in zip(runs.keys, own, strict=True))
            problems += [
                replace(p, message=f"{p.message} (with {told})") if told else p
                for p in error.problems
            ]
            of[own] = Version(program.program, ""), np.empty(0)
            continue
        code = bare_code(made)
        version = versions.setdefault(code, Version(made, code, model))
        of[own] = version, np.array([v.start for v in starts_of(made)])
    if not problems and program.system is not None:
        problems += system_problems(runs.named, program.system.system)
    InputError.raise_for(dict.fromkeys(problems or runs.model_problems()))
    return runs
