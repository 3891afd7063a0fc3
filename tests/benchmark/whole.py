"""A whole system as one program beside the coupled run: the moored buoy, its lines left out.

Processor time per 0.1 s of simulated time and the error of the float's motion, over its range,
against a solution at 1e-12; the time to compose many parts; a step of one FMU of the whole.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.cosim import System, load_system, prepare, run, system_program
from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Connection, Program, Recorder, Variable, compose
from m4e_fmi.simulate import Simulation, simulate

BUOY = Path(__file__).parents[2] / "examples" / "moored_buoy" / "system.yaml"
NAMES = [f"buoy.body.float.{name}" for name in ("x", "z", "theta")]
STOP, STEP = 200.0, 0.1
RUNS = 3


def buoy() -> System:
    """The moored buoy without its lines."""
    system = load_system(BUOY)
    return replace(
        system,
        components=tuple(c for c in system.components if c.name != "mooring"),
        connections=tuple(text for text in system.connections if "mooring" not in text),
    ).changed(stop_time=STOP, step_size=STEP, output_interval=STEP)


def cpu(work: Callable[[], Any]) -> tuple[float, Any]:
    """Least processor seconds of a few runs, and what the last returned."""
    times, results = [], []
    for _ in range(RUNS):
        began = time.process_time()
        results.append(work())
        times.append(time.process_time() - began)
    return min(times), results[-1]


def error(values: Any, exact: Simulation) -> float:
    """Largest difference of the motions, over their ranges."""
    return max(
        float(np.abs(np.asarray(values[name]) - exact[name]).max() / np.ptp(exact[name]))
        for name in NAMES
    )


def chain(count: int) -> tuple[dict[str, Program], list[Connection]]:
    """First-order lags, one after the other."""
    parts = {}
    for k in range(count):
        r = Recorder("lag", "")
        u = r.input(Variable("u", "1", ""))
        x = r.state(Variable("x", "1", ""))
        r.rate("x", u - x)
        r.output(Variable("y", "1", ""), x + 0.5 * u)
        parts[f"p{k}"] = r.program()
    return parts, [Connection((f"p{k}", "y"), (f"p{k + 1}", "u")) for k in range(count - 1)]


def fmu_step(program: Program, folder: Path, method: str) -> float:
    """Processor seconds of a step of 0.1 s of one native FMU."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    path = build_fmu(program, folder / "whole.fmu", native=True, method=method)
    described = fmpy.read_model_description(str(path))
    assert described.coSimulation is not None
    fmu = FMU2Slave(
        guid=described.guid,
        unzipDirectory=fmpy.extract(str(path)),
        modelIdentifier=described.coSimulation.modelIdentifier,
        instanceName="whole",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    count = int(STOP / STEP)
    began = time.process_time()
    for k in range(count):
        fmu.doStep(k * STEP, STEP)
    return (time.process_time() - began) / count


def main() -> None:
    steps = STOP / STEP
    system = buoy()
    program = system_program(system)
    exact = simulate(program, stop_time=STOP, output_interval=STEP, tolerance=1e-12)
    print(
        f"moored buoy without lines: {len(program.states)} states, {len(system.components)} parts"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for algorithm in ("gauss_seidel", "corrector", "implicit"):
            ready = prepare(system.changed(algorithm=algorithm), build_directory=folder / "build")
            spent, _ = cpu(lambda ready=ready: run(ready))
            outcome = run(ready, results=folder / "r.nc")
            off = error(outcome.results().series, exact)
            print(f"  coupled, {algorithm:22} {1e6 * spent / steps:8.1f} us, error {off:.1e}")
        for method, tolerance in (
            ("rk45", 1e-6),
            ("rk45", 1e-8),
            ("dop853", 1e-6),
            ("dop853", 1e-8),
        ):
            given: dict[str, Any] = {"stop_time": STOP, "method": method, "tolerance": tolerance}
            spent, found = cpu(lambda given=given: simulate(program, output_interval=STEP, **given))
            off = error(found, exact)
            what = f"{method}, {tolerance:g}"
            print(f"  one program, {what:18} {1e6 * spent / steps:8.1f} us, error {off:.1e}")
        for method in ("rk45", "dop853"):
            print(f"  one FMU, {method:22} {1e6 * fmu_step(program, folder, method):8.1f} us")
    for count in (50, 100, 200, 400):
        made = chain(count)
        spent, _ = cpu(lambda made=made: compose("chain", *made))
        print(f"composition of {count} parts: {1e3 * spent:.1f} ms")


if __name__ == "__main__":
    main()
