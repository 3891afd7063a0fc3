"""One run of a system, as a task that any executor may perform, wherever its workers are.

A task names what it needs by content: a prepared system (`Blob`) and the FMUs in it. A worker takes
these once from the path where they lie.
"""

from __future__ import annotations

import hashlib
import math
import os
import pickle
import shutil
import time as clock
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path

from m4e_fmi.cosim.error.report import CouplingErrorReport
from m4e_fmi.cosim.run.run import RunOptions
from m4e_fmi.cosim.run.running import running
from m4e_fmi.cosim.system.component import Start
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import M4eError, RunError
from m4e_fmi.files.locks import TemporaryFolder
from m4e_fmi.results.results_file import load_results
from m4e_fmi.shown import one_line
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.record import Record, records_of
from m4e_fmi.threads import ONE_RUN

RESULTS = "run.nc"
MEMORY, LEAST_FREE = Path("/dev/shm"), 2**28
"""Folder in memory of Linux, and the bytes that it must have left to be used."""


@dataclass(frozen=True)
class Blob:
    """Bytes by their SHA-256, a file name, and a file that has them, which all workers see."""

    content: str
    name: str = ""
    path: Path = Path()


@dataclass(frozen=True)
class Task:
    """One run: the prepared system, its FMUs by component, and what is other than in that.

    `key` is the hash of all that the run follows from, `start` the start values by component.
    """

    key: str
    prepared: Blob
    fmus: Mapping[str, Blob]
    start: Mapping[str, Start]
    stop_time: float
    wanted: tuple[Wanted, ...]
    series: tuple[str, ...]
    start_up: float
    certify: bool


def perform(task: Task) -> Record:
    """Make the run of a task.

    A run that fails is a record of its failure. In one process there is one run at a time, as of
    FMUs and netCDF's library many cannot be called by two threads.
    """
    with ONE_RUN:
        began = clock.perf_counter()
        warnings: list[str] = []
        try:
            with TemporaryFolder(_memory()) as folder:
                record = _run(task, _prepared(task), folder / RESULTS, warnings)
        except RunError as error:
            record = Record(failure=one_line(error.message))
        except M4eError as error:
            record = Record(failure=one_line(str(error)))
        except (ArithmeticError, LookupError, MemoryError, OSError, TypeError, ValueError) as error:
            record = Record(failure=f"{type(error).__name__}: {error}")
        told = tuple(dict.fromkeys((*record.warnings, *warnings)))
        return replace(record, wall_time=clock.perf_counter() - began, warnings=told)


@lru_cache(maxsize=1)
def _memory() -> Path | None:
    """A folder in memory, where bringing rows to the disk takes no time; None for the usual one."""
    with suppress(OSError):
        if os.access(MEMORY, os.W_OK) and shutil.disk_usage(MEMORY).free > LEAST_FREE:
            return MEMORY
    return None


def _limited(prepared: Prepared) -> list[str]:
    """Outputs with limits, which a run watches in what it records."""
    return [
        f"{component}.{variable.name}"
        for component, variables in prepared.recorded.items()
        for variable in variables
        if math.isfinite(variable.minimum) or math.isfinite(variable.maximum)
    ]


def _run(task: Task, prepared: Prepared, results: Path, warnings: list[str]) -> Record:
    def warn(line: str) -> None:
        warnings.append(line.removeprefix("warning: "))

    names = tuple(dict.fromkeys((*(w.variable for w in task.wanted), *task.series)))
    recorded = tuple(dict.fromkeys((*names, *_limited(prepared))))
    options = RunOptions(results=results, certify=task.certify, warn=warn)
    prepared = replace(prepared, warnings=())  # of the preparation: told once
    with running(prepared.recording(recorded), options) as run:
        run.finish()
    outcome = run.outcome
    assert outcome is not None
    found = load_results(results)
    values = {name: found[name].values.astype(float)[None] for name in names}
    (record,) = records_of(task.wanted, task.series, found.time, values, task.start_up)
    error, source = coupling_error_of(outcome.certificate)
    return replace(record, coupling_error=error, coupling_at=source)


def coupling_error_of(certificate: CouplingErrorReport | str) -> tuple[float, str]:
    """The coupling error [1] that a run tells by itself, and its output; nan if it is not known."""
    if isinstance(certificate, str) or certificate.uncovered or not certificate.worst:
        return math.nan, ""
    return float(certificate.worst.error), str(certificate.worst.source)


def _prepared(task: Task) -> Prepared:
    """The system of a task, with its own start values and settings."""
    fmus = tuple((name, str(_file(blob))) for name, blob in task.fmus.items())
    prepared = _unpacked(_file(task.prepared), fmus)
    system = prepared.system.changed(origin="study", stop_time=task.stop_time)
    components = tuple(
        replace(c, start=dict(task.start[c.name])) if c.name in task.start else c
        for c in system.components
    )
    return replace(prepared, system=replace(system, components=components))


@lru_cache(maxsize=64)
def _unpacked(file: Path, fmus: tuple[tuple[str, str], ...]) -> Prepared:
    """The prepared system in a `file`, with its FMUs at these paths."""
    # trusted as the task itself, which came in the same form and has the hash of this
    prepared: Prepared = pickle.loads(file.read_bytes())
    found = {name: replace(prepared.descriptions[name], path=Path(path)) for name, path in fmus}
    return replace(prepared, descriptions=found)


@lru_cache(maxsize=1)
def _folder() -> TemporaryFolder:
    """A folder of this process, which goes with it."""
    return TemporaryFolder()


@cache
def _file(blob: Blob) -> Path:
    """The file of a content, brought here once; RunError if it is another one by now."""
    data = blob.path.read_bytes()
    if hashlib.sha256(data).hexdigest() != blob.content:
        raise RunError(f"{blob.path}: it has changed since the study began", "run again")
    file = _folder().path / blob.content[:16] / blob.name
    if not file.exists():
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(data)
    return file
