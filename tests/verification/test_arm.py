"""The arm of the examples: its coupled motion is that of one system of equations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.files.document import Document
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.runtime.engine import Engine

EXAMPLE = Path(__file__).parents[2] / "examples" / "arm"
JOINTS = [f"j{k}" for k in range(1, 8)]


def reference(times: np.ndarray) -> np.ndarray:
    """Angles (7, n_times) of arm and controller together, by SciPy."""
    config = Document.load(EXAMPLE / "system.yaml").data["components"]["controller"]
    gains = config["joints"]
    target, kp, ki, kd = (
        np.array([gains[j][key] for j in JOINTS], dtype=float)
        for key in ("target", "proportional", "integral", "derivative")
    )
    model = load_model(EXAMPLE / "arm.urdf")
    program = model_program(model, inputs=[f"joint.{j}.effort" for j in JOINTS])
    engine = Engine(program, outputs=())

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        x, total = y[:14], y[14:]
        s = min(t / config["duration"], 1.0)
        wanted = target * (10 * s**3 - 15 * s**4 + 6 * s**5)
        speed = target * 30 * s**2 * (1 - s) ** 2 / config["duration"]
        engine.set_inputs(kp * (wanted - x[::2]) + ki * total + kd * (speed - x[1::2]))
        return np.concatenate([engine.rates(t, x), wanted - x[::2]])

    found = solve_ivp(
        rates, (0, times[-1]), np.zeros(21), method="DOP853", rtol=1e-9, atol=1e-10, t_eval=times
    )
    return found.y[:14:2]


@pytest.mark.verifies(
    "a coupled arm and its controller", independent="one system of equations, SciPy's DOP853",
    tolerance="3 times the stated coupling error",
)  # fmt: skip
def test_coupled_arm(tmp_path: Path) -> None:
    outcome = run(prepare(load_system(EXAMPLE / "system.yaml")), results=tmp_path / "arm.nc")
    results = outcome.results()
    expected = reference(np.asarray(results.time))
    assert not isinstance(outcome.certificate, str)
    worst = max(error.error for error in outcome.certificate.errors)
    assert worst < 1e-4
    for name, angles in zip(JOINTS, expected, strict=True):
        found = np.asarray(results[f"arm.joint.{name}.q"])
        assert np.abs(found - angles).max() <= 3 * worst * np.ptp(angles) + 1e-9, name
