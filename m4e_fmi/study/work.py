"""The work of a study, of a system or of a program, as `run` needs it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.cosim.load import load_system
from m4e_fmi.study.dataset import Labels
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.programs.names import named_program
from m4e_fmi.study.programs.plan import ProgramPlan
from m4e_fmi.study.runs.record import Record
from m4e_fmi.study.systems.execution import performed
from m4e_fmi.study.systems.names import Named, named
from m4e_fmi.study.systems.plan import Plan, Versions, versions
from m4e_fmi.study.systems.targets import KeyTarget, StartTarget

Batch = Mapping[int, Record]
Make = Callable[[Sequence[int], int, Executor | None], Iterator[Batch]]
NO_TIME = ("algorithm", "tolerance", "coupling_tolerance", "method")
"""Settings that are no times."""


@dataclass(frozen=True)
class Work:
    """The runs of a `study`: the `keys` of what each follows from, and how they are made.

    `start_up` (n_runs,) [s] is the time from which on rows count. `records` makes the runs of some
    numbers by so many jobs, or an executor.
    """

    study: Study
    keys: Sequence[str] = field(repr=False)
    start_up: Sequence[float] = field(repr=False)
    labels: Labels = field(repr=False)
    warnings: Mapping[str, int]
    notes: Sequence[str]
    records: Make = field(repr=False)


def work_of(study: Study, folder: Path, blobs: Path, tell: Callable[[str], None]) -> Work:
    """The runs of a study; FMUs are built in `folder`, and what runs share is in `blobs`."""
    return _of_program(study, tell) if study.is_program else _of_system(study, folder, blobs, tell)


def _of_system(study: Study, folder: Path, blobs: Path, tell: Callable[[str], None]) -> Work:
    known = named(study, load_system(study.source))
    plan = Plan(versions(known), folder, blobs, tell)
    plan.build()
    tasks = list(plan.tasks())

    def records(missing: Sequence[int], jobs: int, executor: Executor | None) -> Iterator[Batch]:
        waiting = ((run, tasks[run]) for run in missing)
        for run, record in performed(waiting, jobs=jobs, executor=executor):
            yield {run: record}

    return Work(
        study=known.study,
        keys=[task.key for task in tasks],
        start_up=[task.start_up for task in tasks],
        labels=_labels(plan.versions),
        warnings=dict.fromkeys(plan.warnings, len(tasks)),
        notes=(),
        records=records,
    )


def _of_program(study: Study, tell: Callable[[str], None]) -> Work:
    plan = ProgramPlan(named_program(study, tell=tell))

    def records(missing: Sequence[int], jobs: int, _: Executor | None) -> Iterator[Batch]:
        return plan.records(missing, jobs)

    named, labels = plan.named, plan.named.labels()
    return Work(named.study, plan.keys, plan.start_up, labels, {}, plan.notes(), records)


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
