"""The runs of a study of one program: programs, and start values of all runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.model import Model
from m4e_fmi.program import Program, Variable
from m4e_fmi.simulate import started
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.names import Named, ProgramOfStudy, model_problems, named, system_problems
from m4e_fmi.study.systems.variants import bare_code, starts_of
from m4e_fmi.study.targets import Combination, KeyTarget, made_for
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
        return self.named.settings(self.columns)

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
    grid, stated = runs.named.study.grid, runs.named.study.start
    first_of = {runs.combinations[run]: run for run in reversed(grid.runs)}

    def make(own: Combination) -> tuple[Version, np.ndarray]:
        given = dict(zip(runs.keys.values(), own, strict=True))
        made, model = program.made(given) if given else (program.program, program.model)
        # angles of attitudes become states; what varies keeps the program's value
        known = {v.name for v in starts_of(made)}
        first = {n: v for n, v in grid.values(first_of[own]).items() if n in known}
        checked = starts_of(started(made, {**first, **stated}, model))
        made = made.with_start(
            {v.name: v.start for v in checked if v.name in stated or v.name not in first}
        )
        code = bare_code(made)
        version = versions.setdefault(code, Version(made, code, model))
        return version, np.array([v.start for v in starts_of(made)])

    of |= made_for((runs.combinations[run] for run in grid.runs), [*runs.keys], make)
    problems = system_problems(runs.named, program.system.system) if program.system else ()
    InputError.raise_for(dict.fromkeys([*problems] or runs.model_problems()))
    return runs
