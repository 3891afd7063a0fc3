"""The process that runs one group of checks: FMU code may end it at any time.

What it finds goes line by line into a file, the calls it makes into another. Standard output
belongs to the FMU, and goes nowhere.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

from m4e_fmi.fmu.importer.call_journal import Journal
from m4e_fmi.fmu.validation.checks.capabilities import refused
from m4e_fmi.fmu.validation.context import Context, Facts
from m4e_fmi.fmu.validation.findings import Failure, Finding
from m4e_fmi.fmu.validation.fmu_under_test import FmuUnderTest
from m4e_fmi.fmu.validation.library import Library
from m4e_fmi.fmu.validation.probe import RefusedError

PACKAGE = "m4e_fmi.fmu.validation.checks"
FACTS = "facts.json"
ENDED: dict[str, object] = {"ended": True}
"""The last that a group tells, if the FMU does not end its process before."""
MODULES = {
    "start": "capabilities",
    "values": "values",
    "dependencies": "dependencies",
    "derivatives": "derivatives",
    "directional": "directional",
    "state": "states",
    "state_elsewhere": "state_transfer",
    "instances": "instances",
    "solution": "solutions",
    "phases": "state_machine",
    "parameters": "parameters",
}
"""Group → module with its `check`, in the order in which they are run."""
FOLLOWS = {"state_elsewhere": "state"}
"""Groups that need what another has left."""

Check = Callable[[Context], Iterator[Finding | Facts | Failure | str]]
"""Yields findings; a text is the reason why there is nothing to check."""


def findings_file(folder: Path, group: str) -> Path:
    """File into which a group writes its findings, one JSON object a line."""
    return folder / f"{group}.findings"


def journal_file(folder: Path, group: str) -> Path:
    """File that holds the last call of a group."""
    return folder / f"{group}.journal"


def stderr_file(folder: Path, group: str) -> Path:
    """File with the standard error of a group."""
    return folder / f"{group}.stderr"


def work_on(group: str, folder: Path, fmu: str) -> None:
    """Run `group` on the FMU unpacked in folder `fmu`; its files go into `folder`."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(stderr_file(folder, group), os.O_WRONLY | os.O_CREAT), 2)
    with findings_file(folder, group).open("w", encoding="utf-8") as file:

        def tell(told: dict[str, object]) -> None:
            file.write(json.dumps(told) + "\n")
            file.flush()

        try:
            _work_on(group, folder, Path(fmu), tell)
        except Exception as error:  # noqa: BLE001  of a check: not to be laid at the FMU's door
            tell({"failed": Failure.of(error).error})
        tell(ENDED)


def _work_on(
    group: str, folder: Path, fmu: Path, tell: Callable[[dict[str, object]], None]
) -> None:
    check: Check = import_module(f"{PACKAGE}.{MODULES[group]}").check
    subject = FmuUnderTest.read(fmu)
    version = subject.raw.fmiVersion
    facts = Facts()
    if (folder / FACTS).exists():
        known = json.loads((folder / FACTS).read_text())
        facts = Facts(known["amplitude"], tuple(known["works"]))
    library = Library(subject, Journal(journal_file(folder, group)))
    context = Context(subject, library, facts, folder)
    try:
        for found in check(context):
            if isinstance(found, Facts):
                (folder / FACTS).write_text(json.dumps(asdict(found)))
            elif isinstance(found, Failure):
                tell({"failed": found.error})
            elif isinstance(found, str):
                tell({"skipped": found})
            else:
                tell(asdict(found.of(version)))
    except RefusedError as error:
        tell(asdict(refused(group, error).of(version)))
    if library.overruns:
        functions = ", ".join(sorted(set(library.overruns)))
        message = f"wrote behind the end of the array it was given: {functions}"
        basis = "FMI 2.0.4, section 2.1.7"
        tell(asdict(Finding("memory.overrun", "error", message, basis).of(version)))
