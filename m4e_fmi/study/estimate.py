"""The plan of a study, told before it runs: `--dry-run`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from m4e_fmi.cosim.preparation.components import silent
from m4e_fmi.files.locks import TemporaryFolder
from m4e_fmi.study.dataset import Work
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.names import Named
from m4e_fmi.study.programs.plan import ProgramPlan
from m4e_fmi.study.record import Store
from m4e_fmi.study.run import STORE
from m4e_fmi.study.shown.warnings import warning_lines
from m4e_fmi.study.systems.plan import SystemPlan

MOST_TOLD = 12
"""FMUs that are named."""


def estimate(study: Study, *, build_directory: str | Path = "build") -> str:
    """Runs of a study, what its names stand for, FMUs to be built, runs that are kept, as text.

    InputError as the study itself.
    """
    folder = Path(build_directory)
    lines = [f"{study.name}: {study.grid.count} runs"]
    lines += [f"  {one.text}" for one in study.grid.not_run]
    if study.is_program:
        plan = ProgramPlan(study, silent)
        work = plan.work(1)
        return "\n".join([*lines, *_axes(plan.named), *work.notes, *_runs(folder, work)])
    with TemporaryFolder() as blobs:
        quick = SystemPlan(study, folder, blobs, silent, quick=True)
        lines += [*_axes(quick.named), *_fmus(quick, missing := quick.missing())]
        if missing:
            lines.append("runs: how many are kept is known when the FMUs are there")
        else:
            work = SystemPlan(study, folder, blobs, silent).work(lambda _: iter(()))
            lines += _runs(folder, work)
    return "\n".join(lines)


def _axes(named: Named) -> Iterator[str]:
    """A line for each dimension, and what its names stand for."""
    for axis in named.study.grid.axes:
        shown = axis.labels
        span = ", ".join(shown) if len(shown) <= 8 else f"{shown[0]} to {shown[-1]}"
        points = f"{len(axis)} points" if len(axis.varied) > 1 else f"{len(axis)}: {span}"
        yield f"  {axis.name} ({points})"
        for varied in axis.varied:
            yield from (f"    {name}: {named.targets[name]}" for name in varied.targets)


def _fmus(plan: SystemPlan, missing: Sequence[str]) -> Iterator[str]:
    """Lines on the FMUs, those that are `missing` by name."""
    for name, one in plan.variants.items():
        if len(one.builds) < len(one.of):
            yield (
                f"  {name}: {len(one.of)} versions share {len(one.builds)} FMUs: what else is "
                "varied are start values"
            )
    count = sum(len(one.builds) for one in plan.variants.values())
    count += len(plan.system.components) - len(plan.variants)
    yield f"FMUs: {len(missing)} to be built, {count - len(missing)} are there"
    yield from (f"  {text}" for text in missing[:MOST_TOLD])
    if len(missing) > MOST_TOLD:
        yield f"  … {len(missing) - MOST_TOLD} more"


def _runs(folder: Path, work: Work) -> Iterator[str]:
    """Warnings, how many runs are kept, and how long one took."""
    yield from (f"  {line}" for line in warning_lines(work.warnings))
    keys = [work.keys[run] for run in work.study.grid.runs]
    with Store(folder / STORE) as store:
        kept = store.found(keys)
    count = sum(key in kept for key in keys)
    took = f", the last took {[*kept.values()][-1].wall_time:.2g} s" if kept else ""
    yield f"runs: {count} kept, {len(keys) - count} to be made{took}"
