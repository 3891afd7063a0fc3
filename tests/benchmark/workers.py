"""Price of a process of its own for an FMU, beside that of a peer.

``../.venv-bench/bin/python -m benchmark.workers``, from tests/, prints what a component and step
take here, in another process, and in both ways with Ecos, whose proxies are processes, too; then
how much sooner two components have made their steps in two processes than one after the other.

Two components feed each other with ten Reals. All times are wall times, the median of many runs.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmark.master_loop import TESTS, Coupled
from benchmark.masters import Advance, ecospy

sys.path.insert(0, str(TESTS))
from support.c_fmus.build import build

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run
from m4e_fmi.cosim.run.run import RunOptions
from m4e_fmi.cosim.run.running import running

RUNS, SHORT, LONG = 15, 500, 2500
WORK = 1e-3
"""CPU seconds of a step of the components that are to step side by side."""

Timed = Callable[[int], float]
"""Wall seconds of so many steps."""


def ours(process: str) -> Callable[[Coupled, Path], Timed]:
    """This package's master, with all components in one process or each in one of its own."""

    def make(coupled: Coupled, folder: Path) -> Timed:
        del folder
        ready = {n: prepare(coupled.system(n, "jacobi", process)) for n in (SHORT, LONG)}

        def advance(steps: int) -> float:
            with running(ready[steps], RunOptions()) as made:
                began = time.perf_counter()
                made.finish()
                return time.perf_counter() - began

        return advance

    return make


def timed(advance: Advance) -> Timed:
    """Wall seconds of so many steps."""

    def seconds(steps: int) -> float:
        began = time.perf_counter()
        advance(steps)
        return time.perf_counter() - began

    return seconds


MASTERS = {
    "m4e_fmi, here": ours("here"),
    "m4e_fmi, processes": ours("own"),
    "Ecos, here": lambda coupled, folder: timed(ecospy(coupled, folder)),
    "Ecos, proxies": lambda coupled, folder: timed(ecospy(coupled, folder, proxies=True)),
}


def step_time(who: str) -> float:
    """Wall time [µs] of a component and step."""
    with tempfile.TemporaryDirectory() as name:
        fmu = build("wide", Path(name))
        outputs, inputs = (tuple(f"{letter}{k}" for k in range(10)) for letter in "yu")
        coupled = Coupled(fmu, 2, outputs, inputs, closed=True)
        advance = MASTERS[who](coupled, Path(name))
        advance(SHORT)
        spent = [advance(LONG) - advance(SHORT) for _ in range(RUNS)]
    return 1e6 * statistics.median(spent) / (LONG - SHORT) / coupled.count


def in_a_process(who: str) -> str:
    """`step_time` by a process of its own: some peers crash when they end."""
    command = [sys.executable, "-m", "benchmark.workers", who]
    with tempfile.TemporaryDirectory() as name:  # where Ecos writes its logs
        paths = os.pathsep.join([str(TESTS), *sys.path])
        ran = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            cwd=name,
            env=os.environ | {"PYTHONPATH": paths},
        )
    figures, why = ran.stdout.split(), ran.stderr.strip().splitlines()
    return f"{float(figures[-1]):.1f} µs" if figures else f"could not be measured: {why[-1:]}"


def side_by_side(count: int) -> float:
    """Wall time of two components one after the other over that in two processes."""
    with tempfile.TemporaryDirectory() as name:
        fmu = FmuFile(build("busy", Path(name)))
        walls: dict[str, list[float]] = {"here": [], "own": []}
        for process in [*walls] * count:
            parts = tuple(
                Component(f"c{k}", fmu, {"work": WORK}, process=process) for k in range(2)
            )
            system = System("two", parts, (), Simulation(1.0, 1e-3, "jacobi"))
            walls[process].append(run(prepare(system)).wall_time)
    here, own = (statistics.median(found) for found in walls.values())
    return here / own


def main(arguments: Sequence[str]) -> None:
    """Print one figure, if a master is named, or all."""
    if arguments:
        print(step_time(arguments[0]))
        return
    for who in MASTERS:
        print(f"{who}: {in_a_process(who)}", flush=True)
    print(f"two components, steps of 1 ms, in two processes: {side_by_side(5):.2f} x as fast")


if __name__ == "__main__":
    main(sys.argv[1:])
