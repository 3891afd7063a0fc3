"""How large results become is told before the run."""

from __future__ import annotations

from dataclasses import replace

import pytest

from m4e_fmi.cosim import Simulation
from m4e_fmi.cosim.wiring.prepared import LARGE, volume

COLUMNS = 4


@pytest.mark.parametrize(
    ("bytes_", "told"),
    [(0.99 * LARGE, ""), (1.1 * LARGE, "1.1 GB; a longer output_interval")],
)
def test_what_is_told(bytes_: float, told: str) -> None:
    steps = round(bytes_ / 8 / COLUMNS)
    settings = Simulation(steps * 0.001, 0.001)
    size, text = volume(settings, COLUMNS)
    assert size == pytest.approx(bytes_, rel=1e-6)
    assert told in text
    assert ("a longer output_interval" in text) == bool(told)
    assert "at least" not in text
    assert "at least" in volume(replace(settings, coupling_tolerance=1e-4), COLUMNS)[1]
