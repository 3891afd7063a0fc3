"""The balance of energy in every system and model of examples/: found by their files.

Of coupled systems the models' energy is compared with what came over their interfaces and from
their loads, by outputs of the run, and the master's own balance of its connections is asserted too.
Meshes are coarse and runs short here; tests/verify has the whole ones.
"""

from __future__ import annotations

import importlib.util
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.energy_lines import LIMIT, energy_lines
from support.example_systems import EXAMPLES, example_files, hydraulic_kinds

from m4e_fmi.cosim import load_system
from m4e_fmi.model import Model, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import simulate

STEPS, LONGEST = 400, 10.0  # of a run, s
SCRIPTS = [s for s in example_files("*.py") if "def model()" in (EXAMPLES / s).read_text("utf-8")]


@pytest.fixture(scope="module", autouse=True)
def _kinds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with hydraulic_kinds(tmp_path_factory.mktemp("site")):
        yield


@pytest.mark.verifies(
    "energy of the models in every system of examples/, over all that went through interfaces",
    analytic="work of the interfaces' forces and of loads",
    tolerance="1e-3",
)
@pytest.mark.parametrize("name", example_files("system*.yaml"))
def test_systems(name: str, tmp_path: Path) -> None:
    copy = tmp_path / "example"
    shutil.copytree((EXAMPLES / name).parent, copy)
    file = copy / Path(name).name
    file.write_text(_coarse(file.read_text("utf-8")), "utf-8")
    system = load_system(file)
    stop = min(STEPS * system.simulation.step_size, LONGEST, system.simulation.stop_time)
    lines = energy_lines(system.changed(stop_time=stop), tmp_path)
    assert lines.interfaces
    assert np.abs(lines.residual).max() < LIMIT * lines.gross
    assert lines.coupling < LIMIT * lines.gross
    # each of them counts: without the one with the most work the balance does not close
    largest = max(lines.interfaces, key=lambda i: float(np.abs(lines.integral(i.power)).max()))
    others = replace(lines, interfaces=[i for i in lines.interfaces if i is not largest])
    assert np.abs(others.residual).max() > 10 * LIMIT * lines.gross


def _coarse(text: str) -> str:
    """A system with few panels, frequencies and segments of lines.

    Those in the plane have them only where their file chooses frequencies:
    others are computed in other tests, too.
    """
    panels, count = (100, 12) if "dimensions: 3" in text else (200, 16)
    coarse = re.sub(r"panels: \d+", f"panels: {panels}", text)
    if "frequencies:" in text:
        return re.sub(r"(frequencies: \{.*)count: \d+", rf"\g<1>count: {count}", coarse)
    if "dimensions: 3" not in text:
        return text
    few = f"kind: hydrodynamics\n    frequencies: {{count: {count}}}"
    coarse = re.sub(r"segments: \d+", "segments: 8", coarse)
    return coarse.replace("kind: hydrodynamics", few)


@pytest.mark.verifies(
    "energy of every model of examples/, by itself", analytic="work of its loads", tolerance="1e-3"
)
@pytest.mark.parametrize("name", [*example_files("*.model.yaml", "*.urdf"), *SCRIPTS])
def test_models(name: str) -> None:
    """For 1 s from its start, with a push where that is at rest."""
    program = model_program(_model(EXAMPLES / name))
    masses = {v.name: 1e5 for v in program.parameters if v.name.endswith(".neutral_mass")}
    scale = 0.0
    push = next(v.name for v in program.states if v.unit == "m/s" or v.unit == "rad/s")
    for start in (masses, {**masses, push: 0.3}):
        run = simulate(program, stop_time=1.0, tolerance=1e-6, start_values=start)
        assert run.energy is not None
        assert abs(run.energy.relative) < LIMIT
        scale = run.energy.scale
    assert scale > 0.0


def _model(path: Path) -> Model:
    """The model in a file, or that a script makes."""
    if path.suffix != ".py":
        return load_model(path)
    spec = importlib.util.spec_from_file_location(f"example_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.model()
