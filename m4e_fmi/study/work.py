"""The work of a study, of a system or of a program, as `run` needs it."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.report.run_report.record import InputFile
from m4e_fmi.study.dataset import Labels
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.programs.names import named_program
from m4e_fmi.study.programs.plan import ProgramPlan
from m4e_fmi.study.report.record import inputs_of
from m4e_fmi.study.runs.record import Record
from m4e_fmi.study.shown.warnings import WARNING
from m4e_fmi.study.systems.checks import checked
from m4e_fmi.study.systems.execution import Perform, performing
from m4e_fmi.study.systems.names import Named, changed
from m4e_fmi.study.systems.plan import Plan, Versions
from m4e_fmi.study.systems.targets import KeyTarget, StartTarget

Batch = Mapping[int, Record]
Make = Callable[[Sequence[int]], Generator[Batch]]
NO_TIME = ("algorithm", "tolerance", "coupling_tolerance", "method")
"""Settings that are no times."""


@dataclass(frozen=True)
class Work:
    """The runs of a `study`: the `keys` of what each follows from, and how they are made.

    Both have an entry for each point of the grid, "" and nan for those that are not run. `start_up`
    (n_points,) [s] is the time from which on rows count. `inputs` are files as they are before the
    first run. `records` makes the runs of some numbers.
    `rows` tells which rows statistics are of.
    """

    study: Study
    keys: Sequence[str] = field(repr=False)
    start_up: Sequence[float] = field(repr=False)
    labels: Labels = field(repr=False)
    inputs: Sequence[InputFile] = field(repr=False)
    warnings: Mapping[str, int]
    notes: Sequence[str]
    records: Make = field(repr=False)
    rows: str


@contextmanager
def work_of(
    study: Study,
    folder: Path,
    blobs: Path,
    *,
    jobs: int,
    executor: Executor | None,
    tell: Callable[[str], None],
) -> Generator[Work]:
    """The runs of a study; FMUs are built in `folder`, and what runs share is in `blobs`.

    Runs of a system are made by `jobs` processes, or by an `executor`; those of a program by as
    many threads.
    """
    jobs = min(jobs, study.grid.count)
    if study.is_program:
        yield _of_program(study, jobs, tell)
        return
    with performing(jobs, executor) as perform:
        made = checked(study, load_system(study.source))
        yield _of_system(Plan(made, folder, blobs, tell), perform)


def _of_system(plan: Plan, perform: Perform) -> Work:
    known = plan.versions.named
    inputs = inputs_of(known.study)
    plan.build()
    tasks, points = plan.tasks(), range(known.study.grid.size)
    settings = (known.settings(known.study.grid.values(run)) for run in known.study.grid.runs)
    systems = (changed(known.system, one) for one in settings)

    def records(missing: Sequence[int]) -> Generator[Batch]:
        for run, record in perform((run, tasks[run]) for run in missing):
            yield {run: record}

    return Work(
        study=known.study,
        keys=[tasks[run].key if run in tasks else "" for run in points],
        start_up=[tasks[run].start_up if run in tasks else math.nan for run in points],
        labels=_labels(plan.versions),
        inputs=inputs,
        warnings=plan.warnings,
        notes=(),
        records=records,
        rows=_rows([one.simulation.output_interval for one in systems]),
    )


def _of_program(study: Study, jobs: int, tell: Callable[[str], None]) -> Work:
    warnings: dict[str, int] = {}

    def tell_and_note(line: str) -> None:
        if WARNING in line:
            warnings[line.replace(WARNING, "", 1)] = study.grid.count
        tell(line)

    plan = ProgramPlan(named_program(study, tell=tell_and_note))

    def records(missing: Sequence[int]) -> Generator[Batch]:
        return plan.records(missing, jobs)

    named, labels = plan.named, plan.named.labels()
    inputs = inputs_of(named.study)
    warnings |= plan.warnings()
    rows = _rows([group.settings.output_interval for group in plan.groups])
    return Work(
        named.study, plan.keys, plan.start_up, labels, inputs, warnings, plan.notes(), records, rows
    )


def _rows(intervals: Sequence[float | None]) -> str:
    """Where the rows of runs are, which have these intervals [s] between them (None: none)."""
    known = [one for one in intervals if one is not None]
    if not known:
        return "at all communication points"
    low, high = min(known), max(known)
    return f"every {low:g} s" if low == high else f"every {low:g} to {high:g} s"


def _labels(made: Versions) -> Labels:
    """Units and descriptions of what is varied and of wanted variables."""
    known = made.named
    varied: dict[str, tuple[str, str]] = {}
    for name, target in known.targets.items():
        if isinstance(target, StartTarget):
            varied[name] = target.unit, target.text
        elif isinstance(target, KeyTarget):
            one = made.of[target.component]
            varied[name] = one.labels.get(one.keys.index(target.keys), ("", ""))
        elif target.key not in NO_TIME:
            varied[name] = "s", f"{target.key} of the simulation"
    return Labels(varied, _variables(known))


def _variables(known: Named) -> dict[str, tuple[str, str]]:
    study, found = known.study, dict[str, tuple[str, str]]()
    for name in (*(w.variable for w in study.wanted), *study.series):
        component, _, variable = name.partition(".")
        one = known.descriptions[component].variables[variable]
        found[name] = one.unit, one.description
    return found
