"""A study from its file to its result: planned, run, gathered."""

from __future__ import annotations

import math
import time as clock
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cosim.preparation.components import silent
from m4e_fmi.files.locks import TemporaryFolder, claimed
from m4e_fmi.files.writing import check_suffix
from m4e_fmi.signals import Terminated
from m4e_fmi.study.dataset import Work, dataset, write_dataset
from m4e_fmi.study.given.study import Study, load_study
from m4e_fmi.study.programs.plan import ProgramPlan
from m4e_fmi.study.record import Record, Store
from m4e_fmi.study.report.record import carried_record
from m4e_fmi.study.shown.warnings import WARNING, told_once
from m4e_fmi.study.start_up import DEFAULT
from m4e_fmi.study.systems.execution import cores, performing
from m4e_fmi.study.systems.plan import SystemPlan

if TYPE_CHECKING:
    import xarray

STORE = "kept_runs.sqlite"
"""File of kept runs in the build folder."""
ONE_SEED = (
    "each state is one sea of many: means over a few minutes are off by tens of percent by chance; "
    "more seeds, as {seeds: 5}, give confidence intervals"
)
SUFFIXES = (".nc", ".csv")

NO_RUN = Record(wall_time=math.nan)
"""The record of a point that is not run."""

Progress = Callable[[int, int], None]
"""Called with the number of runs that are done, and of all."""


@dataclass(frozen=True)
class StudyOutcome:
    """A study that has ended: its `data`, the file `path`, and how its runs went.

    `records` are those of all points; of what is not run they have no numbers. `failures` are those
    of runs by number, from 0, `warnings` lines with the number of runs that have them, `kept` the
    number of runs that were done before; `notes` say how runs were made. `wall_time` in s.
    """

    study: Study
    data: xarray.Dataset = field(repr=False)
    path: Path | None
    records: tuple[Record, ...] = field(repr=False)
    failures: Mapping[int, str]
    warnings: Mapping[str, int]
    notes: tuple[str, ...]
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

    Runs of a system are made by `jobs` processes (default: one for each processor), or by any
    `executor`, as Dask's; those of one program by the C library in threads. Each that is done is
    kept in `build_directory`, unless it failed. With `fresh`, all are made again. `output` is a
    file for the result, netCDF or `.csv`. `progress` is called after each run, `tell` with lines on
    what is built, and with each kind of warning when it first occurs.

    A run that fails leaves nan, and its reason. InputError with all problems of the study and its
    system; RunError if FMUs cannot be built or files not be written, or if another study writes to
    `output`. KeyboardInterrupt leaves what was done in the store.
    """
    began = clock.perf_counter()
    study = given if isinstance(given, Study) else load_study(given)
    if output is not None:
        check_suffix(output, SUFFIXES, "the result of a study")
    folder = Path(build_directory)
    with ExitStack() as stack:
        if output is not None:
            stack.enter_context(claimed(output))
        store = stack.enter_context(Store(folder / STORE))
        blobs = stack.enter_context(TemporaryFolder(folder))  # where workers see it
        tell = told_once(tell or silent)
        jobs = min(jobs or cores(), study.grid.count)
        if study.is_program:
            work = ProgramPlan(study, tell).work(jobs)
        else:
            perform = stack.enter_context(performing(jobs, executor))
            work = SystemPlan(study, folder, blobs, tell).work(perform)
        for line in work.warnings:
            tell(f"{WARNING}{line}")
        records, kept = _records(work, store, fresh=fresh, progress=progress, tell=tell)
        outcome = _outcome(work, records, kept, None if output is None else Path(output))
        if outcome.path is not None:
            write_dataset(outcome.data, outcome.path)
    return replace(outcome, wall_time=clock.perf_counter() - began)


def _outcome(work: Work, records: Sequence[Record], kept: int, path: Path | None) -> StudyOutcome:
    """The study with the record of each point, of which so many runs were kept."""
    study, warnings = work.study, dict(work.warnings)
    for one in records:
        for line in _lines(one):
            warnings[line] = warnings.get(line, 0) + 1
    if any(axis.repeats and len(axis) == 1 for axis in study.grid.axes):
        warnings[ONE_SEED] = len(records)
    notes = (*work.notes, *filter(None, (one.text for one in study.grid.shares)))
    record = carried_record(
        study, records, inputs=work.inputs, kept=kept, warnings=warnings, notes=notes
    )
    told = DEFAULT if study.start_up is None else f"{study.start_up:g} s, as stated"
    attributes = {"source": str(study.source), "start_up": told, "rows": work.rows, **record}
    return StudyOutcome(
        study=study,
        data=dataset(
            study, records, work.labels, start_up=work.start_up, attributes=attributes,
            wave_power=work.wave_power, water=work.water,
        ),
        path=path,
        records=tuple(records),
        failures={k: r.failure for k, r in enumerate(records) if r.failure},
        warnings=warnings,
        notes=notes,
        kept=kept,
        wall_time=math.nan,
    )  # fmt: skip


def _records(
    work: Work, store: Store, *, fresh: bool, progress: Progress | None, tell: Callable[[str], None]
) -> tuple[list[Record], int]:
    """The record of each point, and the number of runs that were kept."""
    keys, runs, count = work.keys, work.study.grid.runs, work.study.grid.count
    own = Counter(keys[run] for run in runs)  # runs may be the same in all
    by_key: dict[str, Record] = {} if fresh else store.found(list(own))
    kept = done = sum(own[key] for key in by_key)
    first = {keys[run]: run for run in reversed(runs) if keys[run] not in by_key}
    missing = sorted(first.values())
    took = f", the last took {[*by_key.values()][-1].wall_time:.2g} s" if by_key else ""
    tell(f"note: {kept} runs kept, {count - kept} to make{took}")
    if progress:
        progress(done, count)
    try:
        with closing(work.records(missing)) as batches:  # no further run begins after an error
            for batch in batches:
                found = {keys[run]: record for run, record in batch.items()}
                store.keep(found, again=fresh)
                by_key |= found
                for run, record in batch.items():
                    for line in _lines(record):
                        tell(f"{WARNING}{line} (in the run of {work.study.grid.label(run)})")
                done += sum(own[key] for key in found)
                if progress:
                    progress(done, count)
    except (KeyboardInterrupt, Terminated) as error:
        told = f"before the first of {count} runs was done"
        if done:
            rest = "the same command makes the others"
            told = f"after {done} of {count} runs, which are kept: {rest}"
        error.add_note(told)
        raise
    return [by_key.get(key, NO_RUN) for key in keys], kept


def _lines(record: Record) -> Iterator[str]:
    """The warnings of a run."""
    yield from record.warnings
    for name, why in record.undefined.items():
        yield f"{name} is not defined: {why}"
