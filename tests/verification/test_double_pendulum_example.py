"""The paper's double pendulum (section 5.1): one trajectory from every way to compute it."""

from __future__ import annotations

import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest

from m4e_fmi.fmu import build_fmu
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import Simulation, simulate

FOLDER = Path(__file__).parents[2] / "examples" / "double_pendulum"
YAML = FOLDER / "double_pendulum.model.yaml"
STOP, INTERVAL = 10.0, 0.01  # s
STATES = ("joint.shoulder.q", "joint.shoulder.u", "joint.elbow.q", "joint.elbow.u")


@pytest.fixture(scope="module")
def python_model():
    sys.path.insert(0, str(FOLDER))
    try:
        import double_pendulum  # pyrefly: ignore[missing-import]
    finally:
        sys.path.remove(str(FOLDER))
    return double_pendulum.model()


@pytest.fixture(scope="module")
def reference() -> Simulation:
    return simulate(YAML, stop_time=STOP, output_interval=INTERVAL, tolerance=1e-12)


def test_yaml_and_python_are_one_model(python_model):
    from_yaml = simulate(YAML, stop_time=STOP, output_interval=INTERVAL)
    from_python = simulate(python_model, stop_time=STOP, output_interval=INTERVAL)
    for name in STATES:
        # the same operations in the same order: the same bits
        assert np.array_equal(from_yaml[name], from_python[name])


@pytest.mark.verifies(
    "double pendulum of section 5.1, angles after 10 s",
    independent="SymPy's Lagrange equations, SciPy's DOP853 at 1e-11",
    tolerance="1e-8 rad",
)
def test_independent_solution(reference):
    """SymPy's Lagrange equations of the same system, integrated by SciPy's DOP853 at 1e-11."""
    assert reference["joint.shoulder.q"][-1] == pytest.approx(-2.20437786, abs=1e-8)
    assert reference["joint.elbow.q"][-1] == pytest.approx(-2.04149480, abs=1e-8)


@pytest.mark.verifies(
    "its FMU in FMPy against the simulation in process",
    independent="FMPy's master",
    tolerance="1e-6",
)
def test_fmu_follows_the_simulation(tmp_path, reference):
    fmu = build_fmu(model_program(YAML), tmp_path / "double_pendulum.fmu")
    result = fmpy.simulate_fmu(
        str(fmu), stop_time=STOP, output_interval=INTERVAL, relative_tolerance=1e-8
    )
    assert result["time"] == pytest.approx(reference.time, abs=1e-12)
    for name in STATES:
        # local errors of 1e-8 per step and at most 1000 steps, on a motion that is damped
        assert result[name] == pytest.approx(reference[name], abs=1e-6)
