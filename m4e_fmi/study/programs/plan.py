"""The plan of a study of one program: a model, or a system whose equations are connected.

Runs that differ in start values are members of an ensemble, many in one call of the C library. What
an ensemble cannot do is made by single simulations: see `single_because`.
"""

from __future__ import annotations

import hashlib
import json
import math
import time as clock
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby

import numpy as np

from m4e_fmi.code_hash import code_hash
from m4e_fmi.errors import InputError, Problem, RunError
from m4e_fmi.files.limits import beyond_limits
from m4e_fmi.multibody.diagnosis import diagnosis
from m4e_fmi.program import Program, kinks
from m4e_fmi.runtime.engine import Control, Run, ensemble
from m4e_fmi.shown import one_line
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.simulation import output_times
from m4e_fmi.study.dataset import Batch, Labels, Work, rows_text
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.names import setting_problems
from m4e_fmi.study.programs.chunks import Pace, chunks, in_threads
from m4e_fmi.study.programs.names import Version, program_runs
from m4e_fmi.study.programs.settings import Settings, checked_settings
from m4e_fmi.study.record import Record, records_of
from m4e_fmi.study.report.record import inputs_of
from m4e_fmi.study.shown.warnings import WARNING
from m4e_fmi.study.start_up import RAMP, first_time, ramp_warnings

ENSEMBLE_METHODS = ("dop853", "rk45", "rk4")


@dataclass(frozen=True)
class RunGroup:
    """Runs of one program with the same settings: `runs` are their numbers, from 0."""

    version: Version
    settings: Settings
    runs: np.ndarray = field(repr=False)


class ProgramPlan:
    """The runs of a study of a program; `tell` gets lines on how it is made.

    `groups` are runs of one program and one set of settings each, in order; rows of each run count
    from `start_up` (n_points,) [s] on. InputError with all problems of the study.
    """

    def __init__(self, study: Study, tell: Callable[[str], None]) -> None:
        self.warnings: dict[str, int] = {}

        def tell_and_note(line: str) -> None:
            if WARNING in line:
                self.warnings[line.replace(WARNING, "", 1)] = study.grid.count
            tell(line)

        self.runs = program_runs(study, tell=tell_and_note)
        self.named, self.study = self.runs.named, self.runs.named.study
        wanted = (*(w.variable for w in study.wanted), *study.series)
        self._names = list(dict.fromkeys(wanted))
        self.start_up = [math.nan] * study.grid.size  # [s], by `work`
        members: dict[tuple[str, str], list[int]] = {}
        for run in study.grid.runs:
            version = self.runs.version(run)
            own = {key: column[run] for key, column in self.runs.settings.items()}
            members.setdefault((version.code, json.dumps(own)), []).append(run)
        self.groups = [
            RunGroup(self.runs.version(runs[0]), self._settings(json.loads(own)), np.array(runs))
            for (_, own), runs in members.items()
        ]

    def _settings(self, own: Mapping[str, Scalar]) -> Settings:
        """The settings of runs with their `own` ones; InputError for too many rows or steps."""
        try:
            given = checked_settings({**self.study.simulation, **own})
            found = Settings(**given)  # pyrefly: ignore[bad-argument-type]
            beyond = beyond_limits(
                found.stop_time, output_interval=found.output_interval, step_size=found.step_size
            )
            InputError.raise_for(Problem(message, remedy) for _, message, remedy in beyond)
            return found
        except InputError as error:
            raise InputError(setting_problems(self.study, error)) from None

    def work(self, jobs: int) -> Work:
        """The runs, made in `jobs` threads. InputError if no row of one counts."""
        study, inputs = self.study, inputs_of(self.study)
        keys = [""] * study.grid.size
        every: list[Mapping[str, float]] = []
        for group in self.groups:
            wanted = repr((study.wanted, study.series))
            same = [code_hash(), group.version.code, repr(group.settings), wanted]
            names = [v.name for v in group.version.variables]
            same += [repr(names), f"{bool(single_because(group, self._names))}"]
            base = hashlib.sha256("\0".join(same).encode())
            ramps = [k for k, name in enumerate(names) if name.rpartition(".")[2] == RAMP]
            rows = np.ascontiguousarray(self.runs.start_values(group.version, group.runs))
            for run, row in zip(group.runs.tolist(), rows, strict=True):
                every.append({names[k]: float(row[k]) for k in ramps})
                self.start_up[run] = first_time(study, every[-1], 0.0, group.settings.stop_time)
                own = base.copy()
                own.update(row.tobytes())
                own.update(repr(self.start_up[run]).encode())
                keys[run] = own.hexdigest()

        def records(missing: Sequence[int]) -> Generator[Batch]:
            yield from in_threads(self._calls({*missing}, jobs), jobs)

        return Work(
            study=study,
            keys=keys,
            start_up=self.start_up,
            labels=self._labels(),
            inputs=inputs,
            warnings={**self.warnings, **ramp_warnings(study, every)},
            notes=self.notes(),
            records=records,
            rows=rows_text([group.settings.output_interval for group in self.groups]),
        )

    def _labels(self) -> Labels:
        """Units and descriptions of varied names and wanted variables."""
        varied = {name: (target.unit, target.text) for name, target in self.named.starts.items()}
        program = self.groups[0].version.program
        known = (*program.states, *program.outputs)
        return Labels(varied, {v.name: (v.unit, v.description) for v in known})

    def notes(self) -> list[str]:
        """How the runs are made, a line each."""
        lines = []
        for why, groups in groupby(self.groups, lambda g: single_because(g, self._names)):
            count = sum(len(group.runs) for group in groups)
            how = f"single simulations: {why}" if why else "members of ensembles"
            lines.append(f"{count} runs are {how}")
        return lines

    def _calls(self, missing: set[int], jobs: int) -> Iterator[Callable[[], Batch]]:
        """Calls that make the runs that are `missing`."""
        for group in self.groups:
            runs = np.array([run for run in group.runs.tolist() if run in missing], dtype=int)
            if single_because(group, self._names):
                yield from (partial(self._single, group, run) for run in runs.tolist())
            else:
                yield from chunks(runs, Pace(jobs, len(runs)), partial(self._chunk, group))

    def _chunk(self, group: RunGroup, runs: np.ndarray, compiled: bool) -> Batch:
        """Records of some runs by one call of the library."""
        began, version = clock.perf_counter(), group.version
        program, names = version.program, self._names
        times = output_times(group.settings.stop_time, group.settings.output_interval)
        starts = self.runs.start_values(version, runs)
        parameters, inputs, states = np.split(starts, version.cuts, axis=1)
        tolerance = group.settings.tolerance
        control = Control(
            group.settings.method, rtol=tolerance, atol=tolerance,
            max_step=group.settings.step_size or np.inf,
        )  # fmt: skip
        outputs = [v.name for v in program.outputs if v.name in names]
        found = ensemble(
            program, times, parameters=parameters, inputs=inputs, states=states, outputs=outputs,
            control=control, compiled=compiled,
        )  # fmt: skip
        each = (clock.perf_counter() - began) / len(runs)
        places = {v.name: k for k, v in enumerate(program.states)}
        batch: dict[int, Record] = {}
        good: dict[float, list[int]] = {}  # places of runs by their start-up [s]
        for k, (number, run) in enumerate(zip(runs.tolist(), found, strict=True)):
            if run.message:
                at = version.named(starts[k])
                why = diagnosis(version.model, at, run.stopped_at) if version.model else ""
                told = f"{run.message}: {why}" if why else run.message
                batch[number] = Record(failure=told, wall_time=each)
            else:
                good.setdefault(self.start_up[number], []).append(k)
        for members in good.values():
            values = {
                name: np.array([_column(found[k], outputs, places, name) for k in members])
                for name in names
            }
            batch |= self._records(runs[members], times, values, each)
        return batch

    def _single(self, group: RunGroup, run: int) -> Batch:
        """The record of one run by a simulation of its own."""
        began, version, runs = clock.perf_counter(), group.version, np.array([run])
        start = version.named(self.runs.start_values(version, runs)[0])
        try:
            found = simulate(version.program.with_start(start), **vars(group.settings))
        except RunError as error:
            taken = clock.perf_counter() - began
            return {run: Record(failure=one_line(error.message), wall_time=taken)}
        values = {name: found[name].values[None] for name in self._names}
        taken = clock.perf_counter() - began
        return self._records(runs, found.time.values, values, taken)

    def _records(
        self, runs: np.ndarray, times: np.ndarray, values: Mapping[str, np.ndarray], taken: float
    ) -> Batch:
        """Records of `runs` (m,) [1] with one start-up from `values` (m, n) at `times` (n,) [s]."""
        study, first = self.study, self.start_up[int(runs[0])]
        found = records_of(study.wanted, study.series, times, values, first)
        made = (replace(one, wall_time=taken) for one in found)
        return dict(zip(runs.tolist(), made, strict=True))


def _column(run: Run, outputs: Sequence[str], places: Mapping[str, int], name: str) -> np.ndarray:
    """A state or output of a run (n_times,)."""
    if name in places:
        return np.ascontiguousarray(run.states[:, places[name]])
    return np.ascontiguousarray(run.outputs[:, outputs.index(name)])


def single_because(group: RunGroup, wanted: Sequence[str]) -> str:
    """Why the runs of a group are made one by one; empty if an ensemble does."""
    program: Program = group.version.program
    if group.settings.method not in ENSEMBLE_METHODS:
        return f"the method {group.settings.method} is none of {', '.join(ENSEMBLE_METHODS)}"
    if program.loops:
        return "its equations have algebraic loops, which are watched"
    if list(kinks(program, group.settings.stop_time)):
        return "rates have kinks in time, where steps end"
    if any(name.endswith(".work") for name in wanted):
        return "work is wanted, which is integrated beside the states"
    return ""
