"""A study from its file to its result: planned, run, gathered."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cosim.load import load_system
from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.locks import claimed
from m4e_fmi.files.temporary import TemporaryFolder
from m4e_fmi.files.writing import check_suffix
from m4e_fmi.study.dataset import Labels, dataset, write_dataset
from m4e_fmi.study.execution import cores, performed
from m4e_fmi.study.names import Named, named
from m4e_fmi.study.plan import Plan, Versions, versions
from m4e_fmi.study.record import Record
from m4e_fmi.study.start_up import DEFAULT
from m4e_fmi.study.store import Store
from m4e_fmi.study.study import Study, load_study
from m4e_fmi.study.targets import KeyTarget, StartTarget
from m4e_fmi.study.task import Task

if TYPE_CHECKING:
    import xarray

STORE = "kept_runs.sqlite"
"""File of kept runs in the build folder."""
SUFFIXES = (".nc", ".csv")

Progress = Callable[[int, int], None]
"""Called with the number of runs that are done, and of all."""


@dataclass(frozen=True)
class StudyOutcome:
    """A study that has ended: its `data`, the file `path`, and how its runs went.

    `failures` are those of runs by number, `warnings` lines with the number of runs that have them,
    `kept` the number of runs that were done before; `wall_time` in s.
    """

    study: Study
    data: xarray.Dataset = field(repr=False)
    path: Path | None
    records: tuple[Record, ...] = field(repr=False)
    failures: Mapping[int, str]
    warnings: Mapping[str, int]
    kept: int
    wall_time: float


def run_study(
    given: Study | str | Path,
    *,
    output: str | Path | None = None,
    build_directory: str | Path = "build",
    jobs: int | None = None,
    executor: Executor | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
    tell: Callable[[str], None] | None = None,
) -> StudyOutcome:
    """Make the runs of a study, or of that in a file, which are not kept from earlier ones.

    Runs are made by `jobs` processes (default: one for each processor), or by any `executor`, as
    Dask's; each that is done is kept in `build_directory`, unless it failed. With `fresh`, all are
    made again. `output` is a file for the result, netCDF or `.csv`. `progress` is called after each
    run, `tell` with lines on what is built.

    A run that fails leaves nan, and its reason. InputError with all problems of the study and its
    system; RunError if FMUs cannot be built or files not be written, or if another study writes to
    `output`. KeyboardInterrupt leaves what was done in the store.
    """
    began = clock.perf_counter()
    study = given if isinstance(given, Study) else load_study(given)
    if output is not None:
        check_suffix(output, SUFFIXES, "the result of a study")
    tell = tell or _silent
    folder = Path(build_directory)
    with ExitStack() as stack:
        if output is not None:
            stack.enter_context(claimed(output))
        blobs = stack.enter_context(TemporaryFolder())
        store = stack.enter_context(Store(folder / STORE))
        known = named(study, load_system(study.source))
        plan = Plan(versions(known), folder, blobs, tell)
        plan.build()
        tasks = list(plan.tasks())
        records, kept = _records(
            tasks, store, jobs=jobs or cores(), executor=executor, fresh=fresh, progress=progress
        )
        found = dataset(
            study,
            records,
            labels_of(plan.versions),
            start_up=[task.start_up for task in tasks],
            attributes=_attributes(study),
        )
        path = None
        if output is not None:
            path = Path(output)
            write_dataset(found, path)
    return StudyOutcome(
        study=study,
        data=found,
        path=path,
        records=tuple(records),
        failures={k: r.failure for k, r in enumerate(records) if r.failure},
        warnings=_warnings(plan.warnings, records),
        kept=kept,
        wall_time=clock.perf_counter() - began,
    )


def _records(
    tasks: Sequence[Task],
    store: Store,
    *,
    jobs: int,
    executor: Executor | None,
    fresh: bool,
    progress: Progress | None,
) -> tuple[list[Record], int]:
    """The record of each task, and the number of those that were kept."""
    by_key: dict[str, Record] = {} if fresh else store.found([task.key for task in tasks])
    kept, total = sum(task.key in by_key for task in tasks), len(tasks)
    missing = {task.key: task for task in tasks if task.key not in by_key}
    done = kept
    if progress:
        progress(done, total)
    waiting: Iterator[tuple[int, Task]] = enumerate(missing.values())
    keys = list(missing)
    for number, record in performed(waiting, jobs=min(jobs, len(missing) or 1), executor=executor):
        key = keys[number]
        store.keep({key: record})
        by_key[key] = record
        done += sum(task.key == key for task in tasks) if total != len(missing) + kept else 1
        if progress:
            progress(done, total)
    return [by_key[task.key] for task in tasks], kept


def _attributes(study: Study) -> dict[str, str]:
    stated = study.start_up
    told = f"{stated:g} s, as stated" if stated is not None else DEFAULT
    return {"source": str(study.source), "start_up": told}


def labels_of(made: Versions) -> Labels:
    """Units and descriptions of what is varied and of wanted variables."""
    known = made.named
    varied: dict[str, tuple[str, str]] = {}
    for name, target in known.targets.items():
        if isinstance(target, StartTarget):
            varied[name] = target.unit, target.text
        elif isinstance(target, KeyTarget):
            one = made.of[target.component]
            place = one.keys.index(target.keys)
            varied[name] = one.labels.get(place, ("", ""))
        elif target.key not in ("algorithm", "tolerance", "coupling_tolerance"):
            varied[name] = "s", f"{target.key} of the simulation"
    return Labels(varied, _variables(known))


def _variables(known: Named) -> dict[str, tuple[str, str]]:
    study, found = known.study, dict[str, tuple[str, str]]()
    for name in (*(w.variable for w in study.wanted), *study.series):
        component, _, variable = name.partition(".")
        one = known.descriptions[component].variables[variable]
        found[name] = one.unit, one.description
    return found


def _warnings(prepared: Mapping[str, int], records: Sequence[Record]) -> dict[str, int]:
    """Warnings of preparation and of runs, each with the number of runs that have it."""
    found = dict.fromkeys(prepared, len(records))
    for record in records:
        told = [*record.warnings, *(f"{name} is not defined: {why}" for name, why in record.undefined.items())]
        for line in told:
            found[line] = found.get(line, 0) + 1
    return found


def stem(study: Study) -> str:
    """Name of files of a study, without suffix."""
    return file_stem(study.name)


def _silent(_: str) -> None:
    pass
