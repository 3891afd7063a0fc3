"""The plan of a study of one program: a model, or a system whose equations are connected.

Runs that differ in start values are members of an ensemble, many in one call of the C library. What
an ensemble cannot do is made by single simulations: see `single_because`.
"""

from __future__ import annotations

import hashlib
import json
import time as clock
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import groupby

import numpy as np

from m4e_fmi.code_hash import code_hash
from m4e_fmi.errors import RunError
from m4e_fmi.multibody.diagnosis import diagnosis
from m4e_fmi.program import Program, kinks
from m4e_fmi.runtime.engine import Control, Run, ensemble
from m4e_fmi.runtime.library import library
from m4e_fmi.shown import one_line
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.simulation import output_times
from m4e_fmi.study.programs.chunks import Pace, chunks, in_threads
from m4e_fmi.study.programs.names import NamedProgram, Version
from m4e_fmi.study.programs.settings import Settings
from m4e_fmi.study.runs.record import Record
from m4e_fmi.study.runs.start_up import RAMP, check_start_up, ramp_of, start_up, within_ramp
from m4e_fmi.study.runs.statistics_of import computed

COMPILING_PAYS = 1.0
"""Seconds of processor time that the interpreter would take for what is left of a group, from which
on its program is compiled: both give the same bits."""
ENSEMBLE_METHODS = ("dop853", "rk45", "rk4")
Batch = dict[int, Record]


@dataclass(frozen=True)
class RunGroup:
    """Runs of one program with the same settings: `runs` are their numbers, from 0."""

    version: Version
    settings: Settings
    runs: np.ndarray = field(repr=False)


class _Compiling:
    """How fast the interpreter makes `left` runs of a group, by the first of them."""

    def __init__(self, left: int) -> None:
        self._left, self._each, self._pays = left, 0.0, False

    def note(self, count: int, seconds: float) -> None:
        """Note the processor time of `count` runs."""
        self._left -= count
        self._each = self._each or seconds / count

    @property
    def pays(self) -> bool:
        """True if compiling the program takes less time than it saves, and once it is compiled."""
        self._pays = self._pays or self._left * self._each > COMPILING_PAYS
        return self._pays


@dataclass
class ProgramPlan:
    """The runs of a study of a program."""

    named: NamedProgram

    @cached_property
    def groups(self) -> list[RunGroup]:
        """Runs of one program and one set of settings each, in order."""
        named = self.named
        settings = named.settings
        runs: dict[tuple[int, str], list[int]] = {}
        for run in named.study.grid.runs:
            version = named.version_of[run]
            own = {key: column[run] for key, column in settings.items()}
            runs.setdefault((version, json.dumps(own)), []).append(run)
        return [
            RunGroup(
                named.versions[version],
                Settings(**{**named.fixed, **json.loads(own)}),  # pyrefly: ignore[bad-argument-type]
                np.array(members),
            )
            for (version, own), members in runs.items()
        ]

    @cached_property
    def start_up(self) -> list[float]:
        """The time [s] from which on rows count, of each point; nan of what is not run."""
        found = np.full(self.named.study.grid.size, np.nan)
        for group in self.groups:
            found[group.runs] = self._start_up_of(group)
            check_start_up(
                self.named.study, float(found[group.runs].max()), group.settings.stop_time
            )
        return found.tolist()

    def _start_up_of(self, group: RunGroup) -> np.ndarray:
        """The same of the runs of a group (n_runs,) [s]."""
        stated = self.named.study.start_up
        return np.array([start_up(stated, 0.0, ramps) for ramps in self._ramps(group)])

    def _ramps(self, group: RunGroup) -> Iterator[dict[str, float]]:
        """The ramps [s] of seas by name, of each run of a group."""
        values = self.named.start_values(group.version, group.runs)
        names = [v.name for v in group.version.variables]
        ramps = [k for k, name in enumerate(names) if name.rpartition(".")[2] == RAMP]
        return ({names[k]: float(row[k]) for k in ramps} for row in values)

    def warnings(self) -> dict[str, int]:
        """Doubts before any run is made, with the number of runs that each is of."""
        stated = self.named.study.start_up
        every = [ramp_of(ramps.items()) for group in self.groups for ramps in self._ramps(group)]
        early = [ramp for ramp in every if stated is not None and stated < ramp]
        return {within_ramp(stated or 0.0, max(early)): len(early)} if early else {}

    @cached_property
    def keys(self) -> list[str]:
        """The hash of all that each run follows from, of each point; "" of what is not run."""
        study, found = self.named.study, [""] * self.named.study.grid.size
        for group in self.groups:
            wanted = repr((study.wanted, study.series))
            same = [code_hash(), group.version.code, repr(group.settings), wanted]
            same.append(repr([v.name for v in group.version.variables]))
            same.append(f"{bool(single_because(group, self._names))}")
            base = hashlib.sha256("\0".join(same).encode())
            rows = np.ascontiguousarray(self.named.start_values(group.version, group.runs))
            for run, row in zip(group.runs.tolist(), rows, strict=True):
                own = base.copy()
                own.update(row.tobytes())
                own.update(repr(self.start_up[run]).encode())
                found[run] = own.hexdigest()
        return found

    def notes(self) -> list[str]:
        """How the runs are made, a line each."""
        lines = []
        for why, groups in groupby(self.groups, lambda g: single_because(g, self._names)):
            count = sum(len(group.runs) for group in groups)
            how = f"single simulations: {why}" if why else "members of ensembles"
            lines.append(f"{count} runs are {how}")
        return lines

    def records(self, missing: Sequence[int], jobs: int) -> Generator[Batch]:
        """Records of the runs that are `missing`, by number, as they come."""
        yield from in_threads(self._calls(set(missing), jobs), jobs)

    def _calls(self, missing: set[int], jobs: int) -> Iterator[Callable[[], Batch]]:
        """Calls that make the runs that are `missing`."""
        for group in self.groups:
            runs = np.array([run for run in group.runs.tolist() if run in missing], dtype=int)
            if single_because(group, self._names):
                yield from (partial(self._single, group, runs[k : k + 1]) for k in range(len(runs)))
            else:
                make = partial(self._chunk, group, compiling=_Compiling(len(runs)))
                yield from chunks(runs, Pace(jobs), make)

    def _chunk(self, group: RunGroup, runs: np.ndarray, compiling: _Compiling) -> Batch:
        """Records of some runs by one call of the library."""
        began, version, used = clock.perf_counter(), group.version, clock.thread_time()
        program, names = version.program, self._names
        times = output_times(group.settings.stop_time, group.settings.output_interval)
        starts = self.named.start_values(version, runs)
        parameters, inputs, states = np.split(starts, version.cuts, axis=1)
        tolerance = group.settings.tolerance
        control = Control(
            group.settings.method, rtol=tolerance, atol=tolerance,
            max_step=group.settings.step_size or np.inf,
        )  # fmt: skip
        outputs = [v.name for v in program.outputs if v.name in names]
        found = ensemble(
            program, times, parameters=parameters, inputs=inputs, states=states, outputs=outputs,
            control=control, compiled=compiling.pays,
        )  # fmt: skip
        compiling.note(len(runs), clock.thread_time() - used)
        each = (clock.perf_counter() - began) / len(runs)
        good = [k for k, run in enumerate(found) if not run.message]
        places = {v.name: k for k, v in enumerate(program.states)}
        values = {
            name: np.array([_column(found[k], outputs, places, name) for k in good])
            for name in names
        }
        batch: Batch = {}
        for first, members in _same_start_up(self.start_up, runs, good):
            rows = {name: column[members] for name, column in values.items()}
            batch |= self._records_of(runs[[good[k] for k in members]], times, rows, first, each)
        for k, run in enumerate(found):
            if run.message:
                at = version.named(starts[k])
                why = diagnosis(version.model, at, run.stopped_at) if version.model else ""
                told = f"{run.message}: {why}" if why else run.message
                batch[int(runs[k])] = Record(failure=told, wall_time=each)
        return batch

    def _single(self, group: RunGroup, runs: np.ndarray) -> Batch:
        """The record of one run by a simulation of its own."""
        began, run = clock.perf_counter(), int(runs[0])
        version, settings = group.version, group.settings
        row = self.named.start_values(version, runs)[0]
        start = {v.name: float(x) for v, x in zip(version.variables, row, strict=True)}
        try:
            found = simulate(
                version.program.with_start(start),
                stop_time=settings.stop_time,
                output_interval=settings.output_interval,
                tolerance=settings.tolerance,
                method=settings.method,
                step_size=settings.step_size,
            )
        except RunError as error:
            taken = clock.perf_counter() - began
            return {run: Record(failure=one_line(error.message), wall_time=taken)}
        values = {name: found[name].values[None] for name in self._names}
        first, taken = self.start_up[run], clock.perf_counter() - began
        return self._records_of(runs, found.time.values, values, first, taken)

    def _records_of(
        self,
        runs: np.ndarray,
        times: np.ndarray,
        values: Mapping[str, np.ndarray],
        first: float,
        each: float,
    ) -> Batch:
        """Records of runs from their `values` (n_runs, n_times) by name, at `times` [s]."""
        study = self.named.study
        numbers, reasons = computed(study.wanted, times, values, first)
        return {
            int(run): Record(
                values={name: float(number[k]) for name, number in numbers.items()},
                time=times if study.series else np.empty(0),
                series={name: values[name][k] for name in study.series},
                wall_time=each,
                undefined={name: why[k] for name, why in reasons.items() if why[k]},
            )
            for k, run in enumerate(runs)
        }

    @property
    def _names(self) -> list[str]:
        study = self.named.study
        return list(dict.fromkeys((*(w.variable for w in study.wanted), *study.series)))


def _column(run: Run, outputs: Sequence[str], places: Mapping[str, int], name: str) -> np.ndarray:
    """A state or output of a run (n_times,)."""
    if name in places:
        return run.states[:, places[name]]
    return run.outputs[:, outputs.index(name)]


def _same_start_up(
    start_up: Sequence[float], runs: np.ndarray, good: Sequence[int]
) -> Iterator[tuple[float, list[int]]]:
    """Start-ups [s], and the members of `good` that have each."""
    found: dict[float, list[int]] = {}
    for k, place in enumerate(good):
        found.setdefault(start_up[int(runs[place])], []).append(k)
    yield from found.items()


def single_because(group: RunGroup, wanted: Sequence[str]) -> str:
    """Why the runs of a group are made one by one; empty if an ensemble does."""
    program: Program = group.version.program
    if library() is None:
        return "the C library is missing"
    if group.settings.method not in ENSEMBLE_METHODS:
        return f"the method {group.settings.method} is none of {', '.join(ENSEMBLE_METHODS)}"
    if program.loops:
        return "its equations have algebraic loops, which are watched"
    if list(kinks(program, group.settings.stop_time)):
        return "rates have kinks in time, where steps end"
    if any(name.endswith(".work") for name in wanted):
        return "work is wanted, which is integrated beside the states"
    return ""
