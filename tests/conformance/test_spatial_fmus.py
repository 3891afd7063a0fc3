"""FMUs of models in space: right by the validation, their attitudes those of the simulation."""

from __future__ import annotations

import shutil
from pathlib import Path

import fmpy
import numpy as np
import pytest

from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.validation import validate_fmu
from m4e_fmi.model import Body, Bushing, Joint, Model, Point
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import simulate

STATES = ("e0", "e1", "e2", "e3", "omega_x", "omega", "omega_z")


def crane() -> Model:
    """A turning arm with a load on a ball joint, and a free hull on a spring."""
    return Model(
        "crane",
        {
            "arm": Body(2.0, (1.0, 2.0, 1.5)),
            "load": Body(1.0, (0.2, 0.3, 0.25, 0.02, 0.01, 0.03)),
            "hull": Body(3.0, (1.0, 1.2, 1.4)),
        },
        {
            "swing": Joint("revolute", "arm", axis=(0.2, 0, 1), joint_to_child=(1, 0, 0)),
            "hook": Joint(
                "spherical", "load", "arm", (1, 0, 0), (0, 0.1, -1),
                initial={"phi": 0.3, "psi": 0.5, "omega": 0.4},
            ),
            "sea": Joint("floating", "hull", initial={"theta": 0.2, "vy": 0.3, "omega_z": 0.5}),
        },
        points={"deck": Point("hull", (0.5, 0.2, 0.3)), "buoy": Point("ground", (0, 0, 1))},
        loads={"line": Bushing(("deck", "buoy"), 20.0, 1.0)},
        dimensions=3,
    )  # fmt: skip


@pytest.mark.parametrize(("native", "fmi"), [(False, "2"), (True, "2"), (True, "3")])
def test_validation_finds_nothing_wrong(tmp_path: Path, native: bool, fmi: str) -> None:
    if native and shutil.which("cc") is None:
        pytest.skip("no C compiler")
    fmu = build_fmu(model_program(crane()), tmp_path / "crane.fmu", native=native, fmi=fmi)
    report = validate_fmu(fmu)
    assert [f for f in report.findings if f.severity != "note"] == []


@pytest.mark.parametrize("native", [False, True])
def test_fmpy_gives_the_motion_of_the_simulation(tmp_path: Path, native: bool) -> None:
    model = crane()
    fmu = build_fmu(model_program(model), tmp_path / "crane.fmu", native=native)
    exact = simulate(model, stop_time=2.0, output_interval=0.1, tolerance=1e-11)
    names = [f"{owner}.{state}" for owner in ("joint.hook", "body.hull") for state in STATES]
    found = fmpy.simulate_fmu(
        str(fmu), stop_time=2.0, step_size=0.1, output_interval=0.1, output=names,
        fmi_type="CoSimulation",
    )  # fmt: skip
    for name in names:
        np.testing.assert_allclose(found[name], exact[name], atol=1e-6)
    length = sum(found[f"body.hull.e{k}"] ** 2 for k in range(4))
    assert np.abs(length - 1).max() < 1e-7
