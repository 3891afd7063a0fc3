"""OC3-Hywind on three lines in an irregular sea: one sea, energy, loads of waves on lines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run

EXAMPLE = Path(__file__).parents[2] / "examples" / "oc3_hywind"
STOP = 60.0


@pytest.mark.verifies(
    "energy over the connections of OC3-Hywind in a sea, lost or made",
    analytic="conservation", tolerance="1e-3 of the gross",
)  # fmt: skip
def test_no_energy_is_lost_between_spar_water_and_lines(tmp_path: Path) -> None:
    """The fairleads are 70 m deep: waves of 10 s move the water around the lines by little."""
    tensions = {}
    for waves in ("*sea", "none"):
        for path in EXAMPLE.glob("*.yaml"):
            text = path.read_text("utf-8").replace("panels: 800", "panels: 200")
            text = text.replace("waves: *sea", f"waves: {waves}")
            (tmp_path / path.name).write_text(text, "utf-8")
        system = load_system(tmp_path / "in_waves.yaml")
        system = replace(system, simulation=replace(system.simulation, stop_time=STOP))
        prepared = prepare(system, build_directory=tmp_path)
        assert [line for line in prepared.warnings if "differ" in line] == []
        outcome = run(prepared, results=tmp_path / "r.nc")
        assert len(outcome.energy) == 4
        assert max(abs(bond.relative) for bond in outcome.energy) < 1e-3
        tensions[waves] = outcome.results()["mooring.l1.fairlead_tension"].values
    change = np.abs(tensions["*sea"] - tensions["none"]).max()
    assert 0 < change < 1e-3 * np.ptp(tensions["none"])
