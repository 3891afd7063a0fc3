"""pyM4E, the program of the paper, in an environment of its own (it conflicts with ours)."""

from __future__ import annotations

import dataclasses
import functools
import json
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmark.engine import Prepared, UnavailableError
from benchmark.native_code import ROOT
from benchmark.systems import GRAVITY, System

PYTHON = ROOT / ".venv-bench-pym4e" / "bin" / "python"


class Worker:
    """A process of pyM4E with one system; `ask` raises UnavailableError where it fails."""

    def __init__(self) -> None:
        if not PYTHON.exists():
            raise UnavailableError(f"pyM4E's environment {PYTHON.parents[1].name} is missing")
        self.process = subprocess.Popen(
            [str(PYTHON), str(Path(__file__).with_name("pym4e_worker.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, "MPLBACKEND": "Agg"},
        )

    def ask(self, what: str, *arguments: object) -> Any:
        """The answer of a method of the worker."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        try:
            print(json.dumps({"do": what, "with": arguments}), file=self.process.stdin, flush=True)
        except BrokenPipeError as error:
            raise UnavailableError("pyM4E's process has ended") from error
        line = self.process.stdout.readline()
        if not line:
            raise UnavailableError(f"pyM4E's process has ended during {what}")
        answer = json.loads(line)
        if "error" in answer:
            raise UnavailableError(f"pyM4E: {answer['error']}")
        return answer["value"]

    def prepare(self, system: System) -> dict[str, float]:
        """Build the system; CPU time `preparation` [s] and `memory` [bytes] beyond the imports."""
        plain: dict[str, Any] = {**dataclasses.asdict(system), "gravity": GRAVITY}
        for torsion, row in zip(system.torsions, plain["torsions"], strict=True):
            row["against"] = system.angle_index(system.links[torsion.link].parent)
        return self.ask("prepare", plain)

    def close(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


@functools.cache
def worker_of(system: System) -> tuple[Worker, dict[str, float]]:
    """A worker with the system, and what building it took: see `Worker.prepare`."""
    worker = Worker()
    return worker, worker.prepare(system)


class PyM4E:
    name = "pyM4E"
    largest = 20
    largest_with_loads = 6

    def prepare(self, system: System) -> Prepared:
        worker, built = worker_of(system)

        def accelerations(q: Sequence[float], u: Sequence[float]) -> Sequence[float]:
            return worker.ask("accelerations", list(q), list(u))

        def batch(calls: int) -> float:
            return worker.ask("batch", calls)

        return Prepared(accelerations, batch, built["preparation"])
