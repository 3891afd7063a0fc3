"""The plan of a study, told before it runs: `--dry-run`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.files.locks import TemporaryFolder
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.programs.names import named_program
from m4e_fmi.study.programs.plan import ProgramPlan
from m4e_fmi.study.run import STORE
from m4e_fmi.study.runs.store import Store
from m4e_fmi.study.shown.warnings import warning_lines
from m4e_fmi.study.systems.checks import checked
from m4e_fmi.study.systems.plan import Plan, versions
from m4e_fmi.study.systems.targets import Targets

MOST_TOLD = 12
"""FMUs that are named."""


def estimate(study: Study, *, build_directory: str | Path = "build") -> str:
    """Runs of a study, what its names stand for, FMUs to be built, runs that are kept, as text.

    InputError as the study itself.
    """
    folder = Path(build_directory)
    lines = _of_program(study, folder) if study.is_program else _of_system(study, folder)
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


def _of_system(study: Study, folder: Path) -> list[str]:
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
            return [*lines, "runs: how many are kept is known when the FMUs are there"]
        whole = Plan(versions(known), folder, blobs, _silent)
        whole.build()
        keys = [task.key for task in whole.tasks().values()]
        lines += [f"  {line}" for line in warning_lines(whole.warnings)]
    return [*lines, _runs_line(folder, keys)]


def _of_program(study: Study, folder: Path) -> list[str]:
    plan = ProgramPlan(named_program(study, tell=_silent))
    keys = [plan.keys[run] for run in study.grid.runs]
    return [*_axes(study, plan.named.targets), *plan.notes(), _runs_line(folder, keys)]


def _runs_line(folder: Path, keys: Sequence[str]) -> str:
    """How many of the runs of these keys are kept, and how long one took."""
    with Store(folder / STORE) as store:
        kept = store.found(keys)
    count = sum(key in kept for key in keys)
    told = f"runs: {count} kept, {len(keys) - count} to be made"
    return f"{told}, the last took {[*kept.values()][-1].wall_time:.2g} s" if kept else told


def _silent(_: str) -> None:
    pass
