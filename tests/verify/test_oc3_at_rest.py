"""OC3-Hywind with its lines at rest, beside the example that puts the parts together by hand."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.cosim import load_system, system_program

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
