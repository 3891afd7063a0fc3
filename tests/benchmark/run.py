"""Measures everything in one run: `python -m benchmark.run [--full] [--quick]` from tests/."""

from __future__ import annotations

import argparse
import datetime
import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

for _variable in ("OMP", "OPENBLAS", "MKL"):  # before NumPy is loaded, here and in children
    os.environ[f"{_variable}_NUM_THREADS"] = "1"

from benchmark import fmu_steps, master_loop, measure, process  # noqa: E402
from benchmark.engine import UnavailableError  # noqa: E402
from benchmark.engines.registry import engines, versions  # noqa: E402
from benchmark.native_code import ROOT  # noqa: E402
from benchmark.report import write_report  # noqa: E402
from benchmark.systems import pendulum, tree  # noqa: E402

RESULT = ROOT / "build" / "benchmark.json"
SIZES = (1, 10, 20, 60, 100, 200)
SYMBOLIC_SIZES = (1, 10, 20, 60, 200, 500)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--full", action="store_true", help="pyM4E as far as n = 60: half an hour")
    parser.add_argument("--quick", action="store_true", help="n up to 20 only")
    options = parser.parse_args()
    sizes = [n for n in SIZES if n <= 20 or not options.quick]
    middle = 20 if options.quick else 60
    missing: list[str] = []
    began = time.perf_counter()

    def log(text: str) -> None:
        if text not in missing:
            missing.append(text)
            print(f"  not measured: {text}")

    def step(title: str, work: Callable[[], Any]) -> Any:
        print(f"{time.perf_counter() - began:6.0f} s  {title}", flush=True)
        try:
            return work()
        except (RuntimeError, UnavailableError) as error:
            log(f"{title}: {error}")
            return None

    contestants = engines()
    if options.full:
        for engine in contestants:
            if engine.name == "pyM4E":
                engine.largest = 60
    compared = {
        n: step(
            f"right-hand side, n = {n}", lambda n=n: measure.compared(pendulum(n), contestants, log)
        )
        for n in sizes
    }
    symbolic = [n for n in SYMBOLIC_SIZES if n <= 20 or not options.quick]
    pym4e_sizes = (1, 10, 60) if options.full else (1, 10)
    result = {
        "when": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "machine": process.machine(),
        "versions": versions(),
        "right_hand_side": {str(n): one.seconds for n, one in compared.items()},
        "tree": step(
            "right-hand side, random tree",
            lambda: measure.compared(tree(), contestants, log).seconds,
        ),
        "spiderfloat": step("SpiderFLOAT", measure.spiderfloats),
        "integration": {
            str(n): step(
                f"30 s, n = {n}",
                lambda n=n: measure.integrations(n, log),
            )
            for n in (1, 10, middle)
        },
        "preparation": step("model to program", lambda: measure.preparations(symbolic, compared)),
        "middle": middle,
        "derivatives": step("derivatives", lambda: measure.derivatives(middle, log)),
        "ensemble": step("ensemble", lambda: measure.ensembles(middle, log)),
        "accuracy": compared[middle].error,
        "memory": step("memory", lambda: process.memory(middle)),
        "process": step("whole process", lambda: process.whole_process(middle)),
        "fmu_steps": step("steps of FMUs", fmu_steps.measured),
        "macro_steps": (macro := step("macro steps", master_loop.measured)),
        "missing": missing,
    }
    for text in (macro or {}).get("missing", ()):
        log(text)
    _write(result)
    for n in pym4e_sizes:  # the slowest last, when all else is on the disk
        found = step(f"30 s, n = {n}, pyM4E", lambda n=n: measure.pym4e_integration(n))
        result["integration"][str(n)] |= {"pyM4E, RK45": found} if found else {}
    _write(result)


def _write(result: dict[str, Any]) -> None:
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(result, indent=1), "utf-8")
    written = write_report(result, ROOT / "docs")
    print("wrote", ", ".join(str(path.relative_to(ROOT)) for path in (RESULT, *written)))


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "tests"))
    main()
