"""The process beside the validating one: starts a process per group of checks and watches it.

Where processes can be forked, the checks are imported once, here.
"""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path

from m4e_fmi.fmu.importer.watched_process import Ending, WatchedProcess
from m4e_fmi.fmu.importer.worker.keeper import end_with_parent
from m4e_fmi.fmu.validation.findings import Finding, Group
from m4e_fmi.fmu.validation.worker import (
    ENDED,
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
_POLL = 0.005  # s
_UNFINISHED = "no FMU may end or block its host; the later checks of this group were skipped"
_WORDS = 400  # characters of what the process wrote last
_START = "start"
_LATE = ("fmpy.validation", "numpy.random")
"""Modules that the libraries import at their first use: else each process would."""


def main(work: str, fmu: str, call_limit: str, *groups: str) -> None:
    """Run `groups` on the FMU unpacked in folder `fmu`; the result is a file in folder `work`.

    The name of each group is printed when it starts.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # end the processes, too
    end_with_parent()
    for module in (*(f"{PACKAGE}.{name}" for name in MODULES.values()), *_LATE):
        import_module(module)
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
    waiting = list(groups)
    running: dict[str, _RunningGroup] = {}
    done: dict[str, Group] = {}
    try:
        while waiting or running:
            for name in [n for n in waiting if FOLLOWS.get(n) not in (*waiting, *running)]:
                if len(running) < (os.cpu_count() or 1):
                    waiting.remove(name)
                    running[name] = _RunningGroup(name, work, fmu, call_limit)
            for name, group in list(running.items()):
                if (outcome := group.outcome()) is not None:
                    done[name] = outcome
                    del running[name]
            time.sleep(_POLL)
    finally:
        for group in running.values():
            group.process.kill()
    return [done[name] for name in groups]


class _RunningGroup:
    """One group's process; `outcome` is to be asked until it is there."""

    def __init__(self, name: str, work: Path, fmu: str, call_limit: float) -> None:
        self._name, self._work = name, work
        print(name, flush=True)
        self.process = WatchedProcess(
            work_on,
            (name, work, fmu),
            journal_file(work, name),
            call_limit=call_limit,
            limit=GROUP_LIMIT,
        )

    def outcome(self) -> Group | None:
        ending = self.process.ending()
        if ending is None:
            return None
        findings, skipped, failed, is_whole = _told(findings_file(self._work, self._name))
        if ending.kind == "done" and not is_whole:  # by exit(0), in a call
            ending = replace(ending, kind="ended")
        if ending.kind != "done":
            findings.append(self._finding(ending))
        seconds = time.monotonic() - self.process.began
        return Group(self._name, tuple(findings), skipped, seconds, failed)

    def _finding(self, ending: Ending) -> Finding:
        words = ""
        if ending.kind != "hang":
            errors = stderr_file(self._work, self._name).read_text(errors="replace")
            words = errors.strip()[-_WORDS:]
        severity = "warning" if ending.unasked else "error"
        name = f"{self._name}.{ending.kind}"
        return Finding(name, severity, ending.message, _UNFINISHED, (words,) if words else ())


def _told(path: Path) -> tuple[list[Finding], str, str, bool]:
    """All that a process has told: findings, why there was nothing to check, what failed to run.

    And if it came to its end.
    """
    findings, skipped, failed, is_whole = [], "", "", False
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    for line in lines:
        told = json.loads(line)
        if "skipped" in told:
            skipped = told["skipped"]
        elif told == ENDED:
            is_whole = True
        elif "failed" in told:
            failed = told["failed"]
        else:
            findings.append(Finding.from_dict(told))
    return list(dict.fromkeys(findings)), skipped, failed, is_whole
