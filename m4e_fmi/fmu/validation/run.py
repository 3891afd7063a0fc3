"""A whole validation: what needs no FMU code here, all else in processes of their own.

A process beside this one, the host, imports the checks once and starts one more for each group. A
group's findings go line by line into a file, the calls it makes into a journal: FMU code may end
its process at any time.
"""

from __future__ import annotations

import json
import mmap
import multiprocessing
import os
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import asdict
from importlib import import_module
from multiprocessing.process import BaseProcess
from pathlib import Path

from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.locks import TemporaryFolder
from m4e_fmi.fmu.importer.opening import Unpacked, check_archive
from m4e_fmi.fmu.importer.worker.keeper import end_with_parent, kill, kill_children, set_apart
from m4e_fmi.fmu.validation.description import description_findings
from m4e_fmi.fmu.validation.findings import Finding, Group, Report, failure
from m4e_fmi.fmu.validation.probe import FACTS, Context, RefusedError, refused
from m4e_fmi.fmu.validation.subject import FmuUnderTest

PACKAGE = "m4e_fmi.fmu.validation.checks"
MODULES = {
    "start": "start",
    "dependencies": "influence",
    "directional": "influence",
    "state": "repeats",
    "state_elsewhere": "repeats",
    "instances": "repeats",
}
"""Group → module with its `check`, or `check_GROUP`, in the order in which they are run."""
GROUPS = ("description", *MODULES)
CALL_LIMIT = 20.0
"""Seconds of wall time after which a call that has not returned is said to hang."""
GROUP_LIMIT = 300.0
"""Seconds after which a group of checks is given up, though every single call returns."""
ENDED: dict[str, object] = {"ended": True}
"""The last that a group tells, if the FMU does not end its process before."""
_HOST = "import sys; from m4e_fmi.fmu.validation.run import host; host(*sys.argv[1:])"
_PATIENCE = 5.0  # s for the host to end its own processes when it is interrupted
_POLL = 0.005  # s
_UNFINISHED = "no FMU may end or block its host; the later checks of this group were skipped"
_WORDS = 400  # characters of what the process wrote last
_START = "start"
_JOURNAL_SIZE = 512
_JOURNAL_HEAD = struct.Struct("<Q")
_LATE = ("fmpy.validation", "numpy.random")
"""Modules that the libraries import at their first use: else each process would."""

Tell = Callable[[str], None]


def validate_fmu(
    path: str | Path,
    *,
    only: Collection[str] = (),
    skip: Collection[str] = (),
    call_limit: float = CALL_LIMIT,
    tell: Tell | None = None,
) -> Report:
    """Check the FMU at `path` by its description and by what it does; see docs/validate.md.

    FMU code runs in processes of its own, one per group of checks: a crash, or a call that does not
    return within `call_limit` [s], is a finding that names the call. `only` and `skip` choose among
    GROUPS. `tell` is called with the name of each group before it starts. InputError if the file
    is no FMU at all, a group is unknown, or none is left.
    """
    path = Path(path)
    for name in (*only, *skip):
        if name not in GROUPS:
            raise InputError.single(f"there is no group {name!r}", f"groups: {', '.join(GROUPS)}")
    wanted = [name for name in GROUPS if (not only or name in only) and name not in skip]
    if not wanted:
        raise InputError.single("no group is left to check", "a group is both chosen and left out")
    check_archive(path)
    tell = tell or (lambda _: None)
    unpacked = Unpacked(path)
    try:
        tell("description")
        began = time.monotonic()
        findings, failed, reason = (), "", "the checks of its description failed to run"
        try:
            findings, reason = description_findings(unpacked.folder)
        except Exception as error:  # noqa: BLE001  of a check: not to be laid at the FMU's door
            failed = failure(error)
        seconds = time.monotonic() - began
        groups = [Group("description", findings, seconds=seconds, failed=failed)]
        running = [name for name in wanted if name != "description"]
        if reason:
            groups += [Group(name, skipped=reason) for name in running]
        elif running:
            groups += _in_processes(unpacked.folder, running, call_limit, tell)
    finally:
        unpacked.remove()
    return Report(path, tuple(group for group in groups if group.name in wanted))


def _in_processes(fmu: Path, groups: list[str], call_limit: float, tell: Tell) -> list[Group]:
    with TemporaryFolder() as work:
        command = [sys.executable, "-c", _HOST, str(work), str(fmu), str(call_limit), *groups]
        # threads of numpy's would be copied with each process, to no use
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        errors, found = Path(work, "stderr"), list[Group]()
        with (
            errors.open("wb") as stderr,
            subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=stderr, env=environment, text=True
            ) as process,
        ):
            assert process.stdout is not None
            try:
                for line in process.stdout:
                    message = json.loads(line)
                    if isinstance(message, str):
                        tell(message)
                    else:
                        found = [Group.from_dict(group) for group in message]
            except BaseException:
                process.terminate()
                process.wait(_PATIENCE)
                raise
        if process.returncode:
            words = errors.read_text(errors="replace").strip()
            raise RunError(f"the checks ended with code {process.returncode}:\n{words}")
        return found


# ---- processes that are watched ----


class CallJournal:
    """The file at `path` holds the number and the text of the last call."""

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(_JOURNAL_SIZE))
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), _JOURNAL_SIZE)
        self._number = 0

    def __call__(self, call: str) -> None:
        """Write a call down as the last one."""
        self._number += 1
        text = call.encode("ascii", "backslashreplace")[: _JOURNAL_SIZE - _JOURNAL_HEAD.size]
        self._map[:] = (_JOURNAL_HEAD.pack(self._number) + text).ljust(_JOURNAL_SIZE, b"\0")


def _last_call(path: Path) -> tuple[int, str]:
    """Number and text of the last call in the journal at `path`; 0 and "" before the first."""
    content = path.read_bytes() if path.exists() else b""
    if len(content) < _JOURNAL_SIZE:
        return 0, ""
    text = content[_JOURNAL_HEAD.size :].rstrip(b"\0").decode("ascii", "replace")
    return _JOURNAL_HEAD.unpack_from(content)[0], text


class WatchedProcess:
    """The process of a `group`, whose files are in the folder `work`: see `work_on`.

    It is killed when a call takes longer than `call_limit` [s], or all of it longer than
    GROUP_LIMIT.
    """

    def __init__(self, group: str, work: Path, fmu: str, call_limit: float) -> None:
        self._journal, self._call_limit = _file(work, group, "journal"), call_limit
        self.began = self._changed = time.monotonic()
        self._number = 0
        context = multiprocessing.get_context("fork" if hasattr(os, "fork") else "spawn")
        self._process: BaseProcess = context.Process(  # pyrefly: ignore[missing-attribute]
            target=work_on, args=(group, work, fmu), daemon=True
        )
        self._process.start()
        assert self._process.pid
        self.pid = self._process.pid

    def ending(self) -> tuple[str, str] | None:
        """How the process ended: done, ended, crash or hang, and a message with the last call.

        None while it runs. To be asked until it is there.
        """
        now = time.monotonic()
        number, text = _last_call(self._journal)
        if number != self._number:
            self._number, self._changed = number, now
        call = text or "the first call"
        code = self._process.exitcode
        if code is not None:
            kill_children(self.pid)
            if code < 0:
                return "crash", f"the process was ended by {signal.Signals(-code).name} in {call}"
            return "ended" if code else "done", f"the process ended with code {code} after {call}"
        if now - self._changed > self._call_limit:
            message = f"{call} did not return within {self._call_limit:g} s"
        elif now - self.began > GROUP_LIMIT:
            message = f"not finished after {GROUP_LIMIT:g} s, in {call}"
        else:
            return None
        kill(self.pid)
        self._process.join()
        return "hang", message


# ---- in the host ----


def host(work: str, fmu: str, call_limit: str, *groups: str) -> None:
    """Run `groups` on the FMU unpacked in folder `fmu`, with files in folder `work`.

    The name of each group is printed when it starts, and all of them at the end, in JSON.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end the processes, too
    end_with_parent()
    for module in (*(f"{PACKAGE}.{name}" for name in MODULES.values()), *_LATE):
        import_module(module)
    found = _checked(Path(work), fmu, float(call_limit), list(groups))
    print(json.dumps([asdict(group) for group in found]), flush=True)


def _checked(work: Path, fmu: str, call_limit: float, groups: list[str]) -> Iterator[Group]:
    start = _done(_START, work, fmu, call_limit)
    if _START in groups:
        yield start
    reason = "" if (work / FACTS).exists() else "the FMU does not start, or makes no step"
    if start.failed:
        reason = "the checks of its start failed to run"
    for name in (name for name in groups if name != _START):
        yield Group(name, skipped=reason) if reason else _done(name, work, fmu, call_limit)


def _done(name: str, work: Path, fmu: str, call_limit: float) -> Group:
    """The group `name`, from a process of its own."""
    print(json.dumps(name), flush=True)
    process = WatchedProcess(name, work, fmu, call_limit)
    try:
        while (ending := process.ending()) is None:
            time.sleep(_POLL)
    except BaseException:
        kill(process.pid)
        raise
    return _outcome(name, work, *ending, time.monotonic() - process.began)


def _outcome(name: str, work: Path, how: str, message: str, seconds: float) -> Group:
    path = _file(work, name, "findings")
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    results = [json.loads(line) for line in lines]
    if how == "done" and ENDED not in results:  # by exit(0), in a call
        how = "ended"
    findings = [one for one in results if "id" in one]
    if how != "done":
        words = ""
        if how != "hang":
            words = _file(work, name, "stderr").read_text(errors="replace").strip()[-_WORDS:]
        said = (words,) if words else ()
        findings.append(asdict(Finding(f"{name}.{how}", "error", message, _UNFINISHED, said)))
    unique = [one for k, one in enumerate(findings) if one not in findings[:k]]
    skipped = next((one["skipped"] for one in results if "skipped" in one), "")
    failed = next((one["failed"] for one in results if "failed" in one), "")
    group = {"name": name, "findings": unique, "skipped": skipped, "failed": failed}
    return Group.from_dict({**group, "seconds": seconds})


def _file(folder: Path, group: str, suffix: str) -> Path:
    return folder / f"{group}.{suffix}"


# ---- in the process of a group ----


def work_on(group: str, folder: Path, fmu: str) -> None:
    """Run `group` on the FMU unpacked in folder `fmu`; its files go into `folder`.

    Standard output belongs to the FMU, and goes nowhere.
    """
    set_apart()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(_file(folder, group, "stderr"), os.O_WRONLY | os.O_CREAT), 2)
    with _file(folder, group, "findings").open("w", encoding="utf-8") as file:

        def write(result: Mapping[str, object]) -> None:
            file.write(json.dumps(result) + "\n")
            file.flush()

        try:
            for result in _results(group, folder, Path(fmu)):
                write(result)
        except Exception as error:  # noqa: BLE001  of a check: not to be laid at the FMU's door
            write({"failed": failure(error)})
        write(ENDED)


def _results(group: str, folder: Path, fmu: Path) -> Iterable[Mapping[str, object]]:
    """Findings of a group, why there is nothing to check, what failed to run."""
    module = import_module(f"{PACKAGE}.{MODULES[group]}")
    check = getattr(module, f"check_{group}", None) or module.check
    subject = FmuUnderTest(fmu)
    version, known = subject.raw.fmiVersion, folder / FACTS
    facts = json.loads(known.read_text()) if known.exists() else {}
    context = Context(subject, CallJournal(_file(folder, group, "journal")), folder, **facts)
    try:
        for found in check(context):
            if isinstance(found, str):
                yield {"skipped": found}
            else:
                yield asdict(found.of(version))
    except RefusedError as error:
        yield asdict(refused(group, error).of(version))
