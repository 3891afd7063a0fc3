"""A whole validation: what needs no FMU code here, all else in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Collection
from pathlib import Path

from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.temporary import TemporaryFolder
from m4e_fmi.fmu.importer.opening import check_archive
from m4e_fmi.fmu.importer.unpack import Unpacked
from m4e_fmi.fmu.validation.description.archive import description_findings
from m4e_fmi.fmu.validation.findings import Failure, Group, Report
from m4e_fmi.fmu.validation.host import RESULTS
from m4e_fmi.fmu.validation.worker import MODULES

GROUPS = ("description", *MODULES)
CALL_LIMIT = 20.0
"""Seconds of wall time after which a call that has not returned is said to hang."""
_HOST = "import sys; from m4e_fmi.fmu.validation.host import main; main(*sys.argv[1:])"
_PATIENCE = 5.0  # s for the host to end its own processes when it is interrupted

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
        failed = ""
        try:
            findings, reason = description_findings(unpacked.folder)
        except Exception as error:  # noqa: BLE001  of a check: not to be laid at the FMU's door
            failed = Failure.of(error).error
            findings, reason = (), "the checks of its description failed to run"
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
        errors = Path(work, "stderr")
        with (
            errors.open("wb") as stderr,
            subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=stderr, env=environment, text=True
            ) as host,
        ):
            assert host.stdout is not None
            try:
                for line in host.stdout:
                    tell(line.strip())
            except BaseException:
                host.terminate()
                host.wait(_PATIENCE)
                raise
        results = Path(work, RESULTS)
        if not results.exists():
            words = errors.read_text(errors="replace").strip()
            raise RunError(f"the checks ended with code {host.returncode}:\n{words}")
        return [Group.from_dict(told) for told in json.loads(results.read_text(encoding="utf-8"))]
