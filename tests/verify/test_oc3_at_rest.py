"""OC3-Hywind with its lines at rest, beside the example that puts the parts together by hand."""

from __future__ import annotations

import runpy
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.cosim import load_system, prepare, system_program
from m4e_fmi.cosim.composition import parts

EXAMPLE = Path(__file__).parents[2] / "examples" / "oc3_hywind"
STATES = {
    "surge": "x",
    "sway": "y",
    "heave": "z",
    "roll": "rotation_x",
    "pitch": "rotation_y",
    "yaw": "rotation_z",
}


def test_periods_and_damping_are_those_of_the_example(tmp_path: Path) -> None:
    """Its lines have 100 segments instead of 20: of second order, a few 1e-4 of a period."""
    system = load_system(EXAMPLE / "system.yaml")
    whole = system_program(system, settled=["mooring"], build_directory=tmp_path)
    linear = linearize(whole, at=equilibrium(whole))
    found = modes(linear)
    names = [v.name for v in linear.states]
    for motion, by_hand in runpy.run_path(str(EXAMPLE / "natural_periods.py"))["modes"]().items():
        k = found.participation[names.index(f"hywind.body.spar.{STATES[motion]}")].argmax()
        value = found.eigenvalues[k]
        assert 2 * np.pi / abs(value) == pytest.approx(by_hand.period, rel=2e-3)
        assert -value.real / abs(value) == pytest.approx(by_hand.damping_ratio, rel=1e-2)


def test_a_thrust_of_800_kn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within 10 s of CPU; settled, its FMU comes to 1e-5 of its forces, which offsets follow."""
    for file in ("system.yaml", "hywind.model.yaml"):
        shutil.copy(EXAMPLE / file, tmp_path)
    thrust = "  thrust: {type: body_force, body: rotor, force: [8.0e+5, 0, 0]}\n"
    with (tmp_path / "hywind.model.yaml").open("a", encoding="utf-8") as model:
        model.write(thrust)
    system, found = load_system(tmp_path / "system.yaml"), []
    prepare(system, build_directory=tmp_path)
    for statics in (parts._statics, lambda *_: lambda _: None):
        monkeypatch.setattr(parts, "_statics", statics)
        before = time.process_time()
        rest = equilibrium(system_program(system, settled=["mooring"], build_directory=tmp_path))
        found.append((rest, time.process_time() - before))
    (exact, cost), (settled, _) = found
    assert cost < 10.0
    for name in ("x", "z"):
        name = f"hywind.body.spar.{name}"
        assert exact[name] == pytest.approx(settled[name], abs=1e-5 * 30.0)
    for k in (1, 2, 3):
        name = f"mooring.l{k}.fairlead_tension"
        assert exact[name] == pytest.approx(settled[name], rel=2e-5)
