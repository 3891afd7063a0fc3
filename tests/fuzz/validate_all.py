"""Validate the FMUs of all examples and of the library, native and Python.

Run it as ``python tests/fuzz/validate_all.py FOLDER``; the FMUs are built in FOLDER. It takes a
few minutes and ends with exit code 1 if there is an error or a warning.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

from m4e_fmi.cosim import System, fmu_files
from m4e_fmi.fmu import build_fmu, validate_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.report import validation_text

EXAMPLES = Path(__file__).parents[2] / "examples"


def files(folder: Path) -> Iterator[Path]:
    for native in (True, False):
        here = folder / ("native" if native else "python")
        here.mkdir(parents=True, exist_ok=True)
        for model in sorted(EXAMPLES.rglob("*.model.yaml")):
            program = model_program(load_model(model))
            yield build_fmu(program, here / f"{program.name}.fmu", native=native)
        for system in sorted(EXAMPLES.rglob("system.yaml")):
            where = here / system.parent.name
            yield from fmu_files(System.load(system), where, native=native).values()


def main(folder: Path) -> int:
    wrong = 0
    for path in files(folder):
        began = time.perf_counter()
        report = validate_fmu(path)
        print(f"{time.perf_counter() - began:5.1f} s  {path}", flush=True)
        if report.of_severity("error", "warning"):
            wrong += 1
            print(validation_text(report), flush=True)
    print(f"{wrong} with errors or warnings")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
