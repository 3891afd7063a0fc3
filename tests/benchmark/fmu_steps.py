"""What a step of a native FMU costs, beside NumPy: `python -m benchmark.fmu_steps`.

A pendulum of ten rods, H = 1 ms, CPU time of doStep, the best of several runs: of native FMUs
through ctypes with arguments prepared once, and from a C host. Beside them a Python FMU, as it is
made by hand: SymPy's Kane equations, lambdified with common subexpressions for NumPy, four of them
in a classical Runge-Kutta step, stepped by FMPy. Both must first arrive at the same states.
"""

from __future__ import annotations

import ctypes
import inspect
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy import fmi2

from benchmark.engines.ours import program_of
from benchmark.engines.sympy_kane import GRAVITY, kane
from benchmark.systems import System, pendulum
from m4e_fmi.fmu import FmuVariable, ModelDescription, PythonSource, build_fmu
from m4e_fmi.program import Program
from m4e_fmi.runtime.compiler import compiler

JOINTS, H, STEPS, RUNS, QUICK_RUNS = 10, 1e-3, 2000, 7, 50
FEW = 100  # steps of the slow one, and to the comparison of states
METHODS = {"rk4": 4, "rk45": 7, "dop853": 13}
"""Right-hand sides of one step."""
FMI_HEADERS = files("fmpy") / "c-code"
HOST = Path(__file__).parent / "native" / "fmu_steps.c"
AGREEMENT = 1e-11  # rounding, 1e-16, over a hundred steps of fast links


def _native(method: str, evaluations: int, host: str) -> str:
    return f"native {method}, {evaluations} right-hand sides, {host}"


PYTHON = "lambdified, 4 right-hand sides, FMPy"
CTYPES, C_HOST = (_native("rk4", METHODS["rk4"], host) for host in ("ctypes", "C"))


def measured() -> dict[str, Any]:
    """CPU seconds of a step by kind of FMU and host (`steps`), of an export (`export`)."""
    system = pendulum(JOINTS)
    program = program_of(system)
    steps: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lambdified = build_fmu(_lambdified(system, folder), folder / "numpy.fmu")
        with _opened(lambdified) as (fmu, _):
            steps[PYTHON] = _python_step(fmu)
            expected = _states_after(fmu, lambdified)
        for method, evaluations in METHODS.items():
            path = folder / f"{method}.fmu"
            build_fmu(program, path, native=True, method=method, step_size=H)
            with _opened(path) as (fmu, unpacked):
                steps[_native(method, evaluations, "ctypes")] = _ctypes_step(fmu)
                steps[_native(method, evaluations, "C")] = _c_step(unpacked, folder)
                apart = np.abs(_states_after(fmu, path) - expected).max()
                if method == "rk4" and not apart < AGREEMENT * np.abs(expected).max():
                    raise RuntimeError(f"the FMUs disagree by {apart:.1e}")
        kinds = {"native": True, "pythonfmu": False}
        export = {k: _export(program, folder, native=native) for k, native in kinds.items()}
    return {"steps": steps, "export": export}


def main() -> None:
    result = measured()
    print(f"{JOINTS} joints, H = {H * 1e3:g} ms; µs of CPU per step")
    slow = result["steps"][PYTHON]
    for name, cost in result["steps"].items():
        print(f"  {name:44}{1e6 * cost:10.2f}   1/{slow / cost:.0f}")
    print("export, ms: ", {k: round(1e3 * cost) for k, cost in result["export"].items()})


def _lambdified(system: System, folder: Path) -> PythonSource:
    """The Python FMU that somebody would write who has SymPy's equations of motion."""
    import sympy

    method, q, u = kane(system, GRAVITY)
    names = sympy.symbols(f"x:{2 * system.size}")
    exchange = dict(zip([*q, *u], names, strict=True))
    matrices = [m.xreplace(exchange) for m in (method.mass_matrix, method.forcing)]
    function: Callable[..., Any] = sympy.lambdify([names], matrices, cse=True)
    head = f"from numpy import array, cos, sin\n\nSIZE = {system.size}\n\n\n"
    equations = folder / "equations.py"
    equations.write_text(head + inspect.getsource(function), "utf-8")
    start = [*system.q, *system.u]
    slave = Path(__file__).with_name("numpy_slave.py")
    return PythonSource(
        description=ModelDescription(
            "lambdified",
            "pendulum",
            tuple(
                FmuVariable(f"x{k}", "1", "state", causality="output", initial="exact", start=x)
                for k, x in enumerate(start)
            ),
        ),
        slave="numpy_slave:NumpySlave",
        modules={slave.name: slave, equations.name: equations},
        data={},
    )


@contextmanager
def _opened(path: Path) -> Iterator[tuple[fmi2.FMU2Slave, Path]]:
    """An instance before its setup, and the folder it lies in."""
    description: Any = fmpy.read_model_description(str(path))
    unpacked = Path(fmpy.extract(str(path), str(path.with_suffix(""))))
    fmu = fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(unpacked),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    fmu.instantiate()
    yield fmu, unpacked
    fmu.freeInstance()


def _begin(fmu: fmi2.FMU2Slave) -> None:
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()


def _states_after(fmu: fmi2.FMU2Slave, path: Path) -> np.ndarray:
    """Coordinates, then speeds, after a few steps; the instance is reset before."""
    description: Any = fmpy.read_model_description(str(path))
    references = {v.name: v.valueReference for v in description.modelVariables}
    names = [f"x{k}" for k in range(2 * JOINTS)]
    if names[0] not in references:
        names = [f"joint.joint{k}.{letter}" for letter in "qu" for k in range(JOINTS)]
    fmu.reset()
    _begin(fmu)
    for k in range(FEW):
        fmu.doStep(k * H, H)
    return np.array(fmu.getReal([references[name] for name in names]))


def _python_step(fmu: fmi2.FMU2Slave) -> float:
    """CPU seconds of FMPy's doStep."""
    best = float("inf")
    _begin(fmu)
    for run in range(RUNS):
        times = [(FEW * run + k) * H for k in range(FEW)]
        began = time.process_time()
        for t in times:
            fmu.doStep(t, H)
        best = min(best, (time.process_time() - began) / FEW)
    return best


def _ctypes_step(fmu: fmi2.FMU2Slave) -> float:
    """CPU seconds of doStep with prepared arguments."""
    prototype = ctypes.CFUNCTYPE(
        ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int
    )
    step = prototype(("fmi2DoStep", fmu.dll))
    best = float("inf")
    for _ in range(QUICK_RUNS):
        _begin(fmu)
        component: Any = fmu.component
        times = [k * H for k in range(STEPS)]
        began = time.process_time()
        for t in times:
            if step(component, t, H, 1):
                raise RuntimeError("a step failed")
        best = min(best, (time.process_time() - began) / STEPS)
        fmu.reset()
    return best


def _c_step(unpacked: Path, folder: Path) -> float:
    """CPU seconds of doStep from C."""
    host = folder / "host"
    command = [*(compiler() or ["cc"]), "-O2", "-I", str(FMI_HEADERS), str(HOST), "-o", str(host)]
    subprocess.run([*command, "-ldl"], check=True)
    description: Any = fmpy.read_model_description(str(unpacked))
    [library] = (unpacked / "binaries" / "linux64").iterdir()
    words = [str(library), (unpacked / "resources").as_uri(), description.guid, str(STEPS)]
    return float(subprocess.run([str(host), *words], check=True, capture_output=True).stdout)


def _export(program: Program, folder: Path, *, native: bool) -> float:
    """CPU seconds of an export; the first one, which may compile, is not counted."""
    costs = []
    for _ in range(RUNS):
        began = time.process_time()
        build_fmu(program, folder / "exported.fmu", native=native)
        costs.append(time.process_time() - began)
    return min(costs[1:])


if __name__ == "__main__":
    main()
