"""Many FMUs in one process, of one name and of different ones: each gives its bits as if alone."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from support.chains import cantilever, hanging_chain, sprung_chain
from support.driven import driven
from support.together import without_library

from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program

ROOT = Path(__file__).parents[2]
FILES = (
    *sorted((ROOT / "examples/paper_cases").glob("*.model.yaml")),
    ROOT / "examples/double_pendulum/double_pendulum.model.yaml",
    ROOT / "examples/moored_buoy/buoy.model.yaml",
    ROOT / "examples/flexible_pendulum/mass.model.yaml",
    ROOT / "examples/sphere_decay/sphere.model.yaml",
)
SEEDS = ("1", "2")


def programs() -> dict[str, Program]:
    """Twenty different models, and versions of two: some of one name, some of one shape."""
    models = {path.name: load_model(path) for path in FILES}
    models |= {f"hanging_{n}": hanging_chain(n) for n in (1, 2, 4)}  # all of the name "chain"
    models |= {f"sprung_{n}": sprung_chain(n) for n in (1, 2, 3)}
    models |= {
        f"cantilever_{n}": cantilever(n, length=2.0, rigidity=50.0, density=3.0) for n in (1, 2, 3)
    }
    models["longer"] = hanging_chain(4, length=0.6)  # another version of hanging_4
    found = {name: model_program(model) for name, model in models.items()}
    found["driven"] = driven()
    found["driven_2"] = driven().with_start({"stiffness": 31.0})  # differs in a start value only
    return found


def build(folder: Path) -> None:
    """A native and a Python FMU of each; those of chains integrate in Python, with no library."""
    for name, program in programs().items():
        build_fmu(program, folder / f"{name}_native.fmu", native=True)
        python = build_fmu(program, folder / f"{name}_python.fmu")
        if program.name == "chain":
            without_library(python)


def compared(folder: Path) -> dict:
    command = [sys.executable, "-m", "support.together", str(folder), *SEEDS]
    tests = Path(__file__).parents[1]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tests, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_all_together(tmp_path: Path) -> None:
    build(tmp_path)
    found = compared(tmp_path)
    assert found["fmus"] >= 40
    assert found["values"] > 10_000
    assert found["differences"] == []
