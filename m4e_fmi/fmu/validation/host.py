"""The process beside the validating one: starts a process per group of checks and watches it.

It calls no FMU itself, so nothing can happen to it. Where processes can be forked, the checks are
imported once, here.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from m4e_fmi.fmu.validation.call_journal import last_call
from m4e_fmi.fmu.validation.findings import Finding, Group, Severity
from m4e_fmi.fmu.validation.worker import (
    FACTS,
    FOLLOWS,
    MODULES,
    PACKAGE,
    findings_file,
    journal_file,
    stderr_file,
    work_on,
)

RESULTS = "groups.json"
GROUP_LIMIT = 300.0
"""Seconds after which a group of checks is given up, though every single call returns."""
UNASKED_LIMIT = 5.0
"""Seconds for a call that the standard forbids importers to make."""
_POLL = 0.005  # s
_UNFINISHED = "no FMU may end or block its host; what this group checks after it was not looked at"
_WORDS = 400  # characters of what the process wrote last
_START = "start"
_PROCESSES: Any = multiprocessing.get_context("fork" if hasattr(os, "fork") else "spawn")


def main(work: str, fmu: str, call_limit: str, *groups: str) -> None:
    """Run `groups` on the FMU unpacked in folder `fmu`; the result is a file in folder `work`.

    The name of each group is printed when it starts.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end the processes, too
    for module in MODULES.values():
        import_module(f"{PACKAGE}.{module}")
    folder = Path(work)
    found = [asdict(group) for group in _run(folder, fmu, float(call_limit), list(groups))]
    (folder / RESULTS).write_text(json.dumps(found), encoding="utf-8")


def _run(work: Path, fmu: str, call_limit: float, groups: list[str]) -> Iterator[Group]:
    start = _all([_START], work, fmu, call_limit)
    if _START in groups:
        yield from start
    rest = [name for name in groups if name != _START]
    if (work / FACTS).exists():
        yield from _all(rest, work, fmu, call_limit)
    else:
        broken = any(group.failed for group in start)
        reason = (
            "the checks of its start failed to run"
            if broken
            else "the FMU does not start, or makes no step"
        )
        yield from (Group(name, skipped=reason) for name in rest)


def _all(groups: list[str], work: Path, fmu: str, call_limit: float) -> list[Group]:
    """As many at a time as there are processors, in the order given, but see FOLLOWS."""
    waiting, running = list(groups), {}
    done: dict[str, Group] = {}
    try:
        while waiting or running:
            for name in [n for n in waiting if FOLLOWS.get(n) not in (*waiting, *running)]:
                if len(running) < (os.cpu_count() or 1):
                    waiting.remove(name)
                    running[name] = _Watched(name, work, fmu, call_limit)
            for name, watched in list(running.items()):
                if (group := watched.outcome()) is not None:
                    done[name] = group
                    del running[name]
            time.sleep(_POLL)
    finally:
        for watched in running.values():
            watched.process.kill()
    return [done[name] for name in groups]


@dataclass
class _Watched:
    """One group's process; `outcome` is to be asked until it is there."""

    name: str
    work: Path
    fmu: str
    call_limit: float
    began: float = field(default_factory=time.monotonic)
    number: int = 0
    changed: float = field(default_factory=time.monotonic)
    severity: Severity = "error"

    def __post_init__(self) -> None:
        print(self.name, flush=True)
        arguments = (self.name, self.work, self.fmu)
        self.process = _PROCESSES.Process(target=work_on, args=arguments, daemon=True)
        self.process.start()

    def outcome(self) -> Group | None:
        now = time.monotonic()
        last = last_call(journal_file(self.work, self.name))
        if last.number != self.number:
            self.number, self.changed = last.number, now
        call = last.text or "the first call"
        self.severity = "warning" if last.unasked else "error"
        if self.process.exitcode is not None:
            return self._group(self._ended(self.process.exitcode, call))
        limit = min(self.call_limit, UNASKED_LIMIT) if last.unasked else self.call_limit
        if now - self.changed > limit:
            return self._killed(f"{call} did not return within {limit:g} s")
        if now - self.began > GROUP_LIMIT:
            return self._killed(f"not finished after {GROUP_LIMIT:g} s, in {call}")
        return None

    def _killed(self, message: str) -> Group:
        self.process.kill()
        self.process.join()
        return self._group([Finding(f"{self.name}.hang", self.severity, message, _UNFINISHED)])

    def _ended(self, code: int, call: str) -> list[Finding]:
        if code == 0:
            return []
        words = stderr_file(self.work, self.name).read_text(errors="replace").strip()[-_WORDS:]
        name, message = "ended", f"the process ended with code {code} after {call}"
        if code < 0:
            name = "crash"
            message = f"the process was ended by {signal.Signals(-code).name} in {call}"
        told = (words,) if words else ()
        return [Finding(f"{self.name}.{name}", self.severity, message, _UNFINISHED, told)]

    def _group(self, more: list[Finding]) -> Group:
        findings, skipped, failed = _told(findings_file(self.work, self.name))
        seconds = time.monotonic() - self.began
        return Group(self.name, (*findings, *more), skipped, seconds, failed)


def _told(path: Path) -> tuple[list[Finding], str, str]:
    """The findings a process has written, why there was nothing to check, what failed to run."""
    findings, skipped, failed = [], "", ""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    for line in lines:
        told = json.loads(line)
        if "skipped" in told:
            skipped = told["skipped"]
        elif "failed" in told:
            failed = told["failed"]
        else:
            findings.append(Finding.from_dict(told))
    return list(dict.fromkeys(findings)), skipped, failed
