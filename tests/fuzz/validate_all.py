"""Validate the FMUs of all examples and of the library: native of FMI 2.0 and 3.0, and Python.

Run it as ``python tests/fuzz/validate_all.py FOLDER [NAME…]``; the FMUs are built in FOLDER, those
of the NAMEs only, if there are any. It takes some minutes and ends with exit code 1 if there is an
error or a warning.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from m4e_fmi.cosim import Kind, load_system
from m4e_fmi.cosim.system.component import kind_of
from m4e_fmi.fmu import PythonSource, build_fmu, validate_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.report import validation_text

EXAMPLES = Path(__file__).parents[2] / "examples"
OWN_PACKAGE = "hydraulic_pto"
"""An example whose kinds are there when it is installed; its own test validates them."""
KINDS: dict[str, dict[str, Any]] = {
    "native_2": {"native": True},
    "native_3": {"native": True, "fmi": "3"},
    "python": {},
}


def sources() -> Iterator[tuple[str, Program | PythonSource]]:
    """Sources of FMUs, each by a name of its own."""
    for path in sorted(EXAMPLES.rglob("*.model.yaml")):
        yield f"{path.parent.name}.{path.name.split('.')[0]}", model_program(load_model(path))
    for path in sorted(EXAMPLES.rglob("system.yaml")):
        if path.parent.name == OWN_PACKAGE:
            continue
        system = load_system(path)
        for component in system.components:
            kind = component.source
            if isinstance(kind, Kind):
                made = kind_of(kind.name).build(
                    kind.config, name=component.name, folder=system.folder, progress=lambda _: None
                )
                yield f"{path.parent.name}.{component.name}", made


def files(folder: Path, names: list[str]) -> Iterator[Path]:
    for name, source in sources():
        for kind, options in KINDS.items():
            wanted = isinstance(source, Program) or kind == "python"
            if wanted and (not names or name in names):
                yield build_fmu(source, folder / kind / f"{name}.fmu", **options)


def main(folder: Path, names: list[str]) -> int:
    wrong, notes, checked = 0, Counter[str](), 0
    for path in files(folder, names):
        began = time.perf_counter()
        report = validate_fmu(path)
        print(f"{time.perf_counter() - began:5.1f} s  {path}", flush=True)
        checked += 1
        notes.update(finding.id for finding in report.of_severity("note"))
        if report.of_severity("error", "warning"):
            wrong += 1
            print(validation_text(report), flush=True)
    print("notes:", ", ".join(f"{count} {name}" for name, count in sorted(notes.items())))
    print(f"{wrong} of {checked} with errors or warnings")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
