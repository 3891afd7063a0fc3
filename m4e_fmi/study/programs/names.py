"""A study of one program with its names resolved: programs, and start values of all runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from m4e_fmi.cosim.composition.compose import system_program
from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import load_system, read_system
from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import Document, Location
from m4e_fmi.model import Model, load_model
from m4e_fmi.model.yaml import model_of
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Variable
from m4e_fmi.simulate import started
from m4e_fmi.study.dataset import Labels
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.programs.settings import (
    SETTINGS,
    count_problems,
    fixed_settings,
    setting,
    varied_problems,
)
from m4e_fmi.study.programs.values import start_problems, unknown_starts
from m4e_fmi.study.systems.models import model_problems, system_problems
from m4e_fmi.study.systems.quantities import in_units, new_places
from m4e_fmi.study.systems.targets import (
    SIMULATION,
    KeyTarget,
    SettingTarget,
    StartTarget,
    Target,
    is_there,
    location_of,
    targets_of,
    with_values,
)
from m4e_fmi.study.systems.variants import bare_code
from m4e_fmi.units import number_in


@dataclass(frozen=True)
class Version:
    """A program, its `code` without start values, and the model that it is of, if it is of one."""

    program: Program
    code: str
    model: Model | None = field(default=None, repr=False)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """All that has a start value: parameters, inputs, states."""
        return (*self.program.parameters, *self.program.inputs, *self.program.states)

    @property
    def cuts(self) -> tuple[int, int]:
        """Places among the variables where inputs and states begin."""
        first = len(self.program.parameters)
        return first, first + len(self.program.inputs)

    def named(self, values: np.ndarray) -> dict[str, float]:
        """Start `values` (n_variables,), in SI units, by name."""
        return dict(zip((v.name for v in self.variables), values.tolist(), strict=True))


@dataclass(frozen=True)
class NamedProgram:
    """A study of a program with its names resolved.

    `fixed` are the settings that all runs have. `version_of` has the number of the program of each
    run, by number, `default_of` that of its start values among the `defaults` (n_variables,), which
    hold where nothing else is given.
    """

    study: Study
    targets: Mapping[str, Target]
    versions: Sequence[Version]
    version_of: Mapping[int, int] = field(repr=False)
    fixed: Mapping[str, object]
    defaults: Sequence[np.ndarray] = field(repr=False)
    default_of: Mapping[int, int] = field(repr=False)

    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """Values (n_points,) of each varied name, as given, in their units, in grid order."""
        grid = self.study.grid
        places = np.unravel_index(np.arange(grid.size), grid.shape) if grid.axes else ()
        found: dict[str, np.ndarray] = {}
        for axis, place in zip(grid.axes, places, strict=True):
            for k, varied in enumerate(axis.varied):
                values = np.array([point[k] for point in axis.points], dtype=object)[place]
                found.update(dict.fromkeys(varied.targets, values))
        return found

    @cached_property
    def settings(self) -> dict[str, np.ndarray]:
        """Values (n_points,) of the varied settings; times in s."""
        return {
            target.key: np.array([setting(target.key, v) for v in self.columns[name]], object)
            for name, target in self.targets.items()
            if isinstance(target, SettingTarget)
        }

    @cached_property
    def _starts(self) -> dict[str, np.ndarray]:
        """Values (n_points,) of the varied start values by variable, in SI units."""
        return {
            target.variable: np.array([_number(target, v) for v in self.columns[name]], float)
            for name, target in self.targets.items()
            if isinstance(target, StartTarget)
        }

    def start_values(self, version: Version, runs: np.ndarray) -> np.ndarray:
        """Start values (n_runs, n_variables), in SI units, of a version.

        `runs` (n_runs,) [1] are numbers of its runs, from 0.
        """
        rows = np.stack([self.defaults[self.default_of[run]] for run in runs])
        places = {v.name: k for k, v in enumerate(version.variables)}
        for name, values in self._starts.items():
            rows[:, places[name]] = values[runs]
        return rows

    def labels(self) -> Labels:
        """Units and descriptions of varied names and wanted variables."""
        varied = {
            name: (target.unit, target.text)
            for name, target in self.targets.items()
            if isinstance(target, StartTarget)
        }
        program = self.versions[0].program
        known = (*program.states, *program.outputs)
        return Labels(varied, {v.name: (v.unit, v.description) for v in known})


def _number(target: StartTarget, value: Scalar) -> float:
    return number_in(target.unit, value)


Keys = Mapping[KeyTarget, object]
Made = tuple[Program, Model | None]
Source = Callable[[Keys], Made]
"""Makes the program of a study with other values of some keys of its file."""


def named_program(study: Study, *, tell: Callable[[str], None]) -> NamedProgram:
    """The study with its names resolved and its programs made; InputError with all problems."""
    problems: list[Problem] = []
    fixed = fixed_settings(study, problems)
    source, base, targets = (_of_system if study.composed else _of_model)(study, tell, problems)
    study, units = in_units(study, targets)
    problems += _setting_problems(study, targets)
    program, model = base
    starts = start_problems(study, targets, program)
    problems += [*starts, *new_places(units, starts), *unknown_starts(study, program, model)]
    made = _Versions(study, source, base, targets, checks_start=not problems)
    version_of, default_of = dict[int, int](), dict[int, int]()
    for run in study.grid.runs:
        version_of[run], default_of[run] = made.of(run, problems)
    if problems:
        raise InputError(dict.fromkeys(problems))
    named = NamedProgram(
        study, targets, made.versions, version_of, fixed, made.defaults, default_of
    )
    if problems := list(_model_problems(named)):
        raise InputError(dict.fromkeys(problems))
    return named


def _model_problems(named: NamedProgram) -> Iterator[Problem]:
    """Counts of rows and steps beyond the limits, faults of models with their start values."""
    yield from count_problems(named.study, named.fixed, named.settings)
    if named.study.composed:
        parts = {n: _of_component(t) for n, t in named.targets.items()}
        yield from system_problems(named.study, load_system(named.study.source), parts)
    given = {t.variable for t in named.targets.values() if isinstance(t, StartTarget)}
    given |= named.study.start.keys()
    for number, version in enumerate(named.versions):
        if version.model is None:
            continue
        names = [v.name for v in version.variables]
        runs = np.array([run for run, of in named.version_of.items() if of == number])
        values = named.start_values(version, runs)
        changed = (values != values[0]).any(axis=0)  # also by keys of the file
        places = [
            k
            for k, n in enumerate(names)
            if n in version.model.parameters and (n in given or changed[k])
        ]
        if places:
            yield from model_problems(version.model, [names[k] for k in places], values[:, places])


def _of_component(target: Target) -> Target:
    """A target of a composed system as that of its component."""
    if not isinstance(target, StartTarget):
        return target
    component, _, variable = target.variable.partition(".")
    return replace(target, component=component, variable=variable)


class _Versions:
    """The programs of a study, and the start values that each combination of its keys gives them.

    The latter are compared with what the programs take if that `checks_start`.
    """

    def __init__(
        self,
        study: Study,
        source: Source,
        base: Made,
        targets: Mapping[str, Target],
        *,
        checks_start: bool,
    ) -> None:
        self.versions: list[Version] = []
        self.defaults: list[np.ndarray] = []
        self._study, self._checks_start = study, checks_start
        self._source, self._base = source, base
        self._keys = {n: t for n, t in targets.items() if isinstance(t, KeyTarget)}
        self._codes: dict[str, int] = {}
        self._made: dict[tuple[object, ...], tuple[int, int]] = {}

    def of(self, run: int, problems: list[Problem]) -> tuple[int, int]:
        """Numbers of the version and of the defaults of a run, from 0; adds to `problems`."""
        values = self._study.grid.values(run) if self._keys else {}
        own = tuple(values[name] for name in self._keys)
        if own not in self._made:
            self._made[own] = -1, -1
            try:
                given = dict(zip(self._keys.values(), own, strict=True))
                self._made[own] = self._new(given, run)
            except InputError as error:
                told = ", ".join(f"{n} = {values[n]}" for n in self._keys)
                problems += [
                    replace(p, message=f"{p.message} (with {told})") if told else p
                    for p in error.problems
                ]
        return self._made[own]

    def _new(self, given: Keys, run: int) -> tuple[int, int]:
        program, model = self._source(given) if given else self._base
        if self._checks_start:
            program = _with_start(self._study, program, model, run)
        version = Version(program, bare_code(program), model)
        if version.code not in self._codes:
            self._codes[version.code] = len(self.versions)
            self.versions.append(version)
        self.defaults.append(np.array([v.start for v in version.variables]))
        return self._codes[version.code], len(self.defaults) - 1


def _of_model(
    study: Study, tell: Callable[[str], None], problems: list[Problem]
) -> tuple[Source, Made, dict[str, Target]]:
    """The programs of a model's file, that of the file as it is, and meanings of varied names."""
    model = load_model(study.source)
    for warning in model.warnings:
        tell(f"warning: {warning}")
    document = Document.load(study.source) if study.source.suffix != ".urdf" else None
    names = dict(_names(study))
    inputs = tuple({*names, *study.start})

    def make(values: Keys) -> Made:
        made = model
        if values and document is not None:
            data = with_values(document.data, {t.keys: v for t, v in values.items()})
            made = model_of(document.with_data(data))
        return model_program(made, inputs=inputs), made

    base = make({})
    data = document.data if document is not None and "bodies" in document.data else {}
    return make, base, _program_targets(study, base[0], data, problems)


def _of_system(
    study: Study, tell: Callable[[str], None], problems: list[Problem]
) -> tuple[Source, Made, dict[str, Target]]:
    """The programs of a composed system, that of its file, and meanings of varied names."""
    system = load_system(study.source)

    def make(values: Keys) -> Made:
        return system_program(_with_keys(system, values), tell=tell), None

    base = make({})
    program = base[0]
    plain = [(n, at) for n, at in _names(study).items() if not n.startswith(f"{SIMULATION}.")]
    targets = _setting_targets(study, problems)
    found = targets_of(plain, system, expected_descriptions(system), study.document, problems)
    known = {v.name: v for v in (*program.parameters, *program.inputs, *program.states)}
    for name, target in found.items():
        if isinstance(target, StartTarget):
            whole = f"{target.component}.{target.variable}"
            if whole not in known:
                message = f"{name} takes no start value: a connection gives it its value"
                problems.append(study.document.problem(dict(plain)[name], message))
                continue
            target = StartTarget("", whole, target.unit, target.text)
        targets[name] = target
    problems += _unknown_variables(study, program)
    return make, base, targets


def _with_keys(system: System, values: Keys) -> System:
    """The system with other values of keys of its components."""
    document = system.document
    if not values or document is None:
        return system
    places: dict[Location, object] = {
        ("components", t.component, *t.keys): v for t, v in values.items()
    }
    return read_system(document.with_data(with_values(document.data, places)))


def _names(study: Study) -> dict[str, Location]:
    """All varied names, and where they stand."""
    varied = (v for axis in study.grid.axes for v in axis.varied)
    return {target: one.location for one in varied for target in one.targets}


def _setting_targets(study: Study, problems: list[Problem]) -> dict[str, Target]:
    found: dict[str, Target] = {}
    for name, at in _names(study).items():
        first, _, rest = name.partition(".")
        if first != SIMULATION:
            continue
        if rest in SETTINGS:
            found[name] = SettingTarget(rest)
        else:
            remedy = suggestion(rest, SETTINGS, "settings")
            problems.append(study.document.problem(at, f"there is no setting {rest!r}", remedy))
    return found


def _program_targets(
    study: Study, program: Program, data: object, problems: list[Problem]
) -> dict[str, Target]:
    """Meaning of the varied names in a model's file and program; adds to `problems`."""
    known = {v.name: v for v in (*program.parameters, *program.inputs, *program.states)}
    found = _setting_targets(study, problems)
    for name, at in _names(study).items():
        if name.startswith(f"{SIMULATION}."):
            continue
        keys = location_of(name)
        if name in known:
            found[name] = StartTarget("", name, known[name].unit, known[name].description)
        elif is_there(data, keys):
            found[name] = KeyTarget("", keys)
        else:
            message = f"the model has no parameter, start value or key {name!r}"
            remedy = suggestion(name, known, "start values")
            problems.append(study.document.problem(at, message, remedy))
    problems += _unknown_variables(study, program)
    return found


def _unknown_variables(study: Study, program: Program) -> list[Problem]:
    """Wanted variables that are no state, output or work of the program."""
    known = {v.name for v in (*program.states, *program.outputs)}
    known |= {f"{n.removesuffix('.power')}.work" for n in known if n.endswith(".power")}
    places = [(("wanted", w.name, "variable", "@value"), w.variable) for w in study.wanted]
    places += [(("series", k), name) for k, name in enumerate(study.series)]
    return [
        study.document.problem(at, f"there is no variable {name!r}", suggestion(name, known))
        for at, name in places
        if name not in known
    ]


def _setting_problems(study: Study, targets: Mapping[str, Target]) -> Iterator[Problem]:
    """Values of varied settings that no simulation has."""
    for axis in study.grid.axes:
        for k, varied in enumerate(axis.varied):
            values = [point[k] for point in axis.points]
            for target in map(targets.get, varied.targets):
                if isinstance(target, SettingTarget):
                    yield from varied_problems(study, target.key, values, varied.location)


def _with_start(study: Study, program: Program, model: Model | None, run: int) -> Program:
    """The program with the start values of the study; checked with those of its first `run`.

    Angles of attitudes among them become states. What varies keeps the program's value.
    """
    known = {v.name for v in (*program.parameters, *program.inputs, *program.states)}
    first = {n: v for n, v in study.grid.values(run).items() if n in known}
    given = study.start
    checked = started(program, {**first, **given}, model)
    variables = (*checked.parameters, *checked.inputs, *checked.states)
    return program.with_start(
        {v.name: v.start for v in variables if v.name in given or v.name not in first}
    )
