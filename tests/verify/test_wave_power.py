"""Mean power in a sea by statistical linearisation, beside twenty hours of simulated seas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.floating_buoy import held_buoy

from m4e_fmi.analysis import equilibrium
from m4e_fmi.analysis.response import sea_response
from m4e_fmi.cosim import load_system, system_in_waves, system_program
from m4e_fmi.simulate import simulate

HEIGHT, PERIOD, HOURS, RAMP = 2.0, 7.5, 20, 300.0
POWER = "generator.power"


def test_the_mean_power_of_twenty_hours(tmp_path: Path) -> None:
    """Random frequencies and phases, a seed each, in the system's own waves."""
    powers = []
    for seed in range(1, HOURS + 1):
        sea = f"significant_height: {HEIGHT}, peak_period: {PERIOD}, seed: {seed}"
        sea = f"{{spectrum: jonswap, {sea}}}"
        program = system_program(load_system(held_buoy(tmp_path, sea)))
        run = simulate(program, stop_time=3600.0 + RAMP, output_interval=0.25, tolerance=1e-6)
        powers.append(float(run[POWER][np.asarray(run.time) > RAMP].mean()))
    waves = system_in_waves(load_system(tmp_path / "system.yaml"), highest=2.5 * 2 * np.pi / PERIOD)
    found = sea_response(
        waves,
        equilibrium(waves.program),
        waves.jonswap(HEIGHT, PERIOD, 3.3, 0.0),
        outputs=[POWER],
    )
    spread = np.std(powers) / np.sqrt(HOURS)
    print(f"simulated {np.mean(powers):.0f} ± {spread:.0f} W, linearised {found.mean(POWER):.0f} W")
    assert found.mean(POWER) == pytest.approx(float(np.mean(powers)), rel=0.03)
