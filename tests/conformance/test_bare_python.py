"""FMUs run where nothing is installed but Python: neither m4e_fmi nor pythonfmu nor NumPy."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from support.chains import sprung_chain
from support.fmu_instances import Instance

from m4e_fmi.fmu import build_fmu
from m4e_fmi.multibody import model_program

HOST = Path(__file__).parents[1] / "support" / "bare_host.py"
STEPS, H = 50, 0.01  # as the host
START = {"joint.j0.effort": 3.0}
NAMES = [f"joint.j{k}.{c}" for k in range(3) for c in "qu"]


def interpreter(minor: int) -> str:
    """Python 3.`minor`, from the path or from pyenv; skips where there is none."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for found in (shutil.which(f"python3.{minor}"), *pyenv.glob(f"3.{minor}.*/bin/python3")):
        if found and not subprocess.run([found, "-c", ""], capture_output=True).returncode:
            return str(found)
    pytest.skip(f"there is no Python 3.{minor} here")


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fmus")
    program = model_program(sprung_chain(3))
    native = build_fmu(program, folder / "native.fmu", native=True)
    python = build_fmu(program, folder / "python.fmu")
    return {"native": native, "python": python}


@pytest.fixture(scope="module")
def here(fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> list[float]:
    """What the native FMU gives in this process."""
    with Instance(fmus["native"], tmp_path_factory.mktemp("here") / "x") as instance:
        instance.initialise(START)
        for k in range(STEPS):
            instance.step(k * H, H)
        return instance.get(NAMES)


def run(minor: int, fmu: Path) -> subprocess.CompletedProcess[str]:
    # -I and -S: no site-packages, no environment, no folder of this project
    command = [interpreter(minor), "-I", "-S", str(HOST), str(fmu)]
    command += [json.dumps(START), json.dumps(NAMES)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("minor", range(10, 14))
def test_bare_python(minor: int, fmus: dict[str, Path], here: list[float]) -> None:
    found = {}
    for kind, fmu in fmus.items():
        done = run(minor, fmu)
        assert done.returncode == 0, done.stderr
        found[kind] = json.loads(done.stdout)
    assert found["native"] == found["python"] == here


def test_a_python_that_is_too_old(fmus: dict[str, Path]) -> None:
    done = run(9, fmus["python"])
    assert done.returncode == 1
    assert "this FMU needs Python 3.10 or newer; here is 3.9." in done.stderr
