"""Examples with mooring lines: a taut tether with a take-off, a platform that loses a chain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.results.results_file import Results

EXAMPLES = Path(__file__).parents[2] / "examples"
FEW = {"panels: 400": "panels: 150", "panels: 700": "panels: 250"}
FREQUENCIES = "    frequencies: {maximum: 2.4, count: 12}\n"
PULL = 1025 * 9.81 * np.pi * 3**2 * 3 - 60000 * 9.81  # N: buoyancy of the float less its weight
PUBLISHED = 1.107e6  # N, fairlead tension of OC4 at rest: NREL/TP-5000-60601, 2014


def results(name: str, folder: Path, stop: float, changes: dict[str, str]) -> Results:
    """Of the example `name` with few panels and frequencies, until `stop` [s]."""
    for path in (EXAMPLES / name).glob("*.yaml"):
        text = path.read_text("utf-8")
        for old, new in (FEW | changes).items():
            text = text.replace(old, new)
        (folder / path.name).write_text(text, "utf-8")
    system = load_system(folder / "system.yaml").changed(stop_time=stop)
    prepared = prepare(system, build_directory=folder)
    return run(prepared, results=folder / "r.nc", certify=False).results()


@pytest.mark.verifies(
    "mean tension of a taut tether in waves",
    analytic="buoyancy of the float less its weight",
    tolerance="5e-3",
)
def test_a_taut_tether_carries_what_the_float_displaces(tmp_path: Path) -> None:
    found = results("taut_tether", tmp_path, 60.0, {"    bodies:\n": FREQUENCIES + "    bodies:\n"})
    tension = found["mooring.tether.fairlead_tension"][found.time > 18.0]
    assert np.mean(tension) == pytest.approx(PULL, rel=5e-3)
    assert np.min(tension) > 0.5 * PULL  # never slack
    assert np.ptp(found["converter.body.carriage.z"]) > 0.5


@pytest.mark.verifies(
    "tension of the lines of OC4-DeepCwind at rest",
    published="Robertson et al., NREL/TP-5000-60601, 2014",
    tolerance="1e-2",
)
def test_a_platform_that_loses_a_chain_is_drawn_away_by_the_others(tmp_path: Path) -> None:
    """They pull as the lost one did; waves and all columns but a round one are left out."""
    text = (EXAMPLES / "semi_submersible" / "system.yaml").read_text("utf-8")
    first, last = text.index("          union:"), text.index("        center_of_gravity")
    changes = {
        text[first:last]: "          cylinder: {radius: 14.69, draft: 20}\n",
        "significant_height: 6": "significant_height: 1.0e-6",
        "at: 100 s": "at: 1 s",
    }
    found = results("semi_submersible", tmp_path, 2.0, changes)
    for k in (1, 2, 3):
        tension = found[f"mooring.line_{k}.fairlead_tension"]
        assert tension[0] == pytest.approx(PUBLISHED, rel=1e-2)
    after = found.time > 1.0
    assert np.all(found["mooring.line_2.fairlead_tension"][after] == 0.0)
    assert np.all(found["mooring.line_2.anchor_tension"][after] > 0.0)
    pull = np.sum([found[f"mooring.f{k}.force_x"] for k in (1, 2, 3)], axis=0)
    assert pull[0] == pytest.approx(0.0, abs=1e-3 * PUBLISHED)
    assert pull[after] == pytest.approx(-found["mooring.f2.force_x"][0], rel=1e-2)
    assert np.all(np.diff(found["semi.body.platform.vx"][after]) > 0.0)
