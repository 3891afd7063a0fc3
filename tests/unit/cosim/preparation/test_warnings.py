"""Runs too short for their sea are told before the run."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cosim import prepare

SEA = """\
name: sea
components:
  sea:
    kind: sea
    water: {{density: 1025, depth: 40, gravity: 9.81}}
    waves: {{spectrum: jonswap, significant_height: 2, peak_period: 8, ramp_time: 16}}
    points: {{gauge: [25, 0]}}
    start: {{{start}}}
simulation: {{stop_time: {stop}, step_size: 0.1}}
"""


@pytest.mark.parametrize(
    ("stop", "start", "told"),
    [(12, "", "16 s"), (16, "", "16 s"), (16.5, "", ""), (12, "wave.ramp_time: 5", "")],
)
def test_a_run_within_the_ramp_of_its_sea(
    tmp_path: Path, stop: float, start: str, told: str
) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(SEA.format(stop=stop, start=start), encoding="utf-8")
    warnings = prepare(path, build_directory=tmp_path).warnings
    ramps = [line for line in warnings if "ends within the ramp" in line]
    assert len(ramps) == bool(told)
    assert all(f"the run of {stop:g} s" in line and told in line for line in ramps)
