"""Runs that end before their sea has grown to its height."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cosim import load_system, prepare

SEA = """name: sea
components:
  sea:
    kind: sea
    water: {density: 1025, depth: 40, gravity: 9.81}
    waves: {spectrum: jonswap, significant_height: 2, peak_period: 8, ramp_time: 16}
    points: {gauge: [25, 0]}
simulation: {stop_time: %s, step_size: 0.1}
"""


@pytest.mark.parametrize(("stop", "told"), [(12, True), (16, True), (16.5, False)])
def test_a_run_within_the_ramp_is_told(tmp_path: Path, stop: float, told: bool) -> None:
    path = tmp_path / "sea.system.yaml"
    path.write_text(SEA % stop, encoding="utf-8")
    system = load_system(path)
    warnings = prepare(system, build_directory=tmp_path).warnings
    ramp = next((w for w in warnings if "ends within the ramp of the sea" in w), "")
    assert (f"the run of {stop:g} s" in ramp and "ramp_time = 16 s" in ramp) == told
    shorter = system.changed(start={"sea.wave.ramp_time": 5.0})
    assert not any("ramp" in w for w in prepare(shorter, build_directory=tmp_path).warnings)
