"""The plan of a study, its time and disk, told before it runs: `--dry-run`."""

from __future__ import annotations

import time as clock
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path

import numpy as np

from m4e_fmi.cosim.load import load_system
from m4e_fmi.cosim.preparation.components import missing_fmus
from m4e_fmi.files.temporary import TemporaryFolder
from m4e_fmi.simulate.simulation import output_times
from m4e_fmi.study.given.grid import Grid
from m4e_fmi.study.given.study import STOP_TIME, Study
from m4e_fmi.study.programs.names import named_program
from m4e_fmi.study.programs.plan import ProgramPlan
from m4e_fmi.study.run import STORE
from m4e_fmi.study.runs.store import Pace, Store
from m4e_fmi.study.shown.warnings import told_once, warning_lines
from m4e_fmi.study.systems.checks import checked
from m4e_fmi.study.systems.execution import cores
from m4e_fmi.study.systems.names import Named, changed
from m4e_fmi.study.systems.plan import Plan, Versions, system_id, versions
from m4e_fmi.study.systems.targets import Targets
from m4e_fmi.study.systems.task import Lacking, Task, perform

MOST_TOLD = 12
"""FMUs that are named."""
SHORT = 0.01
"""Part of a run that is made for its timing."""
ENOUGH = 1.0
"""Seconds by which a longer run takes longer than it, which tell how long a whole one takes."""
PER_RUN = 600
"""Bytes of a kept run without series."""
LEAST_TOLD = 0.5
"""Seconds of planning that are told."""
FEWEST = 16
"""Members of an ensemble that is made for its timing."""


def estimate(
    study: Study, *, build_directory: str | Path = "build", jobs: int | None = None
) -> str:
    """Runs of a study, what its names stand for, FMUs to be built, time and disk, as text.

    InputError as the study itself. Short runs are made if all FMUs are there and no run is kept.
    """
    folder, jobs = Path(build_directory), jobs or cores()
    lines = (
        _of_program(study, folder, jobs) if study.is_program else _of_system(study, folder, jobs)
    )
    left_out = [f"  {one.text}" for one in study.grid.not_run]
    return "\n".join([f"{study.name}: {study.grid.count} runs", *left_out, *lines])


def _axes(study: Study, targets: Targets) -> Iterator[str]:
    """A line for each dimension, and what its names stand for."""
    for axis in study.grid.axes:
        shown = axis.labels
        span = ", ".join(shown) if len(shown) <= 8 else f"{shown[0]} to {shown[-1]}"
        points = f"{len(axis)} points" if len(axis.varied) > 1 else f"{len(axis)}: {span}"
        yield f"  {axis.name} ({points})"
        for varied in axis.varied:
            for name in varied.targets:
                yield f"    {name}: {targets[name]}"


def _of_system(study: Study, folder: Path, jobs: int) -> list[str]:
    quick = checked(study, load_system(study.source), quick=True)
    known = quick.named
    lines = list(_axes(study, known.targets))
    with TemporaryFolder() as blobs:
        plan = Plan(quick, folder, blobs, _silent)
        missing = plan.missing()
        count = sum(len(one.builds) for one in quick.of.values())
        for name, one in quick.of.items():
            if len(one.builds) < len(one.of):
                lines.append(
                    f"  {name}: {len(one.of)} versions share {len(one.builds)} FMUs: what else is "
                    "varied are start values"
                )
        there = count + len(known.system.components) - len(quick.of) - len(missing)
        lines.append(f"FMUs: {len(missing)} to be built, {there} are there")
        lines += [f"  {text}" for text in missing[:MOST_TOLD]]
        lines += [f"  … {len(missing) - MOST_TOLD} more"] if len(missing) > MOST_TOLD else []
        if missing:
            lines += _known_warnings(quick)
            lines += _time_before_builds(known, folder, blobs, jobs)
        else:
            began = clock.perf_counter()
            whole = Plan(versions(known), folder, blobs, _silent)
            whole.build()
            tasks = list(whole.tasks().values())
            lines += [f"  {line}" for line in warning_lines(whole.warnings)]
            planning = clock.perf_counter() - began
            lines += _system_time(known, tasks, folder, jobs, planning)
    settings = known.system.simulation
    interval = settings.output_interval or settings.step_size
    return [*lines, _disk(study, round(_duration(known) / interval) + 1)]


def _duration(known: Named) -> float:
    """Mean simulated time of the runs [s]."""
    times, grid = known.system.simulation, known.study.grid
    if STOP_TIME not in known.targets:
        return times.stop_time - times.start_time
    counts = Counter(known.settings(grid.values(run))["stop_time"] for run in grid.runs)
    stops = [changed(known.system, {"stop_time": one}).simulation.stop_time for one in counts]
    return float(np.average(stops, weights=[*counts.values()])) - times.start_time


def _known_warnings(quick: Versions) -> list[str]:
    """Warnings of sections that are known before FMUs are built, one of each kind."""
    found = list[str]()
    tell = told_once(found.append)
    for name, one in quick.of.items():
        for variant in one.of.values():
            for line in variant.warnings:
                tell(f"  {name}: {line}")
    return found


def _time_before_builds(known: Named, folder: Path, blobs: Path, jobs: int) -> list[str]:
    """The time of runs whose FMUs are to be built, by other runs of the system."""
    study = known.study
    beside = "beside planning and the FMUs to be built"
    if pace := _pace(known, folder):
        return _told(pace.seconds, study.grid.count, jobs, f"{_by_others(pace)}; {beside}")
    if missing_fmus(known.system, folder):
        return [
            "time: not known: there are neither FMUs nor kept runs of this system",
            f"  'm4e-fmi build {study.source}' with the same --build-folder builds those of its "
            "file; a dry run then makes short runs with them",
        ]
    own = replace(study, grid=Grid(()), start_up=0.0)  # the ramp may be longer than its runs
    stop = known.system.simulation.start_time + _duration(known)
    system = changed(known.system, {"stop_time": stop})
    plan = Plan(Versions(Named(own, system, {}, known.descriptions), {}), folder, blobs, _silent)
    plan.build()
    each, how = _trial(known, plan.task(0))
    if each is None:
        return [how]
    how = f"{how}, of the system as its file has it; {beside}"
    return _told(each, study.grid.count, jobs, how)


def _pace(known: Named, folder: Path) -> Pace | None:
    """How long kept runs of the system took, in whichever study."""
    with Store(folder / STORE) as store:
        return store.pace(system_id(known), _duration(known))


def _by_others(pace: Pace) -> str:
    return f"by {pace.count} runs of this system in other studies, of {pace.span:g} s"


def _system_time(
    known: Named, tasks: Sequence[Task], folder: Path, jobs: int, planning: float
) -> list[str]:
    with Store(folder / STORE) as store:
        kept = store.found([task.key for task in tasks])
    rest = len({task.key for task in tasks} - kept.keys())
    if kept:
        each = float(np.mean([record.wall_time for record in kept.values()]))
        how = f"by {len(kept)} kept runs"
    elif pace := _pace(known, folder):
        each, how = pace.seconds, _by_others(pace)
    else:
        stop = known.system.simulation.start_time + _duration(known)
        each, how = _trial(known, replace(tasks[0], stop_time=stop))
    return [how] if each is None else _told(each, rest, jobs, how, planning=planning)


def _trial(known: Named, first: Task) -> tuple[float | None, str]:
    """Seconds of a run, by short ones, and how they are known; None and a line if one fails.

    Each is twice as long as the one before it, until the difference from the first is of weight.
    """
    times = known.system.simulation
    whole, seconds = first.stop_time - times.start_time, list[float]()
    span = shortest = min(whole, max(SHORT * whole, 40 * times.step_size))
    for again in chain((True,), repeat(False)):  # the first loads what all runs share
        began = clock.perf_counter()
        stop = times.start_time + span
        found = perform(replace(first, stop_time=stop, start_up=times.start_time))
        assert not isinstance(found, Lacking)
        if found.failure:
            return None, f"time: not known, a short run failed: {found.failure}"
        seconds = [] if again else [*seconds, clock.perf_counter() - began]
        if seconds and (span == whole or seconds[-1] - seconds[0] >= ENOUGH):
            break
        if not again:
            span = min(whole, 2.0 * span)
    if span == whole:
        return seconds[-1], f"by a run of {span:g} s"
    each = seconds[-1] + (seconds[-1] - seconds[0]) / (span - shortest) * (whole - span)
    return each, f"by short runs, of {shortest:.3g} to {span:.3g} s"


def _of_program(study: Study, folder: Path, jobs: int) -> list[str]:
    lines, began = [], clock.perf_counter()
    plan = ProgramPlan(named_program(study, tell=_silent))
    lines += _axes(study, plan.named.targets)
    lines += plan.notes()
    with Store(folder / STORE) as store:
        kept = store.found([plan.keys[run] for run in study.grid.runs])
    missing = [run for run in study.grid.runs if plan.keys[run] not in kept]
    some: Sequence[int] = missing or study.grid.runs[:1]
    some = some[: 1 if plan.is_single(some[0]) else FEWEST]
    planning = clock.perf_counter() - began
    list(plan.records(some, 1))  # the first call prepares the program
    began = clock.perf_counter()
    list(plan.records(some, 1))
    each = (clock.perf_counter() - began) / len(some)
    how = f"by {len(some)} of the runs"
    lines += _told(each, len(missing), jobs, how, planning=planning)
    group = plan.groups[0].settings
    rows = len(output_times(group.stop_time, group.output_interval))
    return [*lines, _disk(study, rows)]


def _told(each: float, rest: int, jobs: int, how: str, *, planning: float = 0.0) -> list[str]:
    """The time of the `rest` of the runs of `each` [s], after a `planning` [s]."""
    if not rest:
        return ["time: none, all runs are kept"]
    workers = min(jobs, rest)
    total = planning + each * -(-rest // workers)
    before = f", after {_span(planning)} of planning" if planning >= LEAST_TOLD else ""
    return [
        f"time: about {_span(total)} for {rest} runs of {each:.2g} s, {workers} at a time{before}, "
        f"{how}"
    ]


def _span(seconds: float) -> str:
    if seconds < 600:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.3g} min" if seconds <= 36000 else f"{seconds / 3600:.3g} h"


def _disk(study: Study, rows: int) -> str:
    """The size of what is written."""
    series = study.grid.count * rows * 8.0 * (len(study.series) + bool(study.series))
    numbers = study.grid.count * (PER_RUN + 8.0 * (len(study.wanted) + 4))
    total = numbers + 2.0 * series
    return f"disk: about {total / 1e6:.2g} MB for kept runs and the result, beside FMUs"


def _silent(_: str) -> None:
    pass
