"""A whole validation: what needs no FMU code here, all else in processes of their own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.fmu.reading import check_archive
from m4e_fmi.fmu.unpack import Unpacked
from m4e_fmi.fmu.validation.archive import description_findings
from m4e_fmi.fmu.validation.findings import Finding, Group, Report
from m4e_fmi.fmu.validation.journal import last_call
from m4e_fmi.fmu.validation.worker import FACTS, MODULES, findings_file, journal_file

GROUPS = ("description", *MODULES)
FOLLOWS = {"state_elsewhere": "state"}
"""Groups that need what another has left."""
_WORKER = "import sys; from m4e_fmi.fmu.validation.worker import main; main(*sys.argv[1:])"
CALL_LIMIT = 20.0
"""Seconds of wall time after which a call that has not returned is said to hang."""
GROUP_LIMIT = 300.0
_POLL = 0.01  # s
_UNFINISHED = "no FMU may end or block its host; what this group checks after it was not looked at"
_WORDS_OF_A_CRASH = 400  # characters of what the process wrote last

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
    is no FMU at all, or a group is unknown.
    """
    path = Path(path)
    for name in (*only, *skip):
        if name not in GROUPS:
            raise InputError.single(f"there is no group {name!r}", f"groups: {', '.join(GROUPS)}")
    wanted = [g for g in GROUPS if (not only or g in only) and g not in skip]
    check_archive(path)
    unpacked = Unpacked(path)
    try:
        with tempfile.TemporaryDirectory(prefix="m4e_fmi_") as work:
            run = _Run(unpacked.folder, Path(work), call_limit, tell or (lambda _: None))
            return Report(path, tuple(run.groups(path, wanted)))
    finally:
        unpacked.remove()


@dataclass(frozen=True)
class _Run:
    """The FMU unpacked in `fmu`; the processes' files are in `work`."""

    fmu: Path
    work: Path
    call_limit: float
    tell: Tell

    def groups(self, path: Path, wanted: list[str]) -> Iterator[Group]:
        self.tell("description")
        began = time.perf_counter()
        findings, reason = description_findings(path, self.fmu)
        if "description" in wanted:
            yield Group("description", findings, seconds=time.perf_counter() - began)
        rest = [name for name in wanted if name not in ("description", "start")]
        if not rest and "start" not in wanted:
            return
        start = Group("start", skipped=reason) if reason else self._group("start")
        if "start" in wanted:
            yield start
        if not reason and not (self.work / FACTS).exists():
            reason = "the FMU does not start"
        if reason:
            yield from (Group(name, skipped=reason) for name in rest)
            return
        chains = [[name] for name in rest if name not in FOLLOWS]
        for chain in chains:
            chain += [name for name in rest if FOLLOWS.get(name) == chain[0]]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for done in pool.map(lambda chain: [self._group(name) for name in chain], chains):
                yield from done

    def _group(self, name: str) -> Group:
        """Run a group of checks in a process of its own."""
        self.tell(name)
        began = time.perf_counter()
        errors = self.work / f"{name}.stderr"
        command = [sys.executable, "-c", _WORKER, name, str(self.work), str(self.fmu)]
        with errors.open("wb") as stderr:
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr)
            try:
                hung = self._wait(process, name)
            finally:
                if process.poll() is None:
                    process.kill()
                    process.wait()
        findings, skipped = _told(findings_file(self.work, name))
        call = last_call(journal_file(self.work, name))[1] or "the first call"
        if hung:
            findings.append(Finding(f"{name}.hang", "error", f"{call} {hung}", _UNFINISHED))
        elif process.returncode:
            words = errors.read_text(errors="replace").strip()[-_WORDS_OF_A_CRASH:]
            findings.append(_ended(name, process.returncode, call, words))
        return Group(name, tuple(findings), skipped, time.perf_counter() - began)

    def _wait(self, process: subprocess.Popen, name: str) -> str:
        """Wait for the end, or until a call takes too long: then what to say of it."""
        began = changed = time.monotonic()
        number = 0
        while True:
            try:
                process.wait(_POLL)
                return ""
            except subprocess.TimeoutExpired:
                pass
            now = time.monotonic()
            if (latest := last_call(journal_file(self.work, name))[0]) != number:
                number, changed = latest, now
            if now - changed > self.call_limit:
                return f"did not return within {self.call_limit:g} s"
            if now - began > GROUP_LIMIT:
                return f"was reached after {GROUP_LIMIT:g} s of calls: the FMU is too slow"


def _told(path: Path) -> tuple[list[Finding], str]:
    """The findings a process has written, and why there was nothing to check."""
    findings, skipped = [], ""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    for line in lines:
        told = json.loads(line)
        if "skipped" in told:
            skipped = told["skipped"]
        else:
            findings.append(Finding(**{**told, "words": tuple(told["words"])}))
    return findings, skipped


def _ended(name: str, code: int, call: str, words: str) -> Finding:
    if code < 0:
        message = f"the process was ended by {signal.Signals(-code).name} in {call}"
        return Finding(f"{name}.crash", "error", message, _UNFINISHED, (words,) * bool(words))
    message = f"the process ended with code {code} after {call}"
    return Finding(f"{name}.ended", "error", message, _UNFINISHED, (words,) * bool(words))
