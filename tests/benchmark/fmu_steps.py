"""What a step of a native FMU costs, beside NumPy: `python -m benchmark.fmu_steps`.

A pendulum of ten rods, H = 1 ms, CPU time, the best of several runs. Through ctypes with arguments
prepared once, and from a C host. A step of `rk45` has 7 right-hand sides, of `dop853` 13. The
other side is four right-hand sides of SymPy's Kane equations, lambdified with common
subexpressions for NumPy, with nothing else around them.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import fmpy
from fmpy import fmi2

from benchmark.engines.ours import model_of
from benchmark.engines.sympy_kane import SympyKane
from benchmark.systems import pendulum
from m4e_fmi.fmu import build_fmu
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.runtime.compiler import SHELL_SOURCES, compiler

JOINTS, H, STEPS, RUNS = 10, 1e-3, 2000, 7
HOST = Path(__file__).parent / "native" / "fmu_steps.c"


def main() -> None:
    system = pendulum(JOINTS)
    program = model_program(model_of(system))
    numpy_cost = _numpy_right_hand_side(system)
    print(f"{JOINTS} joints, H = {H * 1e3:g} ms; µs of CPU per step")
    print(f"  four right-hand sides, lambdified     {4e6 * numpy_cost:10.1f}")
    with tempfile.TemporaryDirectory() as folder:
        for method, evaluations in (("rk45", 7), ("dop853", 13)):
            path = Path(folder) / f"{method}.fmu"
            build_fmu(program, path, native=True, method=method)
            unpacked = Path(fmpy.extract(str(path), str(path.with_suffix(""))))
            through_ctypes, from_c = _ctypes_step(unpacked), _c_step(unpacked, Path(folder))
            for how, cost in (("ctypes", through_ctypes), ("C host", from_c)):
                ratio = 4 * numpy_cost / cost
                text = f"{method}, {evaluations} right-hand sides, {how}"
                print(f"  native, {text:30}{1e6 * cost:10.2f}   1/{ratio:.0f}")
        native, python = (_export(program, Path(folder), native=native) for native in (True, False))
    print(f"export: native {1e3 * native:.0f} ms, pythonfmu {1e3 * python:.0f} ms")


def _numpy_right_hand_side(system: Any) -> float:
    """CPU seconds of one evaluation, the best of several batches."""
    batch = SympyKane().prepare(system).batch
    return min(batch(50) for _ in range(RUNS)) / 50


def _export(program: Program, folder: Path, *, native: bool) -> float:
    """CPU seconds of an export; the first one, which may compile, is not counted."""
    costs = []
    for _ in range(RUNS):
        began = time.process_time()
        build_fmu(program, folder / "exported.fmu", native=native)
        costs.append(time.process_time() - began)
    return min(costs[1:])


def _ctypes_step(unpacked: Path) -> float:
    description: Any = fmpy.read_model_description(str(unpacked))
    fmu = fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(unpacked),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    fmu.instantiate()
    prototype = ctypes.CFUNCTYPE(
        ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int
    )
    step = prototype(("fmi2DoStep", fmu.dll))
    best = float("inf")
    for _ in range(RUNS):
        fmu.setupExperiment()
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        component: Any = fmu.component
        times = [k * H for k in range(STEPS)]
        began = time.process_time()
        for t in times:
            if step(component, t, H, 1):
                raise RuntimeError("a step failed")
        best = min(best, (time.process_time() - began) / STEPS)
        fmu.reset()
    fmu.freeInstance()
    return best


def _c_step(unpacked: Path, folder: Path) -> float:
    host = folder / "host"
    command = [*(compiler() or ["cc"]), "-O2", "-I", str(SHELL_SOURCES), str(HOST), "-o", str(host)]
    subprocess.run([*command, "-ldl"], check=True)
    description: Any = fmpy.read_model_description(str(unpacked))
    [library] = (unpacked / "binaries" / "linux64").iterdir()
    words = [str(library), (unpacked / "resources").as_uri(), description.guid, str(STEPS)]
    return float(subprocess.run([str(host), *words], check=True, capture_output=True).stdout)


if __name__ == "__main__":
    main()
