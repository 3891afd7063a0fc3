"""The plan of a study, its time and disk, told before it runs: `--dry-run`."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_fmi.cosim.load import load_system
from m4e_fmi.files.temporary import TemporaryFolder
from m4e_fmi.simulate.simulation import output_times
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.programs.names import named_program
from m4e_fmi.study.programs.plan import ProgramPlan
from m4e_fmi.study.run import STORE
from m4e_fmi.study.runs.store import Store
from m4e_fmi.study.systems.execution import cores
from m4e_fmi.study.systems.names import named
from m4e_fmi.study.systems.plan import Plan, versions
from m4e_fmi.study.systems.targets import Targets
from m4e_fmi.study.systems.task import Lacking, perform

MOST_TOLD = 12
"""FMUs that are named."""
SHORT = 0.02
"""Part of a run that is made for its timing."""
PER_RUN = 600
"""Bytes of a kept run without series."""
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
    return "\n".join([f"{study.name}: {study.grid.count} runs", *lines])


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
    known = named(study, load_system(study.source))
    quick = versions(known, quick=True)
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
            lines.append("time: not known before the FMUs are built")
        else:
            whole = Plan(versions(known), folder, blobs, _silent)
            whole.build()
            lines += _system_time(whole, folder, jobs)
    settings = known.system.simulation
    interval = settings.output_interval or settings.step_size
    rows = round((settings.stop_time - settings.start_time) / interval) + 1
    return [*lines, _disk(study, rows)]


def _system_time(plan: Plan, folder: Path, jobs: int) -> list[str]:
    tasks = list(plan.tasks())
    with Store(folder / STORE) as store:
        kept = store.found([task.key for task in tasks])
    rest = len({task.key for task in tasks} - kept.keys())
    if kept:
        each = float(np.mean([record.wall_time for record in kept.values()]))
        return _told(each, rest, jobs, f"by {len(kept)} kept runs")
    first, stop = tasks[0], tasks[0].stop_time
    start = plan.versions.named.system.simulation.start_time
    step = plan.versions.named.system.simulation.step_size
    end = start + max(SHORT * (stop - start), 40 * step)
    if end >= stop:
        end = stop
    times = []
    for part in (0.5, 0.5, 1.0):  # the first loads what all runs share
        began = clock.perf_counter()
        until = start + part * (end - start)
        found = perform(replace(first, stop_time=until, start_up=start))
        times.append(clock.perf_counter() - began)
        assert not isinstance(found, Lacking)
        if found.failure:
            return [f"time: not known, a short run failed: {found.failure}"]
    rate = max(0.0, times[2] - times[1]) / (0.5 * (end - start))
    each = times[2] + rate * (stop - end)
    return _told(each, rest, jobs, f"by short runs, of {0.5 * (end - start):g} s and twice that")


def _of_program(study: Study, folder: Path, jobs: int) -> list[str]:
    lines = []
    plan = ProgramPlan(named_program(study, tell=_silent))
    lines += _axes(study, plan.named.targets)
    lines += plan.notes()
    with Store(folder / STORE) as store:
        kept = store.found(plan.keys)
    missing = [run for run, key in enumerate(plan.keys) if key not in kept]
    some: Sequence[int] = missing[:FEWEST] or [0]
    began = clock.perf_counter()
    list(plan.records(some, 1))
    each = (clock.perf_counter() - began) / len(some)
    lines += _told(each, len(missing), jobs, f"by {len(some)} of the runs")
    group = plan.groups[0].settings
    rows = len(output_times(group.stop_time, group.output_interval))
    return [*lines, _disk(study, rows)]


def _told(each: float, rest: int, jobs: int, how: str) -> list[str]:
    if not rest:
        return ["time: none, all runs are kept"]
    total = each * rest / min(jobs, max(1, rest))
    span = f"{total:.3g} s" if total < 600 else f"{total / 60:.3g} min"
    if total > 36000:
        span = f"{total / 3600:.3g} h"
    workers = min(jobs, max(1, rest))
    return [
        f"time: about {span} for {rest} runs of {each:.2g} s, {workers} at a time, {how}; the "
        "others are kept"
    ]


def _disk(study: Study, rows: int) -> str:
    """The size of what is written."""
    series = study.grid.count * rows * 8.0 * (len(study.series) + bool(study.series))
    numbers = study.grid.count * (PER_RUN + 8.0 * (len(study.wanted) + 4))
    total = numbers + 2.0 * series
    return f"disk: about {total / 1e6:.2g} MB for kept runs and the result, beside FMUs"


def _silent(_: str) -> None:
    pass
