"""Runs of ``m4e-fmi run`` in processes of their own, and everything that they leave behind.

Processes are forked from a server that has imported the program (multiprocessing's fork server), so
that a run costs a third of that in a fresh interpreter.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import multiprocessing
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing.context import ForkServerProcess
from pathlib import Path

import numpy as np
from support.faults.table import Fault

from m4e_fmi.results.results_file import Results, load_results

COMPONENTS = {"buoy": "mass", "arm": "middle", "line": "spring"}
"""A chain of two masses and a spring, each component an FMU of its own."""
STOP, STEP = 2.0, 0.01  # s
LIMIT, MEMORY = 1.0, 400_000_000
"""Seconds that a call of an FMU may take, and address space of its process."""
CHECKPOINTS = 0.13
"""Simulated seconds between checkpoints."""
FAULTS = "M4E_TEST_FAULTS"
"""Environment variable: the folder of the plan that arms a fault."""
IN_TIME = 60.0
"""Seconds of wall time after which a run counts as hanging; it takes 1 to 3 on an idle machine."""
_PRELOADED = ("m4e_fmi.cli.run", "m4e_fmi.cosim", "m4e_fmi.report", "matplotlib.pyplot")


@dataclass(frozen=True)
class Done:
    """A command that has ended: exit code (None: killed at the time limit), words, seconds."""

    code: int | None
    out: str
    err: str
    seconds: float
    session: int


@dataclass
class Place:
    """A folder with a system and its runs; faults are armed by `arm`."""

    folder: Path
    system: Path = field(init=False)

    def __post_init__(self) -> None:
        self.system = self.folder / "system.yaml"
        for name in ("faults", "tmp"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)

    def arm(self, fault: Fault | None) -> None:
        """Have a fault strike; None: no more."""
        plan = self.folder / "faults" / "plan"
        plan.unlink(missing_ok=True)
        if fault:
            (self.folder / "faults" / "calls").unlink(missing_ok=True)
            plan.write_text(fault.plan)

    def has_struck(self, fault: Fault) -> bool:
        """The call at which the fault strikes has been made."""
        calls = self.folder / "faults" / "calls"
        return calls.exists() and calls.stat().st_size >= fault.count

    def run(self, *options: str, limit: float = IN_TIME, words: str = "words") -> Done:
        """The run of its system into r.nc, with more options."""
        with self.running(*options, words=words) as process:
            return finished(self, process, limit)

    @contextlib.contextmanager
    def running(
        self, *options: str, patch: Callable[[], None] | None = None, words: str = "words"
    ) -> Iterator[Running]:
        """The process of a run; killed at the end. `patch` is called in it first.

        It writes to the files `words`, .out and .err.
        """
        arguments = ["run", "system.yaml", "--output-file", "r.nc", "--no-plot", *options]
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(list(_PRELOADED))
        process = context.Process(target=_command, args=(str(self.folder), words, arguments, patch))
        began = time.monotonic()
        process.start()
        try:
            yield Running(process, began, words)
        finally:
            process.kill()
            process.join()

    def results(self) -> Results:
        """Rows of r.nc."""
        return load_results(self.folder / "r.nc")

    def resuming(self) -> tuple[str, ...]:
        """Options of a run that goes on, if there is a checkpoint."""
        return ("--resume",) if (self.folder / "r.nc.checkpoint").exists() else ()

    def left_behind(self, done: Done) -> list[str]:
        """Processes, which are then killed, and files that a run has left beside its results."""
        return [*self.processes_left(done), *self._litter()]

    def processes_left(self, done: Done) -> list[str]:
        """Processes that a run has left; they are then killed."""
        end = time.monotonic() + 3.0  # the system may take its time to end what was killed
        while (left := self._processes(done.session)) and time.monotonic() < end:
            time.sleep(0.05)
        for number in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
        return list(left.values())

    def workers(self, session: int) -> list[int]:
        """Numbers of the processes in which FMUs run, of a run that goes on."""
        return [number for number in self._processes(session) if number != session]

    def _processes(self, session: int) -> dict[int, str]:
        """Command lines of living processes of a run, by their numbers."""
        found: dict[int, str] = {}
        for entry in Path("/proc").iterdir():
            if entry.name.isdecimal() and int(entry.name) != os.getpid():
                with contextlib.suppress(OSError):
                    state, _, _, theirs = _stat(entry)[:4]
                    if state != "Z" and (int(theirs) == session or self._is_named(entry)):
                        words = (entry / "cmdline").read_bytes().replace(b"\0", b" ")[:200]
                        found[int(entry.name)] = f"process ({state}) {words.decode()}"
        return found

    def _is_named(self, entry: Path) -> bool:
        """The folder is in the environment or in the command of a process."""
        here = os.fsencode(self.folder)
        return any(here in (entry / name).read_bytes() for name in ("environ", "cmdline"))

    def _litter(self) -> list[str]:
        found = [*(self.folder / "tmp").iterdir(), *self.folder.glob(".*")]
        return [path.relative_to(self.folder).as_posix() for path in found]


@dataclass
class Running:
    """A process that runs a system, when it began (monotonic, s), and the files of its words."""

    process: ForkServerProcess
    began: float
    words: str

    @property
    def pid(self) -> int:
        """Number of the process."""
        assert self.process.pid
        return self.process.pid

    def send(self, number: signal.Signals) -> None:
        """Send a signal, unless the process has ended."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, number)


def finished(place: Place, running: Running, limit: float = IN_TIME) -> Done:
    """Wait for the end of a run, at most `limit` seconds; then it is killed."""
    running.process.join(limit)
    code = running.process.exitcode
    seconds = time.monotonic() - running.began
    running.process.kill()
    running.process.join()
    out, err = (
        (place.folder / f"{running.words}.{name}").read_text(errors="replace")
        for name in ("out", "err")
    )
    return Done(code, out, err, seconds, running.pid)


def write_system(place: Place, fmus: Mapping[str, Path], **settings: str | float) -> None:
    """The file of the system of COMPONENTS; `settings` go into ``simulation``."""
    components = {name: {"fmu": str(path)} for name, path in fmus.items()}
    content = {
        "name": "faults",
        "components": components | {"buoy": {**components["buoy"], "start": {"body.m.x": 1.0}}},
        "connections": ["buoy.body.m <-> arm.end", "arm.body.m <-> line.end"],
        "simulation": {"stop_time": STOP, "step_size": STEP, **settings},
        "limits": {"call": LIMIT, "end": LIMIT, "memory": MEMORY},
        "environment": {"keep": [FAULTS]},
    }
    place.system.write_text(json.dumps(content))


def differences(
    found: Results, whole: Results, *, complete: bool, before: float = np.inf, but: str = "created"
) -> list[str]:
    """Rows and, of a complete one, attributes in which a results file differs from the undisturbed.

    Only rows `before` a time [s] count; the attributes named in `but` may differ, and the record,
    which has the text of the system's file with its fault.
    """
    count = int(np.searchsorted(found.time, before))
    wrong = []
    if count > len(whole.time) or (complete and count < len(whole.time)):
        wrong.append(f"{count} rows instead of {len(whole.time)}")
    if list(found.series) != list(whole.series):
        wrong.append(f"variables {list(found.series)}")
    pairs = {name: (one.values, whole[name].values) for name, one in found.series.items()}
    for name, (mine, theirs) in {"time": (found.time, whole.time), **pairs}.items():
        first = next((k for k in range(count) if mine[k].tobytes() != theirs[k].tobytes()), None)
        if first is not None:
            wrong.append(f"{name} from row {first} on: {mine[first]!r}, not {theirs[first]!r}")
    if complete:
        keys = {*found.attributes, *whole.attributes} - {"created", "record", but}
        wrong += [
            f"attribute {key}: {found.attributes.get(key)!r}, not {whole.attributes.get(key)!r}"
            for key in sorted(keys)
            if found.attributes.get(key) != whole.attributes.get(key)
        ]
    return wrong


def _stat(entry: Path) -> Sequence[str]:
    """State, parent, group and session of a process, and more, from its entry in /proc."""
    return (entry / "stat").read_text().rpartition(")")[2].split()


def _command(
    folder: str, words: str, arguments: Sequence[str], patch: Callable[[], None] | None
) -> None:
    """Be a process of its own session that runs a command in a folder."""
    os.setsid()
    os.chdir(folder)
    os.environ |= {"TMPDIR": f"{folder}/tmp", FAULTS: f"{folder}/faults"}
    tempfile.tempdir = None
    for number, name in ((0, os.devnull), (1, f"{words}.out"), (2, f"{words}.err")):
        file = os.open(name, os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, number)
        os.close(file)
    sys.stdin = open(0, closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, closefd=False)  # noqa: SIM115
    if patch:
        patch()
    from m4e_fmi.cli import main

    code = main(list(arguments))
    atexit._run_exitfuncs()  # as an interpreter does, but not a process of multiprocessing
    sys.stdout.flush()
    sys.exit(code)
