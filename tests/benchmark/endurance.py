"""Whether FMUs grow: `python -m benchmark.endurance [NATIVE [PYTHON]]`, run in `tests/`.

Resident memory before and after many instances, steps and saved states of native FMUs, FMI 2.0 and
3.0 (NATIVE instances and states, default 100,000, and ten times as many steps), of the Python FMU
(PYTHON, default 10,000), and of the smallest slave that PythonFMU itself builds, whose growth is
its own.
"""

from __future__ import annotations

import ctypes
import gc
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
from fmpy import fmi2, fmi3
from support.chains import sprung_chain

from m4e_fmi.fmu import build_fmu
from m4e_fmi.multibody import model_program

H = 0.01
WARM_UP = 20  # a part of this size goes first, uncounted
BARE = """\
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Bare(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x = 0.0
        self.register_variable(Real("x", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.x += step_size
        return True
"""


@dataclass(frozen=True)
class Growth:
    """Of resident memory [B] over `count` repetitions, and the time they took [s]."""

    what: str
    count: int
    size: int
    seconds: float

    @property
    def each(self) -> float:
        return self.size / self.count

    def __str__(self) -> str:
        return (
            f"{self.count:>9,} {self.what:<24} {self.size / 1e6:+8.2f} MB "
            f"{self.each:+10.2f} B each {self.seconds:8.1f} s"
        )


class Fmu:
    """An FMU in this process, through FMPy's loaded library."""

    def __init__(self, path: Path, folder: Path) -> None:
        fmpy.extract(str(path), str(folder))
        description: Any = fmpy.read_model_description(str(path), validate=False)
        self._version = description.fmiVersion[0]
        slave: Any = fmi3.FMU3Slave if self._version == "3" else fmi2.FMU2Slave
        self._fmu = slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self._begin()
        self.time = 0.0

    def _begin(self) -> None:
        self._fmu.instantiate()
        if self._version == "2":
            self._fmu.setupExperiment()
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()

    def instance(self) -> None:
        """Free the instance and make another, with its first step."""
        self.close()
        self._begin()
        self.time = 0.0
        self.step()

    def step(self) -> None:
        self._fmu.doStep(self.time, H)
        self.time += H

    def state(self) -> None:
        """Save, step, restore; serialise and back."""
        state = self._fmu.getFMUState()
        self._fmu.doStep(self.time, H)
        self._fmu.setFMUState(state)
        copy = self._fmu.deserializeFMUState(self._fmu.serializeFMUState(state))
        self._fmu.freeFMUState(state)
        self._fmu.freeFMUState(copy)

    def close(self) -> None:
        """Free the instance; FMPy's own function would unload the library, too."""
        getattr(self._fmu.dll, f"fmi{self._version}FreeInstance")(self._fmu.component)


def growth(what: str, action: Callable[[], None], count: int) -> Growth:
    for _ in range(max(1, count // WARM_UP)):
        action()
    before, began = resident(), time.perf_counter()
    for _ in range(count):
        action()
    return Growth(what, count, resident() - before, time.perf_counter() - began)


def resident() -> int:
    """Bytes of this process in memory, after what is free is given back."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def bare_fmu(folder: Path) -> Path:
    script = folder / "bare.py"
    script.write_text(BARE, encoding="utf-8")
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", script, "-d", folder]
    subprocess.run([*command, "--handle-state"], check=True, capture_output=True)
    return folder / "Bare.fmu"


def measured(native: int, python: int) -> dict[str, list[Growth]]:
    """Growth by kind of FMU: native, native 3 (FMI 3.0), Python, bare."""
    program = model_program(sprung_chain(3))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = {
            "native": build_fmu(program, folder / "native.fmu", native=True),
            "native 3": build_fmu(program, folder / "native_3.fmu", native=True, fmi="3"),
            "Python": build_fmu(program, folder / "python.fmu"),
            "bare": bare_fmu(folder),
        }
        found: dict[str, list[Growth]] = {}
        for kind, path in files.items():
            fmu = Fmu(path, folder / kind)
            count = native if kind.startswith("native") else python
            found[kind] = [growth("instances", fmu.instance, count)]
            found[kind].append(growth("steps", fmu.step, 10 * count))
            if kind != "bare":
                found[kind].append(growth("states", fmu.state, count))
            fmu.close()
    return found


def main(native: str = "100000", python: str = "10000") -> None:
    for kind, rows in measured(int(native), int(python)).items():
        for row in rows:
            print(f"{kind:<8} {row}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
