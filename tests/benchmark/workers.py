"""Price of a worker: a step with ten inputs and outputs, in this process and in another.

``python tests/benchmark/workers.py`` prints the medians [µs], and how much longer two components
need than one when each step takes a millisecond, side by side in two workers.
"""

from __future__ import annotations

import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from support.c_fmus.build import build

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run
from m4e_fmi.cosim.exchange.instance import Instance
from m4e_fmi.cosim.exchange.loading.binary import Files, opened_binary
from m4e_fmi.cosim.exchange.operations import DoStep, Get, Set
from m4e_fmi.cosim.exchange.step_loop import Schedule
from m4e_fmi.fmu.importer.reading import read_description
from m4e_fmi.fmu.importer.worker import Host

STEPS = 20_000


def step_time(fmu: Path, host: Host | None) -> float:
    """Median time [µs] of a step with its values."""
    description = read_description(fmu)
    names = tuple(f"u{k}" for k in range(10)), tuple(f"y{k}" for k in range(10))
    with (
        closing(Files(description)) as files,
        opened_binary(description, files, origin="wide", host=host) as binary,
        Instance("wide", description, binary) as instance,
    ):
        instance.setup(start=0.0, stop=1.0, tolerance=None)
        instance.enter_initialization()
        instance.exit_initialization()
        inputs, outputs = np.ones(10), np.zeros(10)
        schedule = Schedule(
            [Set(instance, names[0], inputs), DoStep(instance), Get(instance, names[1], outputs)]
        )
        times = []
        for k in range(STEPS):
            begin = time.perf_counter()
            schedule.run(1e-3 * k, 1e-3)
            times.append(time.perf_counter() - begin)
        assert np.allclose(outputs, 1e-3 * STEPS)
    return 1e6 * float(np.median(times))


def side_by_side(fmu: Path) -> float:
    """Wall time of one component over that of two, times two; steps of 1 ms each."""
    walls = []
    for count in (1, 2):
        start = {"what": 3, "when": 0.0, "pause": 1e-3}
        components = tuple(
            Component(f"c{k}", FmuFile(fmu), start, process="own") for k in range(count)
        )
        system = System("two", components, (), Simulation(2.0, 1e-3, "jacobi"))
        walls.append(run(prepare(system)).wall_time)
    return 2 * walls[0] / walls[1]


def main() -> None:
    folder = Path(tempfile.mkdtemp())
    fmu = build("wide", folder)
    here, apart = step_time(fmu, None), step_time(fmu, Host())
    print(f"step in this process {here:.1f} µs, in a worker {apart:.1f} µs: +{apart - here:.1f} µs")
    print(f"two workers, steps of 1 ms: {side_by_side(build('vandal', folder)):.2f} x")


if __name__ == "__main__":
    main()
