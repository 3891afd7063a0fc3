"""Other masters, each as its documentation shows it: `make(system, folder)` → advance(steps).

`advance` goes on by so many macro steps. ImportError or OSError where a package is not there.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from benchmark.master_loop import Coupled

H = 0.01
Advance = Callable[[int], object]


def _instances(system: Coupled, folder: Path) -> tuple[list[Any], dict[str, int]]:
    """Initialised FMPy instances, and the value references of their variables."""
    import fmpy
    from fmpy import fmi2

    description: Any = fmpy.read_model_description(str(system.fmu))
    unpacked = folder / f"{system.fmu.stem}_unpacked"
    fmpy.extract(str(system.fmu), str(unpacked))
    found = []
    for k in range(system.count):
        fmu = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(unpacked),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=f"c{k}",
        )
        fmu.instantiate()
        fmu.setupExperiment()
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        found.append(fmu)
    return found, {v.name: v.valueReference for v in description.modelVariables}


def fmpy_lists(system: Coupled, folder: Path) -> Advance:
    """A loop over FMPy's public methods."""
    fmus, references = _instances(system, folder)
    outputs = [references[name] for name in system.outputs]
    inputs = [references[name] for name in system.inputs]
    links = [(a, b) for a, y, b, _ in system.links if y == system.outputs[0]]
    steps = count()

    def advance(n: int) -> None:
        for _ in range(n):
            t = next(steps) * H
            for fmu in fmus:
                fmu.doStep(t, H)
            for a, b in links:
                fmus[b].setReal(inputs, fmus[a].getReal(outputs))

    return advance


def fmpy_prepared(system: Coupled, folder: Path) -> Advance:
    """A loop over the functions that FMPy has loaded, with arguments prepared once."""
    fmus, references = _instances(system, folder)
    size = len(system.outputs)
    numbers = ctypes.c_uint * size
    outputs = ctypes.addressof(y := numbers(*(references[name] for name in system.outputs)))
    inputs = ctypes.addressof(u := numbers(*(references[name] for name in system.inputs)))
    kept = [y, u, values := (ctypes.c_double * size)()]
    address = ctypes.addressof(values)
    access = (ctypes.c_int, *(ctypes.c_void_p,) * 2, ctypes.c_size_t, ctypes.c_void_p)
    step = (ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int)

    def bound(name: str, types: tuple, fmu: Any) -> Any:
        return ctypes.CFUNCTYPE(*types)((name, fmu.dll))

    dos = [(bound("fmi2DoStep", step, fmu), fmu.component) for fmu in fmus]
    moves = [
        (bound("fmi2GetReal", access, fmus[a]), fmus[a].component,
         bound("fmi2SetReal", access, fmus[b]), fmus[b].component)
        for a, y_, b, _ in system.links if y_ == system.outputs[0]
    ]  # fmt: skip
    steps = count()

    def advance(n: int, _kept: list[Any] = kept) -> None:
        for _ in range(n):
            t = next(steps) * H
            for do, component in dos:
                do(component, t, H, 1)
            for get, source, set_, target in moves:
                get(source, outputs, size, address)
                set_(target, inputs, size, address)

    return advance


def fmpy_container(system: Coupled, folder: Path) -> Advance:
    """FMPy's container: a master in an FMU. Its own writer says "Real" where it reads "Float64"."""
    import fmpy
    from fmpy import fmi2
    from fmpy.container_fmu import __file__ as package

    description: Any = fmpy.read_model_description(str(system.fmu))
    references = {v.name: v.valueReference for v in description.modelVariables}
    outer = folder / f"container_{system.count}"
    stem = system.fmu.stem
    with zipfile.ZipFile(system.fmu) as archive:
        archive.extractall(outer / "resources" / stem)
    binary = Path(package).parent / "binaries" / "x86_64-linux" / "container_fmu.so"
    (outer / "binaries" / "linux64").mkdir(parents=True)
    shutil.copy(binary, outer / "binaries" / "linux64")
    part = {"fmiMajorVersion": "2", "instantiationToken": description.guid, "path": stem}
    part["modelIdentifier"] = description.coSimulation.modelIdentifier
    pairs = [(a, b) for a, y, b, _ in system.links if y == system.outputs[0]]
    contents = {
        "containerVersion": "0.1.0",
        "instantiationToken": "container",
        "fixedStepSize": H,
        "parallelDoStep": False,
        "components": [{**part, "name": f"c{k}"} for k in range(system.count)],
        "variables": [
            {"variableType": "Float64", "mappings": [[0, references[system.outputs[0]]]]}
        ],
        "connections": [
            {
                "variableType": "Float64",
                "srcComponent": a,
                "dstComponent": b,
                "srcValueReferences": [references[name] for name in system.outputs],
                "dstValueReferences": [references[name] for name in system.inputs],
                "size": len(system.outputs),
            }
            for a, b in pairs
        ],
    }
    (outer / "resources" / "container.json").write_text(json.dumps(contents), "utf-8")
    fmu = fmi2.FMU2Slave(
        guid="container",
        unzipDirectory=str(outer),
        modelIdentifier="container_fmu",
        instanceName="container",
    )
    try:
        fmu.instantiate()
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
    except Exception as error:
        raise RuntimeError(f"the container does not start: {error}") from error
    steps = count()

    def advance(n: int) -> None:
        for _ in range(n):
            fmu.doStep(next(steps) * H, H)

    return advance


def libcosimpy(system: Coupled, folder: Path) -> Advance:
    """The Open Simulation Platform's master, by its fixed-step algorithm."""
    del folder
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_step_size(round(H * 1e9))
    slaves = [
        execution.add_local_slave(CosimLocalSlave(str(system.fmu), f"c{k}"))
        for k in range(system.count)
    ]
    variables = execution.slave_variables(slaves[0])
    references = {v.name.decode(): v.reference for v in variables}
    for a, y, b, u in system.links:
        execution.connect_real_variables(slaves[a], references[y], slaves[b], references[u])
    return lambda n: execution.step(n)


def ecospy(system: Coupled, folder: Path, *, proxies: bool = False) -> Advance:
    """Ecos, by its fixed-step algorithm; with `proxies` each FMU in a process of its own."""
    del folder
    _load_threading_blocks()
    from ecospy import (
        EcosLib,
        EcosSimulation,
        EcosSimulationStructure,
    )

    EcosLib.set_log_level("warn")
    structure = EcosSimulationStructure()
    place = f"proxyfmu://localhost?file={system.fmu}" if proxies else str(system.fmu)
    for k in range(system.count):
        structure.add_model(f"c{k}", place)
    for a, y, b, u in system.links:
        structure.make_real_connection(f"c{a}::{y}", f"c{b}::{u}")
    simulation = EcosSimulation(structure=structure, step_size=H)
    simulation.init()
    return lambda n: simulation.step(n)


def c_loop(system: Coupled, folder: Path) -> Advance:
    """A loop in C, written for this system: the floor."""
    from benchmark.fmu_steps import FMI_HEADERS, compiler

    source = Path(__file__).parent / "native" / "macro_loop.c"
    library = folder / "macro_loop.so"
    flags = ["-O2", "-shared", "-fPIC", "-I", str(FMI_HEADERS)]
    subprocess.run([*(compiler() or ["cc"]), *flags, str(source), "-o", str(library)], check=True)
    fmus, references = _instances(system, folder)
    numbers = ctypes.c_uint * len(system.outputs)
    outputs = numbers(*(references[name] for name in system.outputs))
    inputs = numbers(*(references[name] for name in system.inputs))
    dll = fmus[0].dll
    functions = [
        ctypes.cast(getattr(dll, f"fmi2{name}"), ctypes.c_void_p)
        for name in ("GetReal", "SetReal", "DoStep")
    ]
    components = (ctypes.c_void_p * system.count)(*(fmu.component for fmu in fmus))
    begun = ctypes.c_long(0)

    def advance(n: int, _kept: list[Any] = fmus) -> None:
        ctypes.CDLL(str(library)).macro_loop(
            *functions, components, system.count, int(system.closed), len(system.outputs), outputs,
            inputs, ctypes.c_double(H), begun, n,
        )  # fmt: skip
        begun.value += n

    return advance


def _load_threading_blocks() -> None:
    """Load the library that Ecos needs, but does not bring; allow its proxies to be run."""
    ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), ctypes.RTLD_GLOBAL)
    package = importlib.util.find_spec("ecospy")
    if package and package.origin:
        (Path(package.origin).parent / "binaries" / "proxyfmu").chmod(0o755)


PEERS: dict[str, Callable[[Coupled, Path], Advance]] = {
    "loop in C": c_loop,
    "FMPy, container FMU": fmpy_container,
    "FMPy, functions with prepared arguments": fmpy_prepared,
    "FMPy, public methods": fmpy_lists,
    "libcosimpy": libcosimpy,
    "ecospy": ecospy,
}
