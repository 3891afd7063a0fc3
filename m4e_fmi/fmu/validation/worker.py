"""The process that runs one group of checks: FMU code may end it at any time.

Started with the name of the group and two folders; what it finds goes line by line into a file of
the first, the calls it makes into another. Standard output belongs to the FMU.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

from m4e_fmi.fmu.validation.bench import Bench, Facts
from m4e_fmi.fmu.validation.findings import Finding
from m4e_fmi.fmu.validation.journal import Journal
from m4e_fmi.fmu.validation.probe import Library, RefusedError
from m4e_fmi.fmu.validation.starting import refused
from m4e_fmi.fmu.validation.subject import Subject

FACTS = "facts.json"
MODULES = {
    "start": "starting",
    "values": "values",
    "dependencies": "dependencies",
    "derivatives": "derivatives",
    "directional": "directional",
    "state": "states",
    "state_elsewhere": "elsewhere",
    "instances": "instances",
    "solution": "solutions",
    "phases": "phases",
    "parameters": "parameters",
}
"""Group → module with its `check`, in the order in which they are run."""

Check = Callable[[Bench], Iterator[Finding | Facts | str]]
"""Yields findings; a text is the reason why there is nothing to check."""


def findings_file(folder: Path, group: str) -> Path:
    return folder / f"{group}.findings"


def journal_file(folder: Path, group: str) -> Path:
    return folder / f"{group}.journal"


def main(group: str, work: str, fmu: str) -> None:
    """Run `group` on the FMU unpacked in folder `fmu`; its files go into folder `work`."""
    folder = Path(work)
    check: Check = import_module(f"m4e_fmi.fmu.validation.{MODULES[group]}").check
    subject = Subject.read(Path(fmu))
    facts = Facts()
    if (folder / FACTS).exists():
        known = json.loads((folder / FACTS).read_text())
        facts = Facts(known["amplitude"], tuple(known["works"]))
    library = Library(subject, Journal(journal_file(folder, group)))
    bench = Bench(subject, library, facts, folder)
    with findings_file(folder, group).open("w", encoding="utf-8") as file:

        def tell(finding: Finding | str) -> None:
            told = {"skipped": finding} if isinstance(finding, str) else asdict(finding)
            file.write(json.dumps(told) + "\n")
            file.flush()

        try:
            for found in check(bench):
                if isinstance(found, Facts):
                    (folder / FACTS).write_text(json.dumps(asdict(found)))
                else:
                    tell(found)
        except RefusedError as error:
            tell(refused(group, error))
        if library.overruns:
            functions = ", ".join(sorted(set(library.overruns)))
            message = f"wrote behind the end of the array it was given: {functions}"
            tell(Finding("memory.overrun", "error", message, "FMI 2.0.4, section 2.1.7"))
