"""One run of a system, as a task that any executor may perform, wherever its workers are.

A task names what it needs by content: a prepared system (`Blob`) and the FMUs in it. A worker takes
these from the path where they lie, or keeps what it was sent, once; if it has neither, it says what
it lacks, and the task comes again with it.
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
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.connections.recorded_variables import chosen
from m4e_fmi.cosim.error_estimate.report import CouplingErrorReport
from m4e_fmi.cosim.master.begun import Options, begun_run
from m4e_fmi.cosim.system.component import Start
from m4e_fmi.errors import InputError, M4eError, RunError
from m4e_fmi.files.temporary import TemporaryFolder
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.results.results_file import load
from m4e_fmi.shown import one_line
from m4e_fmi.study.given.study import Wanted
from m4e_fmi.study.runs.record import Record
from m4e_fmi.study.runs.statistics_of import computed
from m4e_fmi.threads import ONE_RUN

RESULTS = "run.nc"
MEMORY, LEAST_FREE = Path("/dev/shm"), 2**28
"""Folder in memory of Linux, and the bytes that it must have left to be used."""


@dataclass(frozen=True)
class Blob:
    """Bytes by their SHA-256, a file name, and a file that has them, if the worker can see it."""

    content: str
    name: str = ""
    path: Path | None = None

    def read(self) -> bytes | None:
        """The bytes of the file; None if it is not there, or another one."""
        if self.path is None:
            return None
        with suppress(OSError):
            data = self.path.read_bytes()
            if hashlib.sha256(data).hexdigest() == self.content:
                return data
        return None


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

    @property
    def blobs(self) -> dict[str, Blob]:
        """All that it needs, by content."""
        return {blob.content: blob for blob in (self.prepared, *self.fmus.values())}


@dataclass(frozen=True)
class Lacking:
    """A worker's answer: it has not got these contents."""

    contents: tuple[str, ...]


def perform(task: Task, sent: Mapping[str, bytes] | None = None) -> Record | Lacking:
    """Make the run of a task. `sent` are contents that the worker may lack.

    A run that fails is a record of its failure. In one process there is one run at a time, as of
    FMUs and netCDF's library many cannot be called by two threads.
    """
    with ONE_RUN:
        return _performed(task, sent)


def _performed(task: Task, sent: Mapping[str, bytes] | None) -> Record | Lacking:
    """As `perform`, by one thread."""
    place = _place()
    for content, data in (sent or {}).items():
        place.put(task.blobs[content], data)
    lacking = tuple(content for content, blob in task.blobs.items() if not place.has(blob))
    if lacking:
        return Lacking(lacking)
    began = clock.perf_counter()
    warnings: list[str] = []
    try:
        prepared = _prepared(task, place)
        with TemporaryFolder(_memory()) as folder:
            record = _run(task, prepared, folder / RESULTS, warnings)
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


def _limited(descriptions: Mapping[str, Description]) -> list[str]:
    """Outputs with limits, which a run watches in what it records."""
    return [
        f"{component}.{variable.name}"
        for component, variables in chosen(descriptions, ()).items()
        for variable in variables
        if math.isfinite(variable.minimum) or math.isfinite(variable.maximum)
    ]


def _run(task: Task, prepared: Prepared, results: Path, warnings: list[str]) -> Record:
    def warn(line: str) -> None:
        warnings.append(line.removeprefix("warning: "))

    names = tuple(dict.fromkeys((*(w.variable for w in task.wanted), *task.series)))
    recorded = tuple(dict.fromkeys((*names, *_limited(prepared.descriptions))))
    options = Options(results=results, variables=recorded, certify=task.certify, warn=warn)
    prepared = replace(prepared, warnings=())  # of the preparation: told once
    with begun_run(prepared, options) as begun:
        begun.master.run(results=begun.results)
    outcome = begun.outcome
    assert outcome is not None
    found = load(results)
    values = {name: found[name].values.astype(float)[None] for name in names}
    numbers, reasons = computed(task.wanted, found.time, values, task.start_up)
    error, source = coupling_error_of(outcome.certificate)
    return Record(
        values={name: float(number[0]) for name, number in numbers.items()},
        time=found.time,
        series={name: values[name][0] for name in task.series},
        coupling_error=error,
        coupling_at=source,
        undefined={name: reason[0] for name, reason in reasons.items() if reason[0]},
    )


def coupling_error_of(certificate: CouplingErrorReport | str) -> tuple[float, str]:
    """The coupling error [1] that a run tells by itself, and its output; nan if it is not known."""
    if isinstance(certificate, str) or certificate.uncovered or not certificate.worst:
        return math.nan, ""
    return float(certificate.worst.error), str(certificate.worst.source)


def _prepared(task: Task, place: _Place) -> Prepared:
    """The system of a task, with its own start values and settings."""
    fmus = tuple((name, str(place.file(blob))) for name, blob in task.fmus.items())
    prepared = _unpacked(task.prepared.content, fmus)
    system = prepared.system.changed(origin="study", stop_time=task.stop_time)
    components = tuple(
        replace(c, start=dict(task.start[c.name])) if c.name in task.start else c
        for c in system.components
    )
    return replace(prepared, system=replace(system, components=components))


@lru_cache(maxsize=64)
def _unpacked(content: str, fmus: tuple[tuple[str, str], ...]) -> Prepared:
    """The prepared system of that content, with its FMUs at these paths."""
    # trusted as the task itself, which came in the same form and has the hash of this
    data = _place().known[content].read_bytes()
    prepared: Prepared = pickle.loads(data)
    found = {name: replace(prepared.descriptions[name], path=Path(path)) for name, path in fmus}
    return replace(prepared, descriptions=found)


@dataclass
class _Place:
    """Contents that a worker has, in a folder of its own that goes with its process."""

    folder: TemporaryFolder = field(default_factory=TemporaryFolder)
    known: dict[str, Path] = field(default_factory=dict)

    def has(self, blob: Blob) -> bool:
        """True if the content is here now; it is brought here if its file can be seen."""
        if blob.content in self.known:
            return True
        data = blob.read()
        if data is not None:
            self.put(blob, data)
        return data is not None

    def put(self, blob: Blob, data: bytes) -> None:
        """Keep a content; InputError if it is another one."""
        if hashlib.sha256(data).hexdigest() != blob.content:
            raise InputError.single("what was sent to a worker is damaged", "run again")
        if blob.content not in self.known:
            folder = self.folder.path / blob.content[:16]
            folder.mkdir(exist_ok=True)
            file = folder / blob.name
            file.write_bytes(data)
            self.known[blob.content] = file

    def file(self, blob: Blob) -> Path:
        """The file of a content that is here."""
        return self.known[blob.content]


@lru_cache(maxsize=1)
def _place() -> _Place:
    return _Place()
